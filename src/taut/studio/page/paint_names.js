// @ts-check
// Names on the map: of obstacles inside them, of robots on or beside their starts and goals, never one over another.

import { contrast } from "studio/colours.js";
import { discRadius, inSight } from "studio/paint_outlines.js";
import { boxOf, outlineOf, ownRadius, shapeOf } from "studio/scene.js";

/** @typedef {import("studio/board.js").View} View */

const NAME = "600 11px system-ui, sans-serif";
/** Labels are laid out in cells of this many pixels, to find quickly which would overlap. */
const CELL = 24;
/** With more robots in sight than this only the chosen ones are named beside their discs: zoom in for the others. */
const CROWD = 30;

/**
 * Names inside obstacles, where they fit.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 */
export function nameObstacles(context, view) {
  context.font = NAME;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillStyle = view.colours.obstacleInk;
  for (const obstacle of view.state.scene.obstacles) nameObstacle(context, view, obstacle);
}

/**
 * Names on starts and goals where they fit, else beside them where nothing is written yet; those of chosen robots
 * come first, and in a crowd alone.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {boolean} left whether the robots have left their starts
 */
export function nameRobots(context, view, left) {
  const { state: { scene, hover, selection } } = view;
  const chosen = new Set([...(selection ?? []), ...(hover ? [hover] : [])]
    .filter((ref) => ref.kind !== "obstacle").map((ref) => ref.name));
  const room = createRoom();
  context.font = NAME;
  context.textBaseline = "middle";
  context.lineJoin = "round";
  context.lineWidth = 3;
  context.strokeStyle = view.colours.halo;
  const ends = scene.robots.flatMap((/** @type {any} */ robot, /** @type {number} */ k) => [
    { robot, k, place: robot.start, solid: !left, first: chosen.has(robot.name) },
    { robot, k, place: robot.goal, solid: false, first: chosen.has(robot.name) },
  ]).filter((/** @type {any} */ { place: [x, y] }) => inSight(view, [x, y, x, y], 20));
  const crowd = ends.length > 2 * CROWD;
  for (const { robot, place } of ends) {
    const half = Math.min(discRadius(view, robot) * 0.7, 200);
    room.put(view.x(place[0]) - half, view.y(place[1]) - half, 2 * half, 2 * half);
  }
  for (const end of ends.sort((/** @type {any} */ a, /** @type {any} */ b) => Number(b.first) - Number(a.first))) {
    nameEnd(context, view, room, end, !crowd || end.first);
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {ReturnType<typeof createRoom>} room
 * @param {{robot: any, k: number, place: readonly number[], solid: boolean}} end
 * @param {boolean} beside whether it may be written beside the disc
 */
function nameEnd(context, view, room, { robot, k, place, solid }, beside) {
  const [x, y] = [view.x(place[0]), view.y(place[1])];
  const radius = discRadius(view, robot);
  const width = context.measureText(robot.name).width;
  if (width + 8 < 2 * radius) {
    context.textAlign = "center";
    context.fillStyle = solid ? inkOn(view.colours.robot(k)) : view.colours.robotInk(k);
    context.fillText(robot.name, x, place === robot.goal ? y - Math.min(radius / 2, 12) : y);
    return;
  }
  if (!beside) return;
  const aside = radius * 0.8;
  const [right, left, up, down] = [x + aside + 3, x - aside - 3 - width, y - aside - 4, y + aside + 5];
  for (const [at, middle] of [[right, up], [left, up], [right, down], [left, down]]) {
    const shown = at >= 0 && at + width <= view.width;
    if (!shown || !room.take(at, middle - 6, width, 12)) continue;
    context.textAlign = "left";
    context.strokeText(robot.name, at, middle);
    context.fillStyle = view.colours.robotInk(k);
    context.fillText(robot.name, at, middle);
    return;
  }
}

/** Which part of the board is taken: `put` takes a box, `take` only if it is free, and says so. */
function createRoom() {
  /** @type {Map<number, number[][]>} */
  const cells = new Map();
  const cellsOf = (/** @type {number[]} */ [x, y, width, height]) => {
    const keys = [];
    for (let i = Math.floor(x / CELL); i * CELL < x + width; i += 1) {
      for (let j = Math.floor(y / CELL); j * CELL < y + height; j += 1) keys.push(i * 65536 + j);
    }
    return keys;
  };
  const put = (/** @type {number[]} */ ...box) => {
    for (const key of cellsOf(box)) {
      const boxes = cells.get(key);
      if (boxes) boxes.push(box);
      else cells.set(key, [box]);
    }
  };

  return {
    put,

    take(/** @type {number[]} */ ...box) {
      const [x, y, width, height] = box;
      const free = cellsOf(box).every((key) => !cells.get(key)?.some(([a, b, w, h]) =>
        a < x + width && x < a + w && b < y + height && y < b + h));
      if (free) put(...box);
      return free;
    },
  };
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {import("studio/scene.js").Obstacle} obstacle
 */
function nameObstacle(context, view, obstacle) {
  const box = boxOf(obstacle);
  const { scale } = view.camera;
  const [across, up] = [(box[2] - box[0]) * scale, (box[3] - box[1]) * scale];
  if (across < 20 || up < 14 || !inSight(view, box, 0)) return;
  const place = placeInside(obstacle);
  if (!place || place.room * scale * 2 < 14) return;
  const width = context.measureText(obstacle.name).width;
  if (Math.hypot(width, 12) / 2 > place.room * scale) return;
  context.fillText(obstacle.name, view.x(place.x), view.y(place.y));
}

/** @type {WeakMap<object, {x: number, y: number, room: number} | null>} */
const places = new WeakMap();

/**
 * The place inside an obstacle that is farthest from its outline (to a coarse grid), and how far; null in a wall.
 * @param {import("studio/scene.js").Obstacle} obstacle
 */
function placeInside(obstacle) {
  let place = places.get(obstacle);
  if (place === undefined) {
    place = shapeOf(obstacle) === "line" ? null : widestPlace(obstacle);
    places.set(obstacle, place);
  }
  return place;
}

/**
 * @param {import("studio/scene.js").Obstacle} obstacle
 * @returns {{x: number, y: number, room: number} | null}
 */
function widestPlace(obstacle) {
  const [xmin, ymin, xmax, ymax] = boxOf(obstacle);
  const middle = { x: (xmin + xmax) / 2, y: (ymin + ymax) / 2 };
  if (shapeOf(obstacle) === "circle") return { ...middle, room: ownRadius(obstacle) };
  const ring = outlineOf(obstacle);
  const spots = [middle, mean(ring)];
  for (let i = 1; i < 8; i += 1) {
    for (let j = 1; j < 8; j += 1) {
      spots.push({ x: xmin + ((xmax - xmin) * i) / 8, y: ymin + ((ymax - ymin) * j) / 8 });
    }
  }
  let best = null;
  for (const { x, y } of spots) {
    const room = depth(ring, x, y);
    if (room > (best ? best.room * 1.02 : 0)) best = { x, y, room };
  }
  return best;
}

/**
 * How deep a point lies in a ring: its distance from the outline, 0 outside.
 * @param {readonly (readonly number[])[]} ring
 * @param {number} x
 * @param {number} y
 */
function depth(ring, x, y) {
  let [inside, least] = [false, Infinity];
  ring.forEach(([ax, ay], k) => {
    const [bx, by] = ring[(k + 1) % ring.length];
    if (ay > y !== by > y && x < ((bx - ax) * (y - ay)) / (by - ay) + ax) inside = !inside;
    const [dx, dy] = [bx - ax, by - ay];
    const share = Math.min(Math.max(((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy || 1), 0), 1);
    least = Math.min(least, Math.hypot(x - ax - share * dx, y - ay - share * dy));
  });
  return inside ? least : 0;
}

/** @param {readonly (readonly number[])[]} ring */
function mean(ring) {
  const sum = ring.reduce(([sx, sy], [x, y]) => [sx + x, sy + y], [0, 0]);
  return { x: sum[0] / ring.length, y: sum[1] / ring.length };
}

/**
 * White or nearly black, whichever reads better on a colour.
 * @param {string} colour #rrggbb
 */
function inkOn(colour) {
  return contrast(colour, "#ffffff") >= 3.4 ? "#ffffff" : "#16181b";
}
