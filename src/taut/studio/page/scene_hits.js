// @ts-check
// What is under a point or in a box of the scene, topmost first.

import { boxOf, boxRound, isRing, outlineOf, ownRadius, verticesOf, workspaceRing } from "studio/scene.js";

/** @typedef {import("./scene.js").Scene} Scene */
/** @typedef {import("./scene.js").Ref} Ref */
/** @typedef {import("./scene.js").Point} Point */
/** @typedef {import("./scene.js").Box} Box */
/** @typedef {import("./scene.js").Obstacle} Obstacle */

/**
 * All that is within reach of a point: goals and starts before obstacles, later ones before earlier ones (they are
 * painted above), and the workspace last, by its sides.
 * @param {Scene} scene
 * @param {Point} point
 * @param {number} reach metres
 * @returns {Ref[]}
 */
export function hitsAt(scene, point, reach) {
  return [...endsAt(scene, point, reach), ...obstaclesAt(scene, point, reach), ...workspaceAt(scene, point, reach)];
}

/**
 * All that a box touches, in the order of the scene; the workspace never.
 * @param {Scene} scene
 * @param {Box} box
 * @returns {Ref[]}
 */
export function refsInBox(scene, box) {
  /** @type {Ref[]} */
  const found = [];
  for (const obstacle of scene.obstacles) {
    if (overlap(boxOf(obstacle), box) && touches(obstacle, box)) found.push({ kind: "obstacle", name: obstacle.name });
  }
  for (const { name, start, goal, radius } of scene.robots) {
    const ends = [distanceToBox(start, box) <= radius, distanceToBox(goal, box) <= radius];
    if (ends[0] && ends[1]) found.push({ kind: "robot", name });
    else if (ends[0]) found.push({ kind: "start", name });
    else if (ends[1]) found.push({ kind: "goal", name });
  }
  return found;
}

/**
 * The nearest side of a thing within reach, and the point of it nearest to the one asked for.
 * @param {Scene} scene
 * @param {Ref} ref
 * @param {Point} point
 * @param {number} reach metres
 * @returns {{edge: number, point: [number, number]} | null}
 */
export function edgeAt(scene, ref, point, reach) {
  const nearest = nearestOnChain(verticesOf(scene, ref), isRing(scene, ref), point);
  return nearest && nearest.distance <= reach ? { edge: nearest.edge, point: nearest.point } : null;
}

/**
 * Metres from a point to an obstacle, 0 inside.
 * @param {Obstacle} obstacle
 * @param {Point} point
 */
function distanceTo(obstacle, point) {
  const outline = outlineOf(obstacle);
  if (obstacle.circle) {
    return Math.max(0, Math.hypot(point[0] - outline[0][0], point[1] - outline[0][1]) - ownRadius(obstacle));
  }
  const ring = !obstacle.line;
  if (ring && inside(outline, point)) return 0;
  return Math.max(0, (nearestOnChain(outline, ring, point)?.distance ?? Infinity) - ownRadius(obstacle));
}

/**
 * The point of a segment nearest to a point.
 * @param {Point} a
 * @param {Point} b
 * @param {Point} point
 * @returns {[number, number]}
 */
export function nearestOnSegment(a, b, point) {
  const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
  const squared = dx * dx + dy * dy;
  const share = squared === 0 ? 0 : ((point[0] - a[0]) * dx + (point[1] - a[1]) * dy) / squared;
  if (share <= 0) return [a[0], a[1]];
  return share >= 1 ? [b[0], b[1]] : [a[0] + share * dx, a[1] + share * dy];
}

/**
 * @param {Scene} scene
 * @param {Point} point
 * @param {number} reach
 * @returns {Ref[]}
 */
function endsAt(scene, point, reach) {
  /** @type {{ref: Ref, distance: number}[]} */
  const found = [];
  for (const { name, start, goal, radius } of [...scene.robots].reverse()) {
    for (const [kind, end] of /** @type {const} */ ([["goal", goal], ["start", start]])) {
      const distance = Math.hypot(end[0] - point[0], end[1] - point[1]);
      if (distance <= Math.max(radius, reach)) found.push({ ref: { kind, name }, distance });
    }
  }
  // Where discs overlap on a small map the one whose middle is nearest is meant.
  return found.sort((a, b) => a.distance - b.distance).map(({ ref }) => ref);
}

/**
 * @param {Scene} scene
 * @param {Point} point
 * @param {number} reach
 * @returns {Ref[]}
 */
function obstaclesAt(scene, point, reach) {
  /** @type {Ref[]} */
  const found = [];
  for (let k = scene.obstacles.length - 1; k >= 0; k -= 1) {
    const obstacle = scene.obstacles[k];
    const near = distanceToBox(point, boxOf(obstacle)) <= reach;
    if (near && distanceTo(obstacle, point) <= reach) found.push({ kind: "obstacle", name: obstacle.name });
  }
  return found;
}

/**
 * @param {Scene} scene
 * @param {Point} point
 * @param {number} reach
 * @returns {Ref[]}
 */
function workspaceAt(scene, point, reach) {
  const nearest = nearestOnChain(workspaceRing(scene), true, point);
  return nearest && nearest.distance <= reach ? [{ kind: "workspace" }] : [];
}

/**
 * @param {readonly Point[]} points
 * @param {boolean} ring
 * @param {Point} point
 * @returns {{edge: number, point: [number, number], distance: number} | null}
 */
function nearestOnChain(points, ring, point) {
  const sides = ring ? points.length : points.length - 1;
  let best = null;
  for (let k = 0; k < sides; k += 1) {
    const on = nearestOnSegment(points[k], points[(k + 1) % points.length], point);
    const distance = Math.hypot(on[0] - point[0], on[1] - point[1]);
    if (!best || distance < best.distance) best = { edge: k, point: on, distance };
  }
  return best;
}

/**
 * Whether a point is in a ring (even-odd).
 * @param {readonly Point[]} ring
 * @param {Point} point
 */
export function inside(ring, [x, y]) {
  let odd = false;
  for (let k = 0, before = ring.length - 1; k < ring.length; before = k, k += 1) {
    const [[ax, ay], [bx, by]] = [ring[k], ring[before]];
    if (ay > y !== by > y && x < ((bx - ax) * (y - ay)) / (by - ay) + ax) odd = !odd;
  }
  return odd;
}

/**
 * @param {Box} a
 * @param {Box} b
 */
function overlap(a, b) {
  return a[0] <= b[2] && b[0] <= a[2] && a[1] <= b[3] && b[1] <= a[3];
}

/**
 * @param {Point} point
 * @param {Box} box
 */
function distanceToBox([x, y], [xmin, ymin, xmax, ymax]) {
  return Math.hypot(Math.max(xmin - x, 0, x - xmax), Math.max(ymin - y, 0, y - ymax));
}

/**
 * Whether an obstacle whose box overlaps another has a point in it.
 * @param {Obstacle} obstacle
 * @param {Box} box
 */
function touches(obstacle, box) {
  const outline = outlineOf(obstacle);
  const radius = ownRadius(obstacle);
  if (obstacle.circle) return distanceToBox(outline[0], box) <= radius;
  const ring = !obstacle.line;
  const [xmin, ymin, xmax, ymax] = box;
  if (ring && inside(outline, [xmin, ymin])) return true;
  const sides = ring ? outline.length : outline.length - 1;
  for (let k = 0; k < sides; k += 1) {
    if (segmentNearBox(outline[k], outline[(k + 1) % outline.length], [xmin, ymin, xmax, ymax], radius)) return true;
  }
  return false;
}

/**
 * Whether a segment comes within a distance of a box.
 * @param {Point} a
 * @param {Point} b
 * @param {Box} box
 * @param {number} distance
 */
function segmentNearBox(a, b, box, distance) {
  if (!overlap(/** @type {Box} */ (boxRound([a, b], distance)), box)) return false;
  if (distanceToBox(a, box) <= distance || distanceToBox(b, box) <= distance) return true;
  const [xmin, ymin, xmax, ymax] = box;
  /** @type {Point[]} */
  const corners = [[xmin, ymin], [xmax, ymin], [xmax, ymax], [xmin, ymax]];
  const side = (/** @type {Point} */ [x, y]) => Math.sign((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]));
  // Both ends lie outside: it passes where corners lie on both sides of it, or near a corner.
  if (new Set(corners.map(side)).size > 1) return true;
  return corners.some((corner) => {
    const on = nearestOnSegment(a, b, corner);
    return Math.hypot(on[0] - corner[0], on[1] - corner[1]) <= distance;
  });
}
