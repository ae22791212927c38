// @ts-check
// Snapping: the place that is meant by a pointer near corners, sides, lines of corners, angles and the grid.
//
// Corners draw a point before sides, sides before the lines along which corners lie, those before the grid. Reach is in
// pixels. Whatever draws a point, its coordinates have no more digits than a pixel can tell.

import { shifted, sum } from "studio/edits_numbers.js";
import { gridSteps } from "studio/grid.js";
import { boxOfRefs, verticesOf } from "studio/scene.js";
import { nearestOnSegment } from "studio/scene_hits.js";
import { alongside, cornersNear, indexOf, sidesNear } from "studio/snapping_index.js";

/** @typedef {import("./scene.js").Scene} Scene */
/** @typedef {import("./scene.js").Ref} Ref */
/** @typedef {import("./scene.js").Point} Point */
/**
 * @typedef {{grid: boolean, step: number | null, vertex: boolean, edge: boolean, angle: boolean}} Snap what may draw;
 *   the step of the grid in metres, null for that of the grid drawn; angle: lines along which corners lie, too
 * @typedef {{kind: "line", from: Point, to: Point} |
 *   {kind: "point", at: Point, what: "vertex" | "edge" | "grid" | "angle"}} Guide
 * @typedef {{point: [number, number], guides: Guide[]}} Snapped
 * @typedef {{except?: readonly Ref[], from?: Point, constrain?: boolean}} Circumstances things that do not draw (they
 *   are moved themselves); the point before; whether the direction from it is held to steps of 15°
 */

const REACH_VERTEX = 9;
const REACH_EDGE = 7;
const REACH_LINE = 5;
const ANGLE_STEP = Math.PI / 12;
/** Things of more corners than this are moved by the corners and the middle of their box alone. */
const MOST_MOVED = 64;

/**
 * The place meant by a point.
 * @param {Point} point
 * @param {Scene} scene frozen; during a drag the one of its beginning, so that its index is made once
 * @param {Snap} snap
 * @param {{scale: number}} camera pixels a metre
 * @param {Circumstances} [circumstances]
 * @returns {Snapped}
 */
export function snapped(point, scene, snap, camera, { except = [], from, constrain = false } = {}) {
  if (constrain && from) return alongRay(point, from, snap, camera);
  const left = without(except);
  return (
    (snap.vertex && toVertex(point, scene, snap, camera, left)) ||
    (snap.edge && toEdge(point, scene, snap, camera, left)) ||
    toLines(point, scene, snap, camera, left, from)
  );
}

/**
 * The move that is meant when things are moved by dx, dy: the one of their points that is drawn best decides.
 * @param {Scene} scene that before the move
 * @param {readonly Ref[]} refs
 * @param {number} dx
 * @param {number} dy
 * @param {Snap} snap
 * @param {{scale: number}} camera
 * @returns {{dx: number, dy: number, guides: Guide[]}}
 */
export function snappedMove(scene, refs, dx, dy, snap, camera) {
  const left = without(refs);
  const handles = movedPoints(scene, refs).map((start) => ({ start, at: shifted(start, dx, dy) }));
  for (const draw of [snap.vertex && toVertex, snap.edge && toEdge]) {
    if (!draw) continue;
    const drawn = handles.flatMap(({ start, at }) => drawnBy(start, at, draw(at, scene, snap, camera, left)));
    if (drawn.length) return drawn.reduce((best, other) => (other.error < best.error ? other : best));
  }
  const tries = handles.flatMap(({ start, at }) => drawnBy(start, at, toLines(at, scene, snap, camera, left)));
  if (!tries.length) return { dx, dy, guides: [] };
  const move = { dx: bestAlong(tries, 0).dx, dy: bestAlong(tries, 1).dy };
  const guides = tries.flatMap((found) => [
    ...(found.dx === move.dx ? linesOf(found, 0, move) : []),
    ...(found.dy === move.dy ? linesOf(found, 1, move) : []),
  ]);
  return { ...move, guides };
}

/**
 * The power of ten, in metres, that is at most half a pixel.
 * @param {{scale: number}} camera
 */
export function resolution(camera) {
  return 10 ** Math.floor(Math.log10(0.5 / camera.scale));
}

/**
 * A number as a whole multiple of a power of ten, written as shortly as can be.
 * @param {number} number
 * @param {number} step
 */
export function rounded(number, step) {
  const places = Math.round(-Math.log10(step));
  if (places > 100) return number;
  const multiple = places >= 0 ? Number(number.toFixed(places)) : Math.round(number / step) * step;
  return multiple === 0 ? 0 : multiple;
}

/** @typedef {(kind: Ref["kind"], name: string | undefined, vertices: readonly number[]) => boolean} Left */

/**
 * Whether a corner or side stays where it is while the things excepted move.
 * @param {readonly Ref[]} except
 * @returns {Left}
 */
function without(except) {
  if (except.length === 0) return () => true;
  const gone = new Set(except.flatMap(({ kind, name, vertex }) => {
    if (kind === "robot") return [`start ${name}`, `goal ${name}`];
    return [vertex === undefined ? `${kind} ${name}` : `${kind} ${vertex} ${name}`];
  }));
  return (kind, name, vertices) =>
    !gone.has(`${kind} ${name}`) && !vertices.some((vertex) => gone.has(`${kind} ${vertex} ${name}`));
}

/**
 * @param {Point} point
 * @param {Scene} scene
 * @param {Snap} snap
 * @param {{scale: number}} camera
 * @param {Left} left
 * @returns {Snapped | null}
 */
function toVertex(point, scene, snap, camera, left) {
  let least = REACH_VERTEX / camera.scale;
  /** @type {Point | null} */
  let nearest = null;
  for (const { at, kind, name, vertex } of cornersNear(indexOf(scene), point, least)) {
    const distance = Math.hypot(at[0] - point[0], at[1] - point[1]);
    if (distance <= least && left(kind, name, [vertex])) [nearest, least] = [at, distance];
  }
  return nearest && { point: [nearest[0], nearest[1]], guides: [{ kind: "point", at: nearest, what: "vertex" }] };
}

/**
 * @param {Point} point
 * @param {Scene} scene
 * @param {Snap} snap
 * @param {{scale: number}} camera
 * @param {Left} left
 * @returns {Snapped | null}
 */
function toEdge(point, scene, snap, camera, left) {
  let least = REACH_EDGE / camera.scale;
  /** @type {[number, number] | null} */
  let nearest = null;
  for (const { a, b, kind, name, edge, count } of sidesNear(indexOf(scene), point, least)) {
    const on = nearestOnSegment(a, b, point);
    const distance = Math.hypot(on[0] - point[0], on[1] - point[1]);
    if (distance > least || !left(kind, name, [edge, (edge + 1) % count])) continue;
    least = distance;
    nearest = onSide(a, b, on, snap, camera);
  }
  return nearest && { point: nearest, guides: [{ kind: "point", at: nearest, what: "edge" }] };
}

/**
 * A point on a side: on an upright or level one the coordinate of the side stays, the other one may be on the grid.
 * @param {Point} a
 * @param {Point} b
 * @param {Point} on
 * @param {Snap} snap
 * @param {{scale: number}} camera
 * @returns {[number, number]}
 */
function onSide(a, b, on, snap, camera) {
  const straight = a[0] === b[0] || a[1] === b[1];
  const [x, y] = [0, 1].map((axis) => {
    if (a[axis] === b[axis]) return a[axis];
    if (!straight || !snap.grid) return rounded(on[axis], resolution(camera));
    const [low, high] = a[axis] < b[axis] ? [a[axis], b[axis]] : [b[axis], a[axis]];
    return Math.min(high, Math.max(low, gridLine(on[axis], stepOf(snap, camera))));
  });
  return [x, y];
}

/**
 * Each coordinate by itself: to that of a corner, else to the grid, else rounded.
 * @param {Point} point
 * @param {Scene} scene
 * @param {Snap} snap
 * @param {{scale: number}} camera
 * @param {Left} left
 * @param {Point} [from]
 * @returns {Snapped}
 */
function toLines(point, scene, snap, camera, left, from) {
  const axes = /** @type {const} */ ([0, 1]);
  const lined = axes.map((axis) => (snap.angle ? onLine(point, scene, camera, left, axis, from) : null));
  const grid = axes.map((axis) => (snap.grid ? gridLine(point[axis], stepOf(snap, camera)) : null));
  const step = resolution(camera);
  const at = axes.map((axis) => lined[axis]?.[axis] ?? grid[axis] ?? rounded(point[axis], step));
  /** @type {Guide[]} */
  const guides = [];
  for (const corner of lined) if (corner) guides.push({ kind: "line", from: corner, to: [at[0], at[1]] });
  if (!guides.length && grid[0] !== null && grid[1] !== null) {
    guides.push({ kind: "point", at: [at[0], at[1]], what: "grid" });
  }
  return { point: [at[0], at[1]], guides };
}

/**
 * The corner nearest to a point among those nearly on the upright (axis 0) or level (axis 1) line through it.
 * @param {Point} point
 * @param {Scene} scene
 * @param {{scale: number}} camera
 * @param {Left} left
 * @param {0 | 1} axis
 * @param {Point} [from]
 * @returns {Point | null}
 */
function onLine(point, scene, camera, left, axis, from) {
  const reach = REACH_LINE / camera.scale;
  const { byX, byY } = indexOf(scene);
  /** @type {Point | null} */
  let best = null;
  let [bestAcross, bestAlong_] = [reach, Infinity];
  /** @param {Point} at */
  const consider = (at) => {
    const [across, along] = [Math.abs(at[axis] - point[axis]), Math.abs(at[1 - axis] - point[1 - axis])];
    if (across > bestAcross || (across === bestAcross && along >= bestAlong_)) return;
    [best, bestAcross, bestAlong_] = [at, across, along];
  };
  if (from) consider(from);
  for (const { at, kind, name, vertex } of alongside(axis === 0 ? byX : byY, axis, point[axis], reach)) {
    if (left(kind, name, [vertex])) consider(at);
  }
  return best;
}

/**
 * @param {Snap} snap
 * @param {{scale: number}} camera
 */
function stepOf(snap, camera) {
  return snap.step ?? gridSteps(camera.scale).fine;
}

/**
 * The multiple of the step nearest to a number, without dust (3 · 0.1 is 0.3).
 * @param {number} number
 * @param {number} step
 */
function gridLine(number, step) {
  const line = Math.round(number / step) * step;
  return line === 0 ? 0 : Number(line.toPrecision(14));
}

/**
 * The point on the nearest ray of 15° steps from another point; with the grid on, at a whole number of its steps.
 * @param {Point} point
 * @param {Point} from
 * @param {Snap} snap
 * @param {{scale: number}} camera
 * @returns {Snapped}
 */
function alongRay(point, from, snap, camera) {
  const [dx, dy] = [point[0] - from[0], point[1] - from[1]];
  const turn = Math.round(Math.atan2(dy, dx) / ANGLE_STEP);
  const ray = [Math.cos(turn * ANGLE_STEP), Math.sin(turn * ANGLE_STEP)];
  const length = Math.max(0, dx * ray[0] + dy * ray[1]);
  const far = snap.grid ? gridLine(length, stepOf(snap, camera)) : rounded(length, resolution(camera));
  // Along an axis the other coordinate stays as it is, to the last bit.
  const step = resolution(camera) / 10;
  const at = turn % 6 === 0
    ? shifted(from, far * Math.round(ray[0]), far * Math.round(ray[1]))
    : /** @type {[number, number]} */ ([rounded(from[0] + far * ray[0], step), rounded(from[1] + far * ray[1], step)]);
  return { point: at, guides: [{ kind: "line", from, to: at }, { kind: "point", at, what: "angle" }] };
}

/**
 * The points of things by which a move of them is drawn.
 * @param {Scene} scene
 * @param {readonly Ref[]} refs
 * @returns {Point[]}
 */
function movedPoints(scene, refs) {
  const points = refs.flatMap((ref) => {
    const all = verticesOf(scene, ref);
    return ref.vertex === undefined ? all : all.slice(ref.vertex, ref.vertex + 1);
  });
  if (points.length && points.length <= MOST_MOVED) return points;
  const box = boxOfRefs(scene, refs);
  if (!box) return [];
  const [xmin, ymin, xmax, ymax] = box;
  return [[xmin, ymin], [xmax, ymin], [xmax, ymax], [xmin, ymax], [(xmin + xmax) / 2, (ymin + ymax) / 2]];
}

/**
 * @typedef {{start: Point, dx: number, dy: number, guides: Guide[], error: number, errors: [number, number],
 *   lines: boolean[]}} Drawn a move, how far it is from the raw one, and the axes on which a line draws it
 */

/**
 * The move that takes a point to where it is drawn.
 * @param {Point} start
 * @param {Point} at where the raw move takes it
 * @param {Snapped | null} found
 * @returns {Drawn[]}
 */
function drawnBy(start, at, found) {
  if (!found) return [];
  const [x, y] = found.point;
  const errors = /** @type {[number, number]} */ ([Math.abs(x - at[0]), Math.abs(y - at[1])]);
  const lines = [0, 1].map((axis) => found.guides.some((guide) => isLineAlong(guide, axis)));
  const [dx, dy] = [sum(x, -start[0]), sum(y, -start[1])];
  return [{ start, dx, dy, guides: found.guides, error: Math.hypot(...errors), errors, lines }];
}

/**
 * The best of several moves along one axis: the nearest of those drawn by a line, else that of the first point, so that
 * the same point of a thing lies on the grid wherever it is moved.
 * @param {Drawn[]} tries
 * @param {0 | 1} axis
 * @returns {Drawn}
 */
function bestAlong(tries, axis) {
  const lined = tries.filter(({ lines }) => lines[axis]);
  if (!lined.length) return tries[0];
  return lined.reduce((best, other) => (other.errors[axis] < best.errors[axis] ? other : best));
}

/**
 * The lines on which a point lies after a move, up to where it ends.
 * @param {Drawn} found
 * @param {0 | 1} axis
 * @param {{dx: number, dy: number}} move
 * @returns {Guide[]}
 */
function linesOf({ start, guides }, axis, { dx, dy }) {
  return guides.filter((guide) => isLineAlong(guide, axis)).map((guide) => ({ ...guide, to: shifted(start, dx, dy) }));
}

/**
 * @param {Guide} guide
 * @param {number} axis 0: an upright line
 */
function isLineAlong(guide, axis) {
  return guide.kind === "line" && guide.from[axis] === guide.to[axis];
}
