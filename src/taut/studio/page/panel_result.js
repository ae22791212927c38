// @ts-check
// What came of planning: the certificate and its numbers, costs against the bound, conflicts, notes; or why not.

import { clear, element } from "studio/dom.js";
import { lengthText } from "studio/grid.js";
import { icon } from "studio/icons.js";
import { duration } from "studio/status.js";

/** Rows of conflicts and robots that are shown before "Show all". */
const FEW = 12;

/**
 * @param {{store: import("studio/store.js").Store, player: import("studio/player.js").Player, commands: any}} page
 * @returns {HTMLElement}
 */
export function createResult({ store, player, commands }) {
  const root = element("div", { class: "result" });
  const open = new Set();
  let frame = 0;

  /** Go to a place of the map, and to a time of the plan. @param {{time?: number | null, place?: any}} spot */
  const go = ({ time = null, place = null }) => {
    if (time !== null) {
      player.pause();
      player.seek(time);
    }
    if (place) commands.reveal(place);
    store.set({ focus: Object.freeze({ time, place }) });
  };

  function refresh() {
    frame = 0;
    const { answer, planning, problems, scene, tab } = store.get();
    if (tab !== "plan") return;
    clear(root);
    if (problems.length) root.append(problemCard(problems, go, store));
    if (planning.state === "failed" && !covers(problems, planning.wrong)) root.append(failureCard(planning.wrong, go));
    if (!answer) {
      if (!problems.length && planning.state !== "failed") root.append(emptyCard(scene, planning));
      return;
    }
    const { certificate, conflicts, notes } = answer;
    const failed = planning.state === "failed";
    const outcome = element("section", { class: failed ? "outcome old" : "outcome" },
      verdictCard(answer, planning, go));
    if (certificate) outcome.append(certificateTable(certificate, go));
    outcome.append(fold("Robots", answer.plan.robots, (robot) => fate(robot, answer)));
    if (conflicts.length) outcome.append(conflictList(conflicts));
    if (notes.length) outcome.append(fold("Notes", notes, (note) => element("li", {}, note)));
    root.append(outcome);
  }

  /** Conflicts and what their marks on the map mean. @param {any[]} conflicts */
  function conflictList(conflicts) {
    const list = fold("Conflicts resolved", conflicts, (each) => spot(each.sentence, each.time, () => go(each),
      (on) => store.set({ hover: on ? { kind: "conflict", name: each.robot, conflict: each } : null })));
    list.querySelector("summary")?.after(element("p", { class: "legend" },
      element("span", { class: "mark" }), "waited", element("span", { class: "mark turned" }), "took another way"));
    return list;
  }

  /** How one robot fares. @param {any} robot @param {any} answer */
  function fate({ name, stamps }, { detours, shortest }) {
    const arrival = `arrives at ${figure(stamps[stamps.length - 1][0])} s`;
    const way = shortest[name] === undefined ? "" : `shortest way ${figure(shortest[name])} m`;
    return spot([name, arrival, way, detours[name]].filter(Boolean).join(", "), null,
      () => store.set({ selection: Object.freeze([{ kind: "robot", name }]) }),
      (on) => store.set({ hover: on ? { kind: "robot", name } : null }));
  }

  /**
   * A list whose lines are made when it is opened.
   * @param {string} title
   * @param {any[]} all
   * @param {(each: any) => HTMLElement} line
   */
  function fold(title, all, line) {
    const list = element("ul", { class: "spots" });
    const fill = (/** @type {number} */ many) => list.replaceChildren(...all.slice(0, many).map(line),
      ...(many < all.length ? [element("li", {}, element("button", { type: "button", class: "button small ghost",
        onclick: () => fill(all.length) }, `Show all ${all.length}`))] : []));
    const toggled = (/** @type {Event} */ event) => {
      const shown = /** @type {HTMLDetailsElement} */ (event.target).open;
      if (shown) open.add(title);
      else open.delete(title);
      if (shown && !list.firstChild) fill(FEW);
    };
    if (open.has(title)) fill(FEW);
    return element("details", { class: "group", open: open.has(title), ontoggle: toggled },
      element("summary", {}, `${title} (${all.length})`), list);
  }

  const later = () => {
    frame ||= requestAnimationFrame(refresh);
  };
  store.on(["tab"], refresh);
  store.on(["answer", "planning", "problems", "scene"], (now, before) => {
    const same = now.answer === before.answer && now.problems === before.problems &&
      now.planning.state === before.planning.state && now.planning.wrong === before.planning.wrong;
    if (!same) later();
  });
  later();
  return root;
}

/** Whether the problems listed say already what planning found wrong. @param {any[]} problems @param {any} wrong */
const covers = (problems, wrong) => problems.some(({ message }) => message === wrong?.message);

/** @param {any[]} problems @param {(spot: any) => void} go @param {import("studio/store.js").Store} store */
function problemCard(problems, go, store) {
  const choose = (/** @type {any} */ { names, kind, place }) => {
    const known = kind === "robot" ? "robot" : kind === "obstacle" ? "obstacle" : null;
    if (known && names.length) {
      store.set({ selection: Object.freeze(names.map((/** @type {string} */ name) => ({ kind: known, name }))) });
    }
    go({ place });
  };
  return element("section", { class: "card bad", "aria-label": "Problems" },
    element("h3", {}, icon("warn", 16), problems.length === 1 ? "One problem" : `${problems.length} problems`),
    element("ul", { class: "spots" }, ...problems.map((each) => spot(each.message, null, () => choose(each)))));
}

/** @param {any} wrong @param {(spot: any) => void} go */
function failureCard(wrong, go) {
  const sentences = (wrong?.why?.sentences ?? []).filter((/** @type {string} */ said) => !wrong.message.includes(said));
  const at = wrong?.place ?? wrong?.why?.gap?.place ?? null;
  return element("section", { class: "card bad", "aria-label": "Why there is no plan" },
    element("h3", {}, icon("warn", 16), "No plan"),
    element("p", {}, wrong?.message ?? "Planning failed."),
    ...[...sentences, ...remedy(wrong)].map((/** @type {string} */ said) => element("p", {}, said)),
    at ? element("button", { type: "button", class: "button small",
      onclick: () => go({ place: at, time: wrong.time }) }, "Show where") : null);
}

/** What would make room where there is too little. @param {any} wrong @returns {string[]} */
function remedy(wrong) {
  const gap = wrong?.why?.gap;
  const missing = gap ? gap.needed - gap.room : 0;
  if (!(missing > 0)) return [];
  const name = wrong.names?.[0] ?? "the robot";
  return [`Make that gap ${lengthText(roundedUp(missing))} wider, make ${name} smaller, or move its start or goal.`];
}

/** A little more than a length, in two digits: what is made wider by that is wide enough. @param {number} metres */
function roundedUp(metres) {
  const digit = 10 ** (Math.floor(Math.log10(metres)) - 1);
  return Math.ceil(metres / digit + 1e-9) * digit;
}

/** @param {any} scene @param {any} planning */
function emptyCard(scene, planning) {
  const text = !scene?.robots.length ? "Put in a robot, and its plan appears here."
    : planning.running ? "Planning…" : "No plan yet.";
  return element("p", { class: "group quiet" }, text);
}

/** @param {any} answer @param {any} planning @param {(spot: any) => void} go */
function verdictCard({ certificate, metrics, improved, opened }, { state, seconds }, go) {
  const old = state === "stale" || state === "failed";
  const ok = certificate?.ok;
  const title = old ? "Last good plan" : ok ? "Certified" : certificate ? "Not certified" : "Plan from file";
  const took = opened ? "from a file" : `${improved ? "improved" : "planned"} in ${duration(seconds ?? 0)}`;
  const card = element("section", { class: `card ${old ? "stale" : ok ? "good" : certificate ? "bad" : ""}`,
    id: "verdict", "aria-label": "Result" },
  element("h3", {}, ok && !old ? icon("check", 16) : null, title, element("span", { class: "quiet number" }, took)));
  const rows = metrics ? costRows(metrics) : [];
  if (rows.length) card.append(element("dl", { class: "figures number" }, ...rows.flatMap(([name, value, hint]) =>
    [element("dt", { title: hint ?? null }, name), element("dd", {}, value)])));
  for (const problem of certificate?.problems ?? []) card.append(element("ul", { class: "spots" },
    spot(problem.text, problem.time, () => go(problem))));
  return card;
}

/** @param {any} metrics @returns {[string, string, string?][]} */
function costRows({ sum_of_costs: sum, makespan, length, lower_bound: bound, above }) {
  /** @type {[string, string, string?][]} */
  const rows = [["Sum of costs", `${figure(sum)} s`], ["Makespan", `${figure(makespan)} s`],
    ["Length", `${figure(length)} m`]];
  if (bound) {
    const of = bound.of === "makespan" ? "the makespan" : "the sum of costs";
    rows.push([`Bound (${bound.model})`, `${figure(bound.value)} s`, `No plan of this model has ${of} below it.`]);
  }
  if (typeof above === "number") rows.push(["Above the bound", above <= 0 ? "0 %, optimal" : `${share(above)} %`]);
  return rows;
}

/** @param {any} certificate @param {(spot: any) => void} go */
function certificateTable({ separation, clearance, max_speed_ratio: speed, contact, tol }, go) {
  /** @type {Line} */
  const line = (name, value, at = null, words = "") => {
    const link = at && element("button", { type: "button", class: "spot-link", title: words,
      "aria-label": `${name} ${value}: ${words}`, onclick: () => go(at) }, value);
    return [element("dt", {}, name), element("dd", {}, link ?? value)];
  };
  const found = [
    ...(separation ? line("Least separation", `${figure(separation.value)} m`, separation,
      `${separation.robots.join(" and ")} at ${figure(separation.time)} s`) : []),
    ...(clearance ? line("Least clearance", `${figure(clearance.value)} m`, clearance,
      `${clearance.robot} and ${clearance.obstacle} at ${figure(clearance.time)} s`) : []),
    ...line("Top speed used", `${share(speed)} %`),
    ...(contact ? contactLines(contact, line) : []),
    ...line("Tolerance", `${tol.toExponential(1)} m`),
  ];
  return element("dl", { class: "figures number group", "aria-label": "Certificate" }, ...found);
}

/**
 * A number of the certificate and where it was found.
 * @typedef {(name: string, value: string, at?: any, words?: string) => HTMLElement[]} Line
 */

/** @param {any} contact @param {Line} line */
function contactLines({ lambda2, lambda2_time: at, needed_range: range, needed_time: when }, line) {
  return [
    ...(lambda2 === null ? [] : line("Least λ2", figure(lambda2), { time: at }, `at ${figure(at)} s`)),
    ...(range === null ? [] : line("Range needed", `${figure(range)} m`, { time: when }, `at ${figure(when)} s`)),
  ];
}

/**
 * A sentence that leads to a time or place.
 * @param {string} text @param {number | null | undefined} time @param {() => void} run
 * @param {(on: boolean) => void} [hover]
 */
function spot(text, time, run, hover = () => {}) {
  return element("li", {}, element("button", { type: "button", class: "spot", onclick: run,
    onpointerenter: () => hover(true), onpointerleave: () => hover(false), onfocus: () => hover(true),
    onblur: () => hover(false) },
  typeof time === "number" ? element("span", { class: "spot-time number" }, `${figure(time)} s`) : null,
  element("span", {}, text)));
}

/** @param {number} value three to four digits that mean something */
function figure(value) {
  const size = Math.abs(value);
  if (size === 0) return "0";
  const digits = size >= 1000 ? 0 : size >= 100 ? 1 : size >= 10 ? 2 : 3;
  const text = size < 0.01 ? value.toExponential(1) : value.toFixed(digits);
  return text.replace("-", "−");
}

/** @param {number} part of one */
const share = (part) => (100 * part).toFixed(part >= 0.1 ? 1 : 2);
