// @ts-check
// Where the corners and sides of a scene are, for snapping: two grids of cells and two sorted lists, made once a scene.

import { outlineOf, workspaceRing } from "studio/scene.js";

/** @typedef {import("./scene.js").Scene} Scene */
/** @typedef {import("./scene.js").Ref} Ref */
/** @typedef {import("./scene.js").Point} Point */
/**
 * @typedef {{at: Point, kind: Ref["kind"], name: string | undefined, vertex: number}} Corner
 * @typedef {{a: Point, b: Point, kind: Ref["kind"], name: string | undefined, edge: number, count: number}} Side
 * @typedef {{xmin: number, ymin: number, cell: number, columns: number, rows: number}} Layout
 * @typedef {{layout: Layout, corners: Map<number, Corner[]>, sides: Map<number, Side[]>, byX: Corner[], byY: Corner[]}}
 *   SnapIndex
 */

/** @type {WeakMap<Scene, SnapIndex>} */
const indices = new WeakMap();

/**
 * The index of a frozen scene, made when it is first asked for.
 * @param {Scene} scene
 * @returns {SnapIndex}
 */
export function indexOf(scene) {
  let index = indices.get(scene);
  if (!index) indices.set(scene, (index = build(scene)));
  return index;
}

/**
 * Corners in the cells that a square round a point touches.
 * @param {SnapIndex} index
 * @param {Point} point
 * @param {number} reach metres
 * @returns {Generator<Corner>}
 */
export function* cornersNear({ layout, corners }, point, reach) {
  for (const cell of cellsRound(layout, point, reach)) yield* corners.get(cell) ?? [];
}

/**
 * Sides in the cells that a square round a point touches; one may come more than once.
 * @param {SnapIndex} index
 * @param {Point} point
 * @param {number} reach metres
 * @returns {Generator<Side>}
 */
export function* sidesNear({ layout, sides }, point, reach) {
  for (const cell of cellsRound(layout, point, reach)) yield* sides.get(cell) ?? [];
}

/**
 * Corners whose coordinate is within reach of a number; the list is sorted by that coordinate.
 * @param {Corner[]} sorted
 * @param {0 | 1} axis
 * @param {number} value
 * @param {number} reach
 * @returns {Generator<Corner>}
 */
export function* alongside(sorted, axis, value, reach) {
  let [low, high] = [0, sorted.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (sorted[middle].at[axis] < value - reach) low = middle + 1;
    else high = middle;
  }
  for (let k = low; k < sorted.length && sorted[k].at[axis] <= value + reach; k += 1) yield sorted[k];
}

/**
 * @param {Scene} scene
 * @returns {SnapIndex}
 */
function build(scene) {
  const { corners, sides } = parts(scene);
  const layout = layoutFor(corners);
  /** @type {Map<number, Corner[]>} */
  const cornerCells = new Map();
  /** @type {Map<number, Side[]>} */
  const sideCells = new Map();
  for (const corner of corners) put(cornerCells, cellAt(layout, corner.at[0], corner.at[1]), corner);
  for (const side of sides) for (const cell of cellsOnSide(layout, side)) put(sideCells, cell, side);
  const byX = [...corners].sort((p, q) => p.at[0] - q.at[0]);
  const byY = [...corners].sort((p, q) => p.at[1] - q.at[1]);
  return { layout, corners: cornerCells, sides: sideCells, byX, byY };
}

/**
 * @param {Scene} scene
 * @returns {{corners: Corner[], sides: Side[]}}
 */
function parts(scene) {
  /** @type {Corner[]} */
  const corners = [];
  /** @type {Side[]} */
  const sides = [];
  /**
   * @param {readonly Point[]} points
   * @param {Ref["kind"]} kind
   * @param {string | undefined} name
   * @param {number} sideCount
   */
  const add = (points, kind, name, sideCount) => {
    const count = points.length;
    points.forEach((at, vertex) => corners.push({ at, kind, name, vertex }));
    for (let edge = 0; edge < sideCount; edge += 1) {
      sides.push({ a: points[edge], b: points[(edge + 1) % count], kind, name, edge, count });
    }
  };
  const ring = workspaceRing(scene);
  add(ring, "workspace", undefined, ring.length);
  for (const obstacle of scene.obstacles) {
    const outline = outlineOf(obstacle);
    add(outline, "obstacle", obstacle.name, outline.length - (obstacle.line || obstacle.circle ? 1 : 0));
  }
  for (const { name, start, goal } of scene.robots) {
    corners.push({ at: start, kind: "start", name, vertex: 0 }, { at: goal, kind: "goal", name, vertex: 0 });
  }
  return { corners, sides };
}

/**
 * Cells of about two corners each.
 * @param {Corner[]} corners
 * @returns {Layout}
 */
function layoutFor(corners) {
  let [xmin, ymin, xmax, ymax] = [Infinity, Infinity, -Infinity, -Infinity];
  for (const { at: [x, y] } of corners) {
    [xmin, ymin] = [Math.min(xmin, x), Math.min(ymin, y)];
    [xmax, ymax] = [Math.max(xmax, x), Math.max(ymax, y)];
  }
  const across = Math.max(1, Math.ceil(Math.sqrt(corners.length / 2)));
  const cell = Math.max(xmax - xmin, ymax - ymin) / across || 1;
  const columns = Math.floor((xmax - xmin) / cell) + 1;
  return { xmin, ymin, cell, columns, rows: Math.floor((ymax - ymin) / cell) + 1 };
}

/**
 * @param {Layout} layout
 * @param {number} x
 * @param {number} y
 */
function cellAt({ xmin, ymin, cell, columns, rows }, x, y) {
  const column = Math.min(columns - 1, Math.max(0, Math.floor((x - xmin) / cell)));
  const row = Math.min(rows - 1, Math.max(0, Math.floor((y - ymin) / cell)));
  return row * columns + column;
}

/**
 * @param {Layout} layout
 * @param {Point} point
 * @param {number} reach
 * @returns {Generator<number>}
 */
function* cellsRound(layout, [x, y], reach) {
  const first = cellAt(layout, x - reach, y - reach);
  const last = cellAt(layout, x + reach, y + reach);
  const [left, right] = [first % layout.columns, last % layout.columns];
  for (let row = Math.floor(first / layout.columns); row * layout.columns <= last; row += 1) {
    for (let column = left; column <= right; column += 1) yield row * layout.columns + column;
  }
}

/**
 * Cells that a side passes, column by column.
 * @param {Layout} layout
 * @param {Side} side
 * @returns {Generator<number>}
 */
function* cellsOnSide(layout, { a, b }) {
  const [from, to] = a[0] <= b[0] ? [a, b] : [b, a];
  const first = cellAt(layout, from[0], from[1]) % layout.columns;
  const last = cellAt(layout, to[0], to[1]) % layout.columns;
  const steep = to[0] === from[0] ? 0 : (to[1] - from[1]) / (to[0] - from[0]);
  for (let column = first; column <= last; column += 1) {
    const left = layout.xmin + column * layout.cell;
    const start = column === first ? from[1] : from[1] + (left - from[0]) * steep;
    const end = column === last ? to[1] : from[1] + (left + layout.cell - from[0]) * steep;
    const low = Math.floor(cellAt(layout, from[0], Math.min(start, end)) / layout.columns);
    const high = Math.floor(cellAt(layout, from[0], Math.max(start, end)) / layout.columns);
    for (let row = low; row <= high; row += 1) yield row * layout.columns + column;
  }
}

/**
 * @template T
 * @param {Map<number, T[]>} cells
 * @param {number} cell
 * @param {T} entry
 */
function put(cells, cell, entry) {
  const there = cells.get(cell);
  if (there) there.push(entry);
  else cells.set(cell, [entry]);
}
