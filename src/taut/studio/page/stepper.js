// @ts-check
// The stepper: a method in steps, each with a sentence that explains it, drawn on the board.

import { announce } from "studio/announce.js";
import { clear, element } from "studio/dom.js";
import { icon } from "studio/icons.js";
import { Wrong } from "studio/link.js";

/** Methods with steps: [key, name, what it is, whether it is about one robot]. */
export const METHODS = /** @type {[string, string, string, boolean][]} */ ([
  ["mrppa", "MRPPA", "The thesis' algorithm: the visibility graph cut in two and bridged where λ2 grows most.", false],
  ["ca", "CA", "A path along the centre line, round the obstacles it crosses.", true],
  ["oca", "OCA", "The shortest path from only the obstacles that matter, in rounds.", true],
  ["dijkstra", "Dijkstra", "Search on the visibility graph, nearest vertex first.", true],
  ["astar", "A*", "Search on the visibility graph, guided by the distance left.", true],
]);

/** Milliseconds of quiet before steps are asked for anew, and of a step when they run by themselves. */
const QUIET = 250;
const PACE = 900;

/**
 * @param {import("studio/store.js").Store} store
 * @param {import("studio/link.js").Link} link
 * @returns {HTMLElement}
 */
export function createStepper(store, link) {
  const methods = element("div", { class: "segmented", role: "radiogroup", "aria-label": "Method" },
    ...METHODS.map(([of, name, about]) => element("button", { type: "button", role: "radio", "data-of": of, title: about,
      onclick: () => choose({ of }) }, name)));
  const robots = /** @type {HTMLSelectElement} */ (
    element("select", { id: "step-robot", "aria-label": "Robot", onchange: () => choose({ robot: robots.value }) }));
  const about = element("p", { class: "quiet" });
  const title = element("h2", { id: "step-title" });
  const story = element("div", { class: "story" });
  const numbers = element("dl", { class: "step-numbers number" });
  const list = element("ol", { class: "step-list", "aria-label": "Steps" });
  const place = element("output", { id: "step-place", class: "number" });
  const run = element("button", { type: "button", id: "step-run", class: "button square", onclick: toggle });
  const controls = element("div", { class: "row step-controls" },
    button("first", "First step", () => go(0)),
    button("previous", "Step back (,)", () => go(index() - 1), "step-back"),
    run,
    button("next", "Next step (.)", () => go(index() + 1), "step-next"),
    button("last", "Last step", () => go(count() - 1)),
    place);
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let asking;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let pacing;
  /** @type {import("studio/link.js").Asked | undefined} */
  let newest;
  /** @type {any} */
  let shownList = null;

  const index = () => store.get().steps.index;
  const count = () => store.get().steps.list?.length ?? 0;
  /** @param {Record<string, any>} patch */
  const change = (patch) => store.set({ steps: Object.freeze({ ...store.get().steps, ...patch }) });

  /** @param {Record<string, any>} patch */
  function choose(patch) {
    stop();
    change({ ...patch, index: 0 });
    ask();
  }

  /** @param {number} to */
  function go(to) {
    if (count()) change({ index: Math.min(Math.max(to, 0), count() - 1) });
  }

  function toggle() {
    if (pacing) stop();
    else {
      if (index() >= count() - 1) go(0);
      pacing = setTimeout(advance, PACE);
    }
    show();
  }

  function advance() {
    go(index() + 1);
    pacing = index() < count() - 1 ? setTimeout(advance, PACE) : undefined;
    show();
  }

  function stop() {
    clearTimeout(pacing);
    pacing = undefined;
  }

  async function ask() {
    const { scene, settings, steps } = store.get();
    const robot = aboutOne(steps.of) ? chosenRobot() : null;
    if (!scene.robots.length) {
      change({ list: null, base: [], points: [], wrong: "There are no robots yet: draw one, and step through its planning." });
      return;
    }
    change({ running: true, wrong: null });
    const asked = link.ask("steps", { scene, of: steps.of, robot, settings }, { lane: "steps" });
    newest = asked;
    try {
      const found = await asked.promise;
      if (newest !== asked) return;
      change({ running: false, base: found.base, points: found.points, list: found.steps, index: Math.min(index(), found.steps.length - 1) });
      announce(`${found.steps.length} steps`);
    } catch (error) {
      if (newest !== asked) return;
      change({ running: false, list: null, base: [], points: [],
        wrong: error instanceof Wrong ? error.message : "The server did not answer." });
    }
  }

  function chosenRobot() {
    const { scene, steps } = store.get();
    const known = scene.robots.some((/** @type {any} */ robot) => robot.name === steps.robot);
    return known ? steps.robot : (scene.robots[0]?.name ?? null);
  }

  function show() {
    const { steps, scene, mode } = store.get();
    root.hidden = mode !== "steps";
    if (root.hidden) return;
    for (const one of methods.children) one.setAttribute("aria-checked", String(one.getAttribute("data-of") === steps.of));
    about.textContent = METHODS.find(([of]) => of === steps.of)?.[2] ?? "";
    robots.replaceChildren(...scene.robots.map((/** @type {any} */ { name }) => element("option", { value: name }, name)));
    robots.hidden = !aboutOne(steps.of);
    robots.value = chosenRobot() ?? "";
    const step = steps.list?.[steps.index];
    title.textContent = step?.title ?? (steps.running ? "Working…" : "No steps");
    clear(story);
    story.append(...(step?.story ?? [steps.wrong ?? ""]).map((/** @type {string} */ sentence) => element("p", {}, sentence)));
    clear(numbers);
    for (const [label, text] of Object.entries(step?.numbers ?? {})) {
      numbers.append(element("dt", {}, label), element("dd", {}, String(text)));
    }
    place.textContent = count() ? `${steps.index + 1} / ${count()}` : "";
    run.replaceChildren(icon(pacing ? "pause" : "play"));
    run.setAttribute("aria-label", pacing ? "Pause the steps" : "Run through the steps");
    for (const control of controls.querySelectorAll("button")) control.disabled = count() === 0;
    showList(steps);
  }

  /** @param {any} steps */
  function showList(steps) {
    if (shownList !== steps.list) {
      shownList = steps.list;
      list.replaceChildren(...(steps.list ?? []).map((/** @type {any} */ step, /** @type {number} */ k) =>
        element("li", {}, element("button", { type: "button", class: "button ghost", onclick: () => (stop(), go(k)) },
          step.title))));
    }
    list.querySelector("[aria-current]")?.removeAttribute("aria-current");
    const current = list.children[steps.index]?.firstElementChild;
    current?.setAttribute("aria-current", "step");
    current?.scrollIntoView({ block: "nearest" });
  }

  store.on(["mode", "scene", "settings"], ({ mode, scene }, before) => {
    if (mode !== "steps") {
      stop();
      show();
      return;
    }
    clearTimeout(asking);
    asking = setTimeout(ask, mode !== before.mode || scene === before.scene ? 0 : QUIET);
    show();
  });
  store.on(["steps"], (state, before) => {
    show();
    const step = state.steps.list?.[state.steps.index];
    if (step && state.steps.index !== before.steps?.index) announce(`${step.title}. ${step.story?.[0] ?? ""}`);
  });
  const root = element("section", { id: "stepper", class: "stepper", "aria-label": "Steps of a method" },
    methods, robots, about, controls, title, story, numbers, list);
  if (!store.get().steps) change({ of: "mrppa", robot: null, list: null, base: [], points: [], index: 0, running: false, wrong: null });
  show();
  return root;
}

/** @param {string} of */
const aboutOne = (of) => METHODS.find(([key]) => key === of)?.[3] ?? false;

/**
 * @param {string} name
 * @param {string} label
 * @param {() => void} press
 * @param {string} [id]
 */
function button(name, label, press, id) {
  return element("button", { type: "button", class: "button square", id, title: label, "aria-label": label, onclick: press },
    icon(name));
}
