// @ts-check
// Timelines under the board: λ2, least separation, and each robot's moves and waits; a click goes to that time.

import { isDark, palette } from "studio/colours.js";
import { clear, element } from "studio/dom.js";
import { makespanOf, motionsOf } from "studio/motion.js";
import { nameAt, paintChart, paintRows, ROW } from "studio/paint_timelines.js";
import { LEFT, RIGHT } from "studio/timebar.js";

const CHART = 64;

/**
 * @typedef {{left: number, width: number, end: number}} Axis  pixels and seconds
 */

/**
 * @param {import("studio/store.js").Store} store
 * @param {import("studio/player.js").Player} player
 * @returns {HTMLElement}
 */
export function createTimelines(store, player) {
  const charts = element("div", { class: "charts" });
  const head = element("div", { class: "playhead" });
  const rows = canvasOf("Moves and waits of each robot over time");
  const list = element("div", { class: "timeline-rows" }, rows);
  const tip = element("div", { class: "tip", hidden: true });
  const none = element("p", { class: "timelines-none quiet" },
    "Separation, contact, moves and waits are drawn here once there is a plan.");
  const scroll = element("div", { class: "timelines-scroll" }, charts, list, none);
  const root = element("section", { id: "timelines", "aria-label": "Timelines" }, scroll, head, tip);
  /** @type {Map<string, HTMLCanvasElement>} */
  const drawn = new Map();

  const axis = () => ({ left: LEFT, width: Math.max(root.clientWidth - LEFT - RIGHT, 1), end: Math.max(player.until(), 1e-9) });

  function layout() {
    const wanted = chartsOf(store.get());
    for (const name of [...drawn.keys()]) if (!wanted.some((chart) => chart.name === name)) drawn.delete(name);
    for (const { name } of wanted) if (!drawn.has(name)) drawn.set(name, canvasOf(name));
    clear(charts);
    charts.append(...wanted.map(({ name }) => /** @type {HTMLCanvasElement} */ (drawn.get(name))));
    paint();
  }

  function paint() {
    const state = store.get();
    if (!root.isConnected || root.clientWidth === 0) return;
    const colours = palette(isDark(state.theme));
    for (const chart of chartsOf(state)) {
      const canvas = /** @type {HTMLCanvasElement} */ (drawn.get(chart.name));
      canvas.setAttribute("aria-label", `${chart.name}: ${chart.words}`);
      paintChart(sized(canvas, root.clientWidth, CHART), axis(), chart, colours);
    }
    const motions = state.answer ? motionsOf(state.answer) : [];
    list.hidden = motions.length === 0;
    none.hidden = motions.length > 0;
    paintRows(sized(rows, root.clientWidth, Math.max(motions.length * ROW, 1)), axis(), motions, state, colours);
    place();
  }

  function place() {
    const { left, width, end } = axis();
    const share = Math.min(store.get().time.now / end, 1);
    head.style.transform = `translateX(${left + share * width}px)`;
    head.hidden = player.until() <= 0;
  }

  function fold() {
    root.hidden = Boolean(store.get().folded);
    paint();
  }

  /** @param {PointerEvent} event */
  const timeAt = (event) => {
    const { left, width, end } = axis();
    return ((event.clientX - root.getBoundingClientRect().left - left) / width) * end;
  };

  /** @param {PointerEvent} event */
  function point(event) {
    if (event.buttons & 1) player.seek(timeAt(event));
    const motions = store.get().answer ? motionsOf(store.get().answer) : [];
    const name = event.target === rows ? nameAt(motions, event.offsetY) : null;
    if (name !== (store.get().hover?.name ?? null)) store.set({ hover: name ? { kind: "robot", name } : null });
    say(event, name);
  }

  /**
   * @param {PointerEvent} event
   * @param {string | null} name
   */
  function say(event, name) {
    const time = timeAt(event);
    tip.hidden = time < 0 || time > player.until();
    if (tip.hidden) return;
    const chart = chartsOf(store.get()).find((one) => drawn.get(one.name) === event.target);
    tip.textContent = [`${time.toFixed(2)} s`, name, chart && chart.at(time)].filter(Boolean).join(" · ");
    const box = root.getBoundingClientRect();
    tip.style.left = `${Math.min(event.clientX - box.left + 12, box.width - tip.offsetWidth - 4)}px`;
    tip.style.top = `${Math.max(event.clientY - box.top - 26, 0)}px`;
  }

  root.addEventListener("pointerdown", (event) => {
    if (event.target instanceof HTMLCanvasElement) {
      player.pause();
      root.setPointerCapture(event.pointerId);
      player.seek(timeAt(event));
    }
  });
  root.addEventListener("pointermove", point);
  root.addEventListener("pointerleave", () => {
    tip.hidden = true;
    if (store.get().hover) store.set({ hover: null });
  });
  store.on(["answer", "timelines"], layout);
  store.on(["theme", "hover", "selection"], paint);
  store.on(["time"], place);
  store.on(["folded"], fold);
  new ResizeObserver(paint).observe(root);
  fold();
  layout();
  return root;
}

/**
 * What is drawn above the robots' rows: {name, words, kind, times, values, limit, at}.
 * @param {Record<string, any>} state
 * @returns {any[]}
 */
function chartsOf({ answer, timelines }) {
  if (!answer || !timelines) return [];
  const { separation, contact } = timelines;
  const until = makespanOf(motionsOf(answer));
  const found = [];
  if (contact) found.push(connectivity(contact, until));
  if (separation?.times?.length > 1) found.push(nearness(separation, answer.scene.gap ?? 0));
  return found;
}

/**
 * λ2 over time; of very large teams, where it is not computed, the number of parts.
 * @param {any} contact
 * @param {number} until
 */
function connectivity({ times, lambda2, parts }, until) {
  if (lambda2 === null) return partsOver(times, parts, until);
  const least = lambda2.reduce((/** @type {number} */ low, /** @type {number} */ value) => Math.min(low, value), Infinity);
  return {
    name: "λ2",
    words: least > 0 ? `at least ${least.toPrecision(3)}` : "0 at times: the team is not connected",
    brief: least > 0 ? `least ${least.toPrecision(3)}` : "apart at times",
    steps: true,
    times: [...times, Math.max(until, times.at(-1))],
    values: [...lambda2, lambda2.at(-1)],
    limit: null,
    at: (/** @type {number} */ time) => `λ2 = ${lambda2[lastBefore(times, time)].toPrecision(3)}`,
  };
}

/**
 * @param {number[]} times
 * @param {number[]} parts
 * @param {number} until
 */
function partsOver(times, parts, until) {
  return {
    name: "parts",
    words: `at most ${Math.max(...parts)}`,
    brief: `at most ${Math.max(...parts)}`,
    steps: true,
    times: [...times, Math.max(until, times[times.length - 1])],
    values: [...parts, parts[parts.length - 1]],
    limit: null,
    at: (/** @type {number} */ time) => `${parts[lastBefore(times, time)]} parts`,
  };
}

/**
 * Least separation over time, null where there are fewer than two robots; the plan asks for `gap`.
 * @param {any} separation
 * @param {number} gap
 */
function nearness({ times, values, least }, gap) {
  return {
    name: "apart (m)",
    words: least ? `least ${least.value.toPrecision(3)} metres at ${least.time.toFixed(2)} seconds, ${least.robots?.join(" and ")}` : "",
    brief: least ? `least ${least.value.toPrecision(3)} m` : "",
    steps: false,
    times,
    values,
    limit: gap,
    mark: least,
    at(/** @type {number} */ time) {
      const k = Math.min(lastBefore(times, time), times.length - 2);
      if (values[k] === null || values[k + 1] === null) return "";
      const share = Math.min(Math.max((time - times[k]) / (times[k + 1] - times[k] || 1), 0), 1);
      return `${(values[k] + share * (values[k + 1] - values[k])).toPrecision(3)} m apart`;
    },
  };
}

/**
 * @param {number[]} times
 * @param {number} time
 */
function lastBefore(times, time) {
  let k = 0;
  while (k + 1 < times.length && times[k + 1] <= time) k += 1;
  return k;
}

/** @param {string} label */
function canvasOf(label) {
  return /** @type {HTMLCanvasElement} */ (element("canvas", { role: "img", "aria-label": label }));
}

/**
 * Size a canvas for the pixels of this screen; returns its context, in CSS pixels.
 * @param {HTMLCanvasElement} canvas
 * @param {number} width
 * @param {number} height
 */
function sized(canvas, width, height) {
  const ratio = window.devicePixelRatio || 1;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  canvas.style.width = `${width}px`;
  canvas.style.height = `${height}px`;
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  context.scale(ratio, ratio);
  return context;
}
