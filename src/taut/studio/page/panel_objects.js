// @ts-check
// The tab Objects: everything on the map as a list, for eyes, keys and screen readers.

import { announce } from "studio/announce.js";
import { palette } from "studio/colours.js";
import { element } from "studio/dom.js";
import { icon } from "studio/icons.js";
import { writeNumber } from "studio/panel_numbers.js";
import { boxOf, centreOf, sameRef, shapeOf } from "studio/scene.js";

/** @typedef {import("studio/scene.js").Ref} Ref */

const SHAPE_ICONS = { polygon: "polygon", rectangle: "rectangle", circle: "circle", line: "wall" };

/**
 * What a screen reader says of an obstacle: "Obstacle O3, rectangle 2 by 1 metres at 3, 4".
 * @param {any} obstacle
 */
function obstacleWords(obstacle) {
  const [x, y] = middle(obstacle);
  return `Obstacle ${obstacle.name}, ${shapeWords(obstacle)} at ${short(x)}, ${short(y)}`;
}

/** @param {any} robot */
function robotWords(robot) {
  const [[a, b], [c, d]] = [robot.start, robot.goal];
  const way = `from ${short(a)}, ${short(b)} to ${short(c)}, ${short(d)}`;
  return `Robot ${robot.name}, radius ${short(robot.radius)} metres, ${way}`;
}

/** @param {any} obstacle */
function shapeWords(obstacle) {
  if (obstacle.circle) return `circle of radius ${short(obstacle.radius)} metres`;
  if (obstacle.line) return `wall of ${obstacle.line.length} points, ${short(obstacle.width)} metres wide`;
  if (obstacle.rectangle) {
    return `rectangle ${short(obstacle.rectangle[2])} by ${short(obstacle.rectangle[3])} metres`;
  }
  return `polygon of ${obstacle.polygon.length} corners`;
}

/** @param {any} obstacle */
function middle(obstacle) {
  const [xmin, ymin, xmax, ymax] = boxOf(obstacle);
  return [(xmin + xmax) / 2, (ymin + ymax) / 2];
}

/** @param {number} value */
const short = (value) => writeNumber(value, 3);

/**
 * @param {{store: import("studio/store.js").Store, commands: any, camera: import("studio/camera.js").Camera}} page
 * @returns {HTMLElement}
 */
export function createObjects({ store, commands }) {
  const filter = /** @type {HTMLInputElement} */ (
    element("input", { type: "search", placeholder: "Find by name", "aria-label": "Find objects by name",
      oninput: () => refresh() }));
  const list = element("div", { id: "objects", class: "objects", role: "listbox", tabindex: 0,
    "aria-label": "Objects of the scene", "aria-multiselectable": "true", onkeydown: keyed });
  const none = element("p", { class: "quiet" }, "Nothing here yet: draw an obstacle, or put in a robot.");
  const obstacles = element("div", { role: "group", "aria-label": "Obstacles" });
  const robots = element("div", { role: "group", "aria-label": "Robots" });
  list.append(robots, obstacles);
  /** Kept while their object is the same. @type {Map<string, {node: HTMLElement, entry: any, ref: Ref}>} */
  const rows = new Map();
  /** @type {{node: HTMLElement, entry: any, ref: Ref}[]} */
  let visible = [];
  let active = 0;
  let frame = 0;

  const isChosen = (/** @type {Ref} */ ref) =>
    store.get().selection.some((/** @type {Ref} */ other) => sameThing(other, ref));

  /** @param {"robot" | "obstacle"} kind @param {any} entry @param {number} k */
  function rowOf(kind, entry, k) {
    const key = `${kind} ${entry.name}`;
    const kept = rows.get(key);
    if (kept && kept.entry === entry) return kept;
    const words = kind === "robot" ? robotWords(entry) : obstacleWords(entry);
    const ref = /** @type {Ref} */ ({ kind, name: entry.name });
    const mark = kind === "robot" ? element("span", { class: "swatch", "data-k": k })
      : icon(SHAPE_ICONS[shapeOf(entry)], 16);
    const about = kind === "robot" ? `r ${short(entry.radius)} m` : brief(entry);
    const node = element("div", { role: "option", id: `object-${kind}-${k}`, class: "object", "aria-label": words,
      title: words, onclick: (/** @type {MouseEvent} */ event) => choose(ref, event),
      ondblclick: () => (choose(ref), commands.fitSelection()),
      onpointerenter: () => store.set({ hover: ref }), onpointerleave: () => store.set({ hover: null }) },
    mark, element("span", { class: "object-name" }, entry.name), element("span", { class: "quiet number" }, about));
    const row = { node, entry, ref };
    rows.set(key, row);
    return row;
  }

  function refresh() {
    frame = 0;
    const { scene, problems, theme, tab } = store.get();
    if (!scene || tab !== "objects") return;
    const wanted = filter.value.trim().toLowerCase();
    const named = (/** @type {any} */ { name }) => name.toLowerCase().includes(wanted);
    const colours = palette(theme === "dark");
    const troubled = new Set(problems.flatMap((/** @type {any} */ { names }) => names));
    const of = (/** @type {"robot" | "obstacle"} */ kind, /** @type {any[]} */ entries) =>
      entries.map((entry, k) => rowOf(kind, entry, k)).filter(({ entry }) => named(entry));
    const [robotRows, obstacleRows] = [of("robot", scene.robots), of("obstacle", scene.obstacles)];
    visible = [...robotRows, ...obstacleRows];
    fill(robots, robotRows);
    fill(obstacles, obstacleRows);
    scene.robots.forEach((/** @type {any} */ { name }, /** @type {number} */ k) => {
      const swatch = rows.get(`robot ${name}`)?.node.firstElementChild;
      if (swatch instanceof HTMLElement) swatch.style.background = colours.robot(k);
    });
    for (const { node, ref } of visible) {
      node.setAttribute("aria-selected", String(isChosen(ref)));
      node.classList.toggle("wrong", troubled.has(ref.name));
    }
    if (rows.size > 2 * visible.length + 100) forget(scene);
    active = Math.min(active, Math.max(0, visible.length - 1));
    mark(false);
    none.hidden = scene.robots.length + scene.obstacles.length > 0;
    filter.hidden = scene.robots.length + scene.obstacles.length < 12;
  }

  /** Names that are no more keep no rows. */
  function forget(/** @type {any} */ scene) {
    const there = new Set([...scene.robots.map((/** @type {any} */ { name }) => `robot ${name}`),
      ...scene.obstacles.map((/** @type {any} */ { name }) => `obstacle ${name}`)]);
    for (const key of rows.keys()) if (!there.has(key)) rows.delete(key);
  }

  /** @param {Ref} ref @param {{shiftKey?: boolean, ctrlKey?: boolean, metaKey?: boolean}} [event] */
  function choose(ref, event = {}) {
    active = visible.findIndex((row) => sameRef(row.ref, ref));
    const { selection } = store.get();
    const add = event.shiftKey || event.ctrlKey || event.metaKey;
    const rest = selection.filter((/** @type {Ref} */ other) => !sameThing(other, ref));
    const next = !add ? [ref] : rest.length < selection.length ? rest : [...selection, ref];
    store.set({ selection: Object.freeze(next) });
    const { scene } = store.get();
    const at = centreOf(scene, [ref]);
    if (at) commands.reveal(at);
  }

  /** @param {KeyboardEvent} event */
  function keyed(event) {
    const last = visible.length - 1;
    const [up, down] = [Math.max(active - 1, 0), Math.min(active + 1, last)];
    const to = { ArrowDown: down, ArrowUp: up, Home: 0, End: last }[event.key];
    if (to !== undefined && last >= 0) {
      active = to;
      choose(visible[active].ref, { shiftKey: event.shiftKey && event.key.startsWith("Arrow") });
      mark(true);
    } else if ((event.key === " " || event.key === "Enter") && visible[active]) {
      if (event.key === " ") choose(visible[active].ref, event);
      else commands.rename();
    } else return;
    event.preventDefault();
    event.stopPropagation();
  }

  /** @param {boolean} scroll */
  function mark(scroll) {
    visible.forEach(({ node }, k) => node.classList.toggle("active", k === active));
    const row = visible[active];
    if (row) list.setAttribute("aria-activedescendant", row.node.id);
    else list.removeAttribute("aria-activedescendant");
    if (scroll) row?.node.scrollIntoView({ block: "nearest" });
  }

  const later = () => {
    frame ||= requestAnimationFrame(refresh);
  };
  store.on(["tab"], refresh);
  store.on(["scene", "selection", "problems", "theme"], later);
  store.on(["selection"], ({ selection, scene }) => {
    if (!scene || selection.length === 0 || document.activeElement === list) return;
    if (selection.length === 1) announce(selectionWords(scene, selection[0]));
  });
  later();
  return element("div", { class: "objects-tab" }, filter, none, list);
}

/** @param {any} scene @param {Ref} ref */
function selectionWords(scene, { kind, name, vertex }) {
  const entry = [...scene.obstacles, ...scene.robots].find((each) => each.name === name);
  if (!entry) return "Workspace selected.";
  const what = kind === "obstacle" ? obstacleWords(entry) : robotWords(entry);
  if (vertex !== undefined) return `Corner ${vertex + 1} of ${name} selected.`;
  return kind === "start" || kind === "goal" ? `${kind} of ${what}, selected.` : `${what}, selected.`;
}

/** Whether two refs are of one obstacle or one robot. @param {Ref} a @param {Ref} b */
const sameThing = (a, b) => a.name === b.name && (a.kind === "obstacle") === (b.kind === "obstacle");

/** @param {any} obstacle */
function brief(obstacle) {
  if (obstacle.circle) return `r ${short(obstacle.radius)} m`;
  const [xmin, ymin, xmax, ymax] = boxOf(obstacle);
  const [width, height] = obstacle.rectangle ? obstacle.rectangle.slice(2) : [xmax - xmin, ymax - ymin];
  return `${short(width)} × ${short(height)} m`;
}

/**
 * Give a parent exactly these rows, moving only what is not in its place.
 * @param {HTMLElement} parent
 * @param {{node: HTMLElement}[]} rows
 */
function fill(parent, rows) {
  rows.forEach(({ node }, k) => {
    if (parent.children[k] !== node) parent.insertBefore(node, parent.children[k] ?? null);
  });
  while (parent.children.length > rows.length) parent.lastElementChild?.remove();
}
