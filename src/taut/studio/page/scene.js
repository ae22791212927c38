// @ts-check
// The scene as plain frozen data, exactly as scene files hold it: what is in it, what it is called, where it lies.

import { direction, sum } from "studio/edits_numbers.js";

/**
 * @typedef {readonly [number, number] | readonly number[]} Point
 * @typedef {[number, number, number, number]} Box xmin, ymin, xmax, ymax
 * @typedef {{name: string, polygon?: readonly Point[], rectangle?: readonly number[], angle?: number, circle?: Point,
 *   radius?: number, line?: readonly Point[], width?: number}} Obstacle
 * @typedef {{name: string, start: Point, goal: Point, radius: number, speed: number, clearance?: number,
 *   start_time?: number, at_goal?: string}} Robot
 * @typedef {{taut: 1, name?: string, bounds?: readonly number[], workspace?: readonly Point[], clearance: number,
 *   gap: number, headway: number, at_goal: string, obstacles: readonly Obstacle[], robots: readonly Robot[]}} Scene
 * @typedef {{kind: "obstacle" | "robot" | "start" | "goal" | "workspace" | "scene", name?: string,
 *   vertex?: number}} Ref
 * @typedef {"polygon" | "rectangle" | "circle" | "line"} Shape
 */

/** @returns {Scene} */
export function emptyScene() {
  return deepFreeze({
    taut: 1,
    bounds: [0, 0, 16, 12],
    clearance: 0.1,
    gap: 0.1,
    headway: 0,
    at_goal: "stay",
    obstacles: [],
    robots: [],
  });
}

/**
 * Freeze a value and all in it; parts that are frozen already are whole and stay as they are.
 * @template T
 * @param {T} value
 * @returns {T}
 */
export function deepFreeze(value) {
  if (typeof value !== "object" || value === null || Object.isFrozen(value)) return value;
  for (const part of Object.values(value)) deepFreeze(part);
  return Object.freeze(value);
}

/** @type {WeakMap<readonly any[], Map<string, any>>} */
const indices = new WeakMap();

/**
 * @template {{name: string}} T
 * @param {readonly T[]} entries
 * @returns {Map<string, T>}
 */
function byName(entries) {
  let index = indices.get(entries);
  if (!index) {
    index = new Map(entries.map((entry) => [entry.name, entry]));
    // Only what cannot change may be remembered.
    if (Object.isFrozen(entries)) indices.set(entries, index);
  }
  return index;
}

/**
 * @param {Scene} scene
 * @param {string | undefined} name
 * @returns {Obstacle | undefined}
 */
export function obstacleNamed(scene, name) {
  return byName(scene.obstacles).get(name ?? "");
}

/**
 * @param {Scene} scene
 * @param {string | undefined} name
 * @returns {Robot | undefined}
 */
export function robotNamed(scene, name) {
  return byName(scene.robots).get(name ?? "");
}

/**
 * @param {Obstacle} obstacle
 * @returns {Shape}
 */
export function shapeOf(obstacle) {
  if (obstacle.polygon) return "polygon";
  if (obstacle.rectangle) return "rectangle";
  return obstacle.circle ? "circle" : "line";
}

/** @type {WeakMap<Obstacle, readonly Point[]>} */
const outlines = new WeakMap();

/**
 * Corners of an obstacle without its own radius: a ring, the chain of a wall, or the centre of a circle alone.
 * @param {Obstacle} obstacle
 * @returns {readonly Point[]}
 */
export function outlineOf(obstacle) {
  if (obstacle.polygon) return obstacle.polygon;
  if (obstacle.line) return obstacle.line;
  let outline = outlines.get(obstacle);
  if (!outline) {
    outline = deepFreeze(obstacle.circle ? [obstacle.circle] : rectangleCorners(obstacle));
    if (Object.isFrozen(obstacle)) outlines.set(obstacle, outline);
  }
  return outline;
}

/**
 * Corners of a rectangle, counter-clockwise from its lower left before turning.
 * @param {Obstacle} obstacle
 * @returns {Point[]}
 */
function rectangleCorners({ rectangle, angle = 0 }) {
  const [x, y, width, height] = rectangle ?? [];
  const [right, top] = [sum(x, width), sum(y, height)];
  if (angle === 0) return [[x, y], [right, y], [right, top], [x, top]];
  const [cx, cy] = [x + width / 2, y + height / 2];
  const [cos, sin] = direction(angle);
  return [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => [
    cx + (cos * a * width - sin * b * height) / 2,
    cy + (sin * a * width + cos * b * height) / 2,
  ]);
}

/**
 * Metres by which an obstacle reaches beyond its outline.
 * @param {Obstacle} obstacle
 */
export function ownRadius(obstacle) {
  if (obstacle.circle) return obstacle.radius ?? 0;
  return obstacle.line ? (obstacle.width ?? 0) / 2 : 0;
}

/** @type {WeakMap<readonly any[], readonly Point[]>} */
const rings = new WeakMap();

/**
 * Corners of the workspace; those of bounds run counter-clockwise from the lower left.
 * @param {Scene} scene
 * @returns {readonly Point[]}
 */
export function workspaceRing(scene) {
  if (scene.workspace) return scene.workspace;
  const bounds = scene.bounds ?? [0, 0, 0, 0];
  let ring = rings.get(bounds);
  if (!ring) {
    const [xmin, ymin, xmax, ymax] = bounds;
    ring = deepFreeze([[xmin, ymin], [xmax, ymin], [xmax, ymax], [xmin, ymax]]);
    if (Object.isFrozen(bounds)) rings.set(bounds, ring);
  }
  return ring;
}

/**
 * The least box round points, or null round none.
 * @param {Iterable<Point>} points
 * @param {number} [margin]
 * @returns {Box | null}
 */
export function boxRound(points, margin = 0) {
  let [xmin, ymin, xmax, ymax] = [Infinity, Infinity, -Infinity, -Infinity];
  for (const [x, y] of points) {
    if (x < xmin) xmin = x;
    if (x > xmax) xmax = x;
    if (y < ymin) ymin = y;
    if (y > ymax) ymax = y;
  }
  return xmin <= xmax ? [xmin - margin, ymin - margin, xmax + margin, ymax + margin] : null;
}

/** @type {WeakMap<Obstacle, Box>} */
const boxes = new WeakMap();

/**
 * @param {Obstacle} obstacle
 * @returns {Box}
 */
export function boxOf(obstacle) {
  let box = boxes.get(obstacle);
  if (!box) {
    box = /** @type {Box} */ (boxRound(outlineOf(obstacle), ownRadius(obstacle)));
    if (Object.isFrozen(obstacle)) boxes.set(obstacle, box);
  }
  return box;
}

/**
 * @param {Scene} scene
 * @param {readonly Ref[]} refs
 * @returns {Box | null}
 */
export function boxOfRefs(scene, refs) {
  return union(refs.flatMap((ref) => boxesOf(scene, ref)));
}

/**
 * The box round workspace, obstacles and robots.
 * @param {Scene} scene
 * @returns {Box}
 */
export function boxOfScene(scene) {
  const workspace = /** @type {Box} */ (boxRound(workspaceRing(scene)));
  const robots = scene.robots.map((robot) => /** @type {Box} */ (boxRound([robot.start, robot.goal], robot.radius)));
  return /** @type {Box} */ (union([workspace, ...scene.obstacles.map(boxOf), ...robots]));
}

/**
 * @param {Scene} scene
 * @param {Ref} ref
 * @returns {Box[]}
 */
function boxesOf(scene, ref) {
  if (ref.vertex !== undefined) {
    const vertex = verticesOf(scene, ref)[ref.vertex];
    return vertex ? [[vertex[0], vertex[1], vertex[0], vertex[1]]] : [];
  }
  if (ref.kind === "obstacle") {
    const obstacle = obstacleNamed(scene, ref.name);
    return obstacle ? [boxOf(obstacle)] : [];
  }
  const margin = robotNamed(scene, ref.name)?.radius ?? 0;
  const box = boxRound(verticesOf(scene, ref), margin);
  return box ? [box] : [];
}

/**
 * @param {Box[]} all
 * @returns {Box | null}
 */
function union(all) {
  return boxRound(all.flatMap(([xmin, ymin, xmax, ymax]) => [[xmin, ymin], [xmax, ymax]]));
}

/**
 * The middle of the box round some things: what they turn about.
 * @param {Scene} scene
 * @param {readonly Ref[]} refs
 * @returns {[number, number] | null}
 */
export function centreOf(scene, refs) {
  const box = boxOfRefs(scene, refs);
  return box && [(box[0] + box[2]) / 2, (box[1] + box[3]) / 2];
}

/**
 * The points that make up a thing; `vertex` of a ref counts in them.
 * @param {Scene} scene
 * @param {Ref} ref
 * @returns {readonly Point[]}
 */
export function verticesOf(scene, ref) {
  if (ref.kind === "workspace") return workspaceRing(scene);
  if (ref.kind === "obstacle") {
    const obstacle = obstacleNamed(scene, ref.name);
    return obstacle ? outlineOf(obstacle) : [];
  }
  const robot = robotNamed(scene, ref.name);
  if (!robot) return [];
  if (ref.kind === "start") return [robot.start];
  return ref.kind === "goal" ? [robot.goal] : [robot.start, robot.goal];
}

/**
 * Whether the outline of a thing comes back to its first vertex.
 * @param {Scene} scene
 * @param {Ref} ref
 */
export function isRing(scene, ref) {
  if (ref.kind === "workspace") return true;
  const obstacle = ref.kind === "obstacle" ? obstacleNamed(scene, ref.name) : undefined;
  return Boolean(obstacle && (obstacle.polygon || obstacle.rectangle));
}

/**
 * @param {Ref} a
 * @param {Ref} b
 */
export function sameRef(a, b) {
  return a.kind === b.kind && a.name === b.name && a.vertex === b.vertex;
}

/**
 * Those refs whose things are there.
 * @param {Scene} scene
 * @param {readonly Ref[]} refs
 * @returns {readonly Ref[]}
 */
export function existing(scene, refs) {
  const kept = refs.filter((ref) => {
    if (ref.kind === "scene") return true;
    const vertices = verticesOf(scene, ref);
    return vertices.length > 0 && (ref.vertex === undefined || ref.vertex < vertices.length);
  });
  return kept.length === refs.length ? refs : kept;
}

/**
 * What some things are called in a label.
 * @param {Scene} scene
 * @param {readonly Ref[]} refs
 * @returns {string}
 */
export function called(scene, refs) {
  if (refs.length !== 1) {
    const corners = refs.every((ref) => ref.vertex !== undefined);
    return refs.length === 0 ? "nothing" : `${refs.length} ${corners ? "corners" : "objects"}`;
  }
  const [{ kind, name, vertex }] = refs;
  const thing = kind === "workspace" ? "the workspace" : kind === "scene" ? "the scene" : String(name);
  if (vertex !== undefined) return `a corner of ${thing}`;
  return kind === "start" || kind === "goal" ? `${thing}'s ${kind}` : thing;
}

/**
 * A name that is free: the next number after the name it should be like (O3 → O4, table → table-2), or O1, R1, …
 * @param {Scene} scene
 * @param {"obstacle" | "robot"} kind
 * @param {string} [like]
 * @returns {string}
 */
export function freshName(scene, kind, like) {
  const taken = byName(kind === "obstacle" ? scene.obstacles : scene.robots);
  const given = like?.match(/\d{1,15}$/)?.[0] ?? "";
  const own = given ? like?.slice(0, -given.length) : `${like}-`;
  const [stem, first] = like === undefined
    ? [{ obstacle: "O", robot: "R" }[kind], 1]
    : [own, given ? Number(given) + 1 : 2];
  const width = given.startsWith("0") ? given.length : 0;
  for (let number = first; ; number += 1) {
    const name = stem + String(number).padStart(width, "0");
    if (!taken.has(name)) return name;
  }
}
