// @ts-check
// The tools that need many places: polygons and walls, corner by corner.

import { roundStep } from "studio/grid.js";
import { REACH } from "studio/hit.js";
import { boxOfScene } from "studio/scene.js";
import { lineLabel } from "studio/tool_labels.js";

/**
 * @typedef {import("studio/tools.js").Desk} Desk
 * @typedef {import("studio/tools.js").BoardEvent} BoardEvent
 */

/** Corners nearer than this many pixels to the last are the second half of a double click. */
const SAME = 3;
/** Least number of corners of what each tool makes. */
const LEAST = { polygon: 3, wall: 2 };

/**
 * The first corner.
 * @param {Desk} desk
 * @param {BoardEvent} event
 * @param {any} state
 */
export function beginChain(desk, event, { name }) {
  const { point } = desk.snap(event, {});
  return aimChain(desk, event, { name: `${name}.chain`, points: [point] });
}

/**
 * The next corner follows the pointer.
 * @param {Desk} desk
 * @param {BoardEvent} event
 * @param {any} state
 */
export function aimChain(desk, event, state) {
  const { points } = state;
  const last = points[points.length - 1];
  const closing = atFirst(desk, event, state);
  const { point, guides } = desk.snap(event, { from: event.shift ? last : null });
  const cursor = closing ? points[0] : point;
  show(desk, { ...state, cursor, closing, guides });
  return { ...state, cursor, closing };
}

/**
 * One more corner; the first one again closes.
 * @param {Desk} desk
 * @param {BoardEvent} event
 * @param {any} state
 */
export function addCorner(desk, event, state) {
  const aimed = aimChain(desk, event, state);
  if (aimed.closing) return finishChain(desk, event, { ...state, looped: state.name === "wall.chain" });
  const { points } = state;
  const last = points[points.length - 1];
  const { scale } = desk.camera.get();
  if (Math.hypot(aimed.cursor[0] - last[0], aimed.cursor[1] - last[1]) * scale <= SAME) return state;
  return aimChain(desk, event, { ...state, points: [...points, aimed.cursor] });
}

/**
 * Make the obstacle of the corners there are.
 * @param {Desk} desk
 * @param {BoardEvent | null} event
 * @param {any} state
 */
export function finishChain(desk, event, state) {
  const { points, looped = false } = state;
  const kind = /** @type {"polygon" | "wall"} */ (state.name.split(".")[0]);
  if (points.length < LEAST[kind]) {
    desk.say(`A ${kind} needs at least ${LEAST[kind]} corners: click the next one.`);
    return state;
  }
  const shape = kind === "polygon" ? { polygon: points }
    : { line: looped ? [...points, points[0]] : points, width: wallWidthOf(desk.store.get()) };
  desk.addObstacle(shape);
  return desk.idle();
}

/**
 * Keys while corners are set: Enter makes the obstacle, Backspace takes the last corner back, Escape leaves.
 * @param {Desk} desk
 * @param {BoardEvent} event
 * @param {any} state
 */
export function chainKey(desk, event, state) {
  if (event.key === "Enter") {
    event.use();
    return finishChain(desk, null, state);
  }
  if (event.key === "Escape") {
    event.use();
    return desk.idle();
  }
  if (event.key !== "Backspace" && event.key !== "Delete") return undefined;
  event.use();
  const points = state.points.slice(0, -1);
  if (points.length === 0) return desk.idle();
  show(desk, { ...state, points, guides: [] });
  return { ...state, points };
}

/**
 * Width of walls drawn next: as set, else that of the last wall, else about an eightieth of the map.
 * @param {import("studio/store.js").State} state
 */
export function wallWidthOf({ wallWidth, scene }) {
  if (wallWidth > 0) return wallWidth;
  const last = scene.obstacles.filter((/** @type {any} */ obstacle) => obstacle.line).at(-1);
  if (last) return last.width;
  const [xmin, ymin, xmax, ymax] = boxOfScene(scene);
  return roundStep(Math.max(xmax - xmin, ymax - ymin, 1e-9) / 80);
}

/**
 * Whether the pointer is on the first corner, so that a click would close.
 * @param {Desk} desk
 * @param {BoardEvent} event
 * @param {any} state
 */
function atFirst(desk, event, { points }) {
  if (points.length < 3) return false;
  const { scale } = desk.camera.get();
  const [x, y] = points[0];
  return Math.hypot(event.point[0] - x, event.point[1] - y) * scale <= REACH[event.device] + 2;
}

/**
 * @param {Desk} desk
 * @param {any} state
 */
function show(desk, { name, points, cursor, closing = false, guides }) {
  const kind = name.split(".")[0];
  const last = points[points.length - 1];
  const width = kind === "wall" ? wallWidthOf(desk.store.get()) : 0;
  desk.sketch({ kind, points, cursor, closing, width, guides, labels: cursor ? [lineLabel(last, cursor)] : [] });
}
