// @ts-check
// Edits of outlines: corners put, added and taken away, sides moved, sizes drawn by handles.

import { EditError, place, theObstacle } from "studio/edits_checks.js";
import { difference, direction, shifted, sum, turned } from "studio/edits_numbers.js";
import { withObstacle, withOutline, withWorkspace } from "studio/edits_replacing.js";
import { isRing, obstacleNamed, outlineOf, verticesOf, workspaceRing } from "studio/scene.js";

/** @typedef {import("./scene.js").Scene} Scene */
/** @typedef {import("./scene.js").Ref} Ref */
/** @typedef {import("./scene.js").Point} Point */
/** @typedef {import("./scene.js").Obstacle} Obstacle */

/**
 * Whether editing a corner makes a polygon of a thing that is more than that now; labels say so.
 * @param {Scene} scene
 * @param {Ref} ref
 */
export function becomesPolygon(scene, ref) {
  if (ref.kind === "workspace") return scene.bounds !== undefined;
  return ref.kind === "obstacle" && obstacleNamed(scene, ref.name)?.rectangle !== undefined;
}

/**
 * Put a corner at a point.
 * @param {Scene} scene
 * @param {Ref} ref with the number of the corner
 * @param {Point} point
 * @returns {Scene}
 */
export function setVertex(scene, ref, point) {
  const at = place(point, "A corner");
  const vertex = cornerOf(scene, ref);
  return withPoints(scene, ref, cornersOf(scene, ref).map((corner, k) => (k === vertex ? at : corner)));
}

/**
 * Add a corner in a side; side k runs from corner k to the next.
 * @param {Scene} scene
 * @param {Ref} ref
 * @param {number} edge
 * @param {Point} point
 * @returns {Scene}
 */
export function insertVertex(scene, ref, edge, point) {
  const at = place(point, "A corner");
  return withPoints(scene, ref, spliced(cornersOf(scene, ref), sideOf(scene, ref, edge) + 1, 0, at));
}

/**
 * Take a corner away.
 * @param {Scene} scene
 * @param {Ref} ref with the number of the corner
 * @returns {Scene}
 */
export function removeVertex(scene, ref) {
  const corners = cornersOf(scene, ref);
  const vertex = cornerOf(scene, ref);
  const least = isRing(scene, ref) ? 3 : 2;
  if (corners.length <= least) {
    const [what, parts] = least === 3 ? ["An outline", "corners"] : ["A wall", "points"];
    throw new EditError(`${what} needs at least ${least} ${parts}; remove the whole instead.`);
  }
  return withPoints(scene, ref, spliced(corners, vertex, 1));
}

/**
 * Move a side with the two corners at its ends.
 * @param {Scene} scene
 * @param {Ref} ref
 * @param {number} edge
 * @param {number} dx
 * @param {number} dy
 * @returns {Scene}
 */
export function edgeMoved(scene, ref, edge, dx, dy) {
  const corners = cornersOf(scene, ref);
  const first = sideOf(scene, ref, edge);
  const ends = [first, (first + 1) % corners.length];
  return withPoints(scene, ref, corners.map((corner, k) => (ends.includes(k) ? shifted(corner, dx, dy) : corner)));
}

/**
 * Where the handles of a thing with a size are: corners 0 to 3 and the middles of the bottom, right, top and left side
 * (as they lie before turning), or one point on a circle.
 * @param {Scene} scene
 * @param {Ref} ref
 * @returns {Point[]}
 */
export function handlesOf(scene, ref) {
  const obstacle = ref.kind === "obstacle" ? obstacleNamed(scene, ref.name) : undefined;
  if (obstacle?.circle) return [shifted(obstacle.circle, obstacle.radius ?? 0, 0)];
  if (!obstacle?.rectangle && !(ref.kind === "workspace" && scene.bounds)) return [];
  const corners = verticesOf(scene, ref);
  const middles = corners.map(([x, y], k) => {
    const [nextX, nextY] = corners[(k + 1) % 4];
    return /** @type {Point} */ ([(x + nextX) / 2, (y + nextY) / 2]);
  });
  return [...corners, ...middles];
}

/**
 * Draw a handle to a point; what lies opposite stays. Nothing changes where the thing would have no size.
 * @param {Scene} scene
 * @param {Ref} ref
 * @param {number} handle as handlesOf numbers them
 * @param {Point} point
 * @returns {Scene}
 */
export function resized(scene, ref, handle, point) {
  const [x, y] = place(point, "A handle");
  if (ref.kind === "workspace") {
    if (!scene.bounds) throw new EditError("This workspace is a polygon: its corners and sides are moved instead.");
    const [x0, y0, width, height] = drawn(boxToRectangle(scene.bounds), handle, [x, y]);
    if (!(width > 0 && height > 0)) return scene;
    return withWorkspace(scene, workspaceRing({ ...scene, bounds: [x0, y0, sum(x0, width), sum(y0, height)] }));
  }
  const obstacle = theObstacle(scene, ref);
  if (obstacle.circle) {
    const radius = lengthBetween(obstacle.circle, [x, y]);
    return radius > 0 ? withObstacle(scene, obstacle.name, { ...obstacle, radius }) : scene;
  }
  if (!obstacle.rectangle) throw new EditError(`${obstacle.name} has no handles: its corners are moved instead.`);
  const rectangle = obstacle.angle
    ? drawnTurned(obstacle.rectangle, obstacle.angle, handle, [x, y])
    : drawn(obstacle.rectangle, handle, [x, y]);
  if (!(rectangle[2] > 0 && rectangle[3] > 0)) return scene;
  return withObstacle(scene, obstacle.name, { ...obstacle, rectangle });
}

/**
 * Distance of two points with no more digits than it deserves: along an axis as on paper, else to twelve digits.
 * @param {Point} a
 * @param {Point} b
 */
function lengthBetween(a, b) {
  const [dx, dy] = [Math.abs(difference(b[0], a[0])), Math.abs(difference(b[1], a[1]))];
  return dx === 0 || dy === 0 ? dx + dy : trimmed(Math.hypot(dx, dy));
}

/** @param {number} length computed, not typed */
function trimmed(length) {
  return Number(length.toPrecision(12));
}

/** @param {readonly number[]} bounds */
function boxToRectangle([xmin, ymin, xmax, ymax]) {
  return [xmin, ymin, difference(xmax, xmin), difference(ymax, ymin)];
}

const MOVES_LEFT = [0, 3, 7];
const MOVES_RIGHT = [1, 2, 5];
const MOVES_BOTTOM = [0, 1, 4];
const MOVES_TOP = [2, 3, 6];

/**
 * @param {readonly number[]} rectangle
 * @param {number} handle
 * @param {Point} point
 * @returns {[number, number, number, number]}
 */
function drawn([x, y, width, height], handle, point) {
  const [x0, x1] = ordered(
    MOVES_LEFT.includes(handle) ? point[0] : x,
    MOVES_RIGHT.includes(handle) ? point[0] : sum(x, width),
  );
  const [y0, y1] = ordered(
    MOVES_BOTTOM.includes(handle) ? point[1] : y,
    MOVES_TOP.includes(handle) ? point[1] : sum(y, height),
  );
  return [x0, y0, difference(x1, x0), difference(y1, y0)];
}

/**
 * @param {readonly number[]} rectangle
 * @param {number} angle
 * @param {number} handle
 * @param {Point} point
 * @returns {[number, number, number, number]}
 */
function drawnTurned([x, y, width, height], angle, handle, point) {
  const middle = [x + width / 2, y + height / 2];
  const [left, bottom, wide, high] = drawn([x, y, width, height], handle, turned(point, middle, -angle));
  const [w, h] = [trimmed(wide), trimmed(high)];
  const [dx, dy] = [left + wide / 2 - middle[0], bottom + high / 2 - middle[1]];
  const [cos, sin] = direction(angle);
  return [middle[0] + cos * dx - sin * dy - w / 2, middle[1] + sin * dx + cos * dy - h / 2, w, h];
}

/**
 * @param {number} a
 * @param {number} b
 */
function ordered(a, b) {
  return a <= b ? [a, b] : [b, a];
}

/**
 * Corners of a thing that has any to edit.
 * @param {Scene} scene
 * @param {Ref} ref
 * @returns {Point[]}
 */
function cornersOf(scene, ref) {
  if (ref.kind === "workspace") return [...workspaceRing(scene)];
  const obstacle = theObstacle(scene, ref);
  if (obstacle.circle) throw new EditError(`${obstacle.name} is a circle: it has no corners.`);
  return [...outlineOf(obstacle)];
}

/**
 * @param {Scene} scene
 * @param {Ref} ref
 */
function cornerOf(scene, ref) {
  const { vertex } = ref;
  if (vertex === undefined || !(vertex in cornersOf(scene, ref))) {
    throw new EditError("That corner is not there any more.");
  }
  return vertex;
}

/**
 * @param {Scene} scene
 * @param {Ref} ref
 * @param {number} edge
 */
function sideOf(scene, ref, edge) {
  const sides = cornersOf(scene, ref).length - (isRing(scene, ref) ? 0 : 1);
  if (!(Number.isInteger(edge) && edge >= 0 && edge < sides)) throw new EditError("That side is not there any more.");
  return edge;
}

/**
 * Points with some taken out or put in; ES2022 has no toSpliced.
 * @param {readonly Point[]} points
 * @param {number} first
 * @param {number} out
 * @param {...Point} added
 */
function spliced(points, first, out, ...added) {
  return [...points.slice(0, first), ...added, ...points.slice(first + out)];
}

/**
 * @param {Scene} scene
 * @param {Ref} ref
 * @param {readonly Point[]} points
 */
function withPoints(scene, ref, points) {
  if (ref.kind === "workspace") return withWorkspace(scene, points);
  const obstacle = theObstacle(scene, ref);
  return withObstacle(scene, obstacle.name, withOutline(obstacle, points));
}
