// @ts-check
// Two ways of planning side by side: one scene, one camera, one clock, two boards and a table of what each gives.

import { createBoard } from "studio/board.js";
import { createCamera } from "studio/camera.js";
import { element } from "studio/dom.js";
import { Wrong } from "studio/link.js";
import { makespanOf, motionsOf, stretchesOf } from "studio/motion.js";
import { navigate } from "studio/navigating.js";
import { createSettingsForm } from "studio/plan_settings.js";
import { comparedSettings } from "studio/planner_settings.js";
import { createStore } from "studio/store.js";

/** What the two boards share with the page. */
const SHARED = ["scene", "revision", "time", "theme", "show", "hover", "selection", "reach"];
/** Milliseconds of quiet before both are planned anew. */
const QUIET = 200;
/** Settings that a comparison begins with on its right. */
const OTHER = Object.freeze({ method: "repair", rounds: 40 });

/**
 * @typedef {{label: string, unit: string, better: -1 | 0 | 1, of: (answer: any) => number | null}} Measure
 */

/** @type {Measure[]} */
const MEASURES = [
  { label: "Sum of costs", unit: "s", better: -1, of: (answer) => answer.metrics.sum_of_costs },
  { label: "Makespan", unit: "s", better: -1, of: (answer) => answer.metrics.makespan },
  { label: "Length", unit: "m", better: -1, of: (answer) => answer.metrics.length },
  { label: "Above the bound", unit: "%", better: -1, of: aboveBound },
  { label: "Least separation", unit: "m", better: 1, of: (answer) => answer.certificate.min_separation },
  { label: "Least clearance", unit: "m", better: 1, of: (answer) => answer.certificate.min_clearance },
  { label: "Waiting", unit: "s", better: -1, of: waiting },
  { label: "Conflicts resolved", unit: "", better: 0, of: (answer) => answer.conflicts.length },
  { label: "Planned in", unit: "s", better: -1, of: (answer) => seconds(answer.phases) },
];

/**
 * @param {import("studio/store.js").Store} store
 * @param {import("studio/link.js").Link} link
 * @param {readonly import("studio/board.js").Layer[]} layers
 * @returns {HTMLElement}
 */
export function createComparison(store, link, layers) {
  const camera = createCamera();
  const sides = ["left", "right"].map((name) => createSide(name, store, link, camera, layers));
  const table = element("table", { class: "measures" });
  const swap = element("button", { id: "swap", title: "Swap both sides", type: "button", class: "button", onclick: swapSides }, "Swap");

  function swapSides() {
    const { left, right } = store.get().compare;
    store.set({ compare: Object.freeze({ left: right, right: left }) });
  }

  function tabulate() {
    const [left, right] = sides.map((side) => side.store.get().answer);
    const columns = MEASURES.map((measure) => cellsOf(measure, left, right));
    table.replaceChildren(
      element("thead", {}, element("tr", {}, element("td"), ...MEASURES.map(({ label, unit }) =>
        element("th", { scope: "col" }, unit ? `${label} (${unit})` : label)))),
      element("tbody", {}, ...["Left", "Right"].map((name, k) =>
        element("tr", {}, element("th", { scope: "row" }, name), ...columns.map((cells) => cells[k])))),
    );
    const ends = [left, right].map((answer) => (answer ? makespanOf(motionsOf(answer)) : 0));
    store.set({ compared: Object.freeze({ until: Math.max(...ends) }) });
  }

  for (const side of sides) side.store.on(["answer"], tabulate);
  store.on(["mode"], ({ mode, compare, settings }) => {
    if (mode !== "compare") return;
    if (!compare) store.set({ compare: Object.freeze({ left: settings, right: { ...settings, ...OTHER } }) });
    requestAnimationFrame(() => requestAnimationFrame(sides[0].begin)); // the boards know their size in the next frame
  });
  tabulate();
  return element("section", { id: "compare", "aria-label": "Comparison" },
    element("div", { class: "sides" }, ...sides.map((side) => side.root)),
    element("div", { class: "verdict" }, table, swap));
}

/**
 * One side: its settings, its plan and its board.
 * @param {string} name
 * @param {import("studio/store.js").Store} store
 * @param {import("studio/link.js").Link} link
 * @param {import("studio/camera.js").Camera} camera
 * @param {readonly import("studio/board.js").Layer[]} layers
 */
function createSide(name, store, link, camera, layers) {
  const own = createStore({ ...store.get(), answer: null, planning: { state: "idle" }, timelines: null });
  const canvas = /** @type {HTMLCanvasElement} */ (
    element("canvas", { class: "board", tabindex: 0, role: "img", "aria-label": `Plan on the ${name}` }));
  const words = element("p", { class: "side-state", role: "status" });
  const form = createSettingsForm({
    name,
    compact: true,
    get: () => store.get().compare?.[name] ?? store.get().settings,
    set: (settings) => store.set({ compare: Object.freeze({ ...store.get().compare, [name]: settings }) }),
    watch: (fn) => store.on(["compare"], fn),
  });
  const board = createBoard(canvas, own, camera, layers);
  const { home } = navigate(canvas, board, camera, () => store.get().scene);
  const summary = element("summary");
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let timer;
  /** @type {any} */
  let asked = null;
  /** @type {import("studio/link.js").Asked | null} */
  let running = null;

  async function plan() {
    const { scene, revision, compare } = store.get();
    if (asked?.scene === scene && asked.chosen === compare[name]) return;
    const mine = { scene, chosen: compare[name] };
    asked = mine;
    words.textContent = "planning…";
    running = link.ask("plan", { scene, settings: comparedSettings(mine.chosen) }, { lane: name });
    try {
      const found = await running.promise;
      if (asked !== mine) return;
      running = null;
      own.set({ answer: Object.freeze({ ...found, scene, revision }), planning: { state: "fresh" } });
      words.textContent = "";
    } catch (error) {
      if (asked !== mine) return;
      asked = running = null;
      own.set({ answer: null, planning: { state: "failed" } });
      words.textContent = error instanceof Wrong ? error.message : "not planned: the server did not answer";
    }
  }

  /** Nobody looks any more: what is under way is given up, and asked for again when somebody does. */
  function stop() {
    if (!running) return;
    running.cancel();
    asked = running = null;
    words.textContent = "";
  }

  store.on(SHARED, (state) => own.set(Object.fromEntries(SHARED.map((key) => [key, state[key]]))));
  store.on(["scene", "compare", "mode"], ({ mode, compare }) => {
    clearTimeout(timer);
    if (mode !== "compare") stop();
    if (mode !== "compare" || !compare) return;
    summary.textContent = inWords(comparedSettings(compare[name]));
    timer = setTimeout(plan, QUIET);
  });
  return {
    store: own,
    root: element("div", { class: "side", "data-side": name },
      element("details", { class: "side-settings" }, summary, form),
      element("div", { class: "side-board" }, canvas), words),
    begin: home,
  };
}

/**
 * Settings in a line: "repair · 40 rounds · shortest first".
 * @param {Record<string, any>} settings
 */
function inWords({ method, order, roadmap, rounds, seconds, seed, contact }) {
  return [
    method ?? (rounds || seconds ? "repair" : "prioritized"),
    rounds ? `${rounds} rounds` : null,
    seconds ? `${seconds} s` : null,
    order && order !== "shortest" ? `${order} first` : null,
    roadmap && roadmap !== "visibility" ? `roadmap ${roadmap}` : null,
    contact?.range ? `contact ${contact.range} m` : null,
    seed ? `seed ${seed}` : null,
  ].filter(Boolean).join(" · ");
}

/**
 * The two cells of a measure; the better one stands out.
 * @param {Measure} measure
 * @param {any} left
 * @param {any} right
 */
function cellsOf({ better, of }, left, right) {
  const values = [left, right].map((answer) => (answer ? of(answer) : null));
  const [a, b] = values;
  const winner = better === 0 || a === null || b === null || same(a, b) ? -1 : Number(better * (b - a) > 0);
  return values.map((value, k) =>
    element("td", { class: k === winner ? "number better" : "number" }, value === null ? "–" : shown(value)));
}

/**
 * Whether two numbers would look the same.
 * @param {number} a
 * @param {number} b
 */
function same(a, b) {
  return shown(a) === shown(b);
}

/** @param {number} value */
function shown(value) {
  return Number.isInteger(value) ? String(value) : value.toPrecision(5);
}

/** @param {any} answer */
function aboveBound({ metrics }) {
  return metrics.above === null ? null : 100 * metrics.above;
}

/** @param {any} answer */
function waiting(answer) {
  return motionsOf(answer).flatMap(stretchesOf).reduce((sum, { begin, end, moves }) => sum + (moves ? 0 : end - begin), 0);
}

/** @param {Record<string, number>} phases */
function seconds(phases) {
  return Object.values(phases).reduce((sum, value) => sum + value, 0);
}
