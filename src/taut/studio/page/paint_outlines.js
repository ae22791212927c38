// @ts-check
// Outlines as pixels: places are subtracted and cut to the board in doubles before the canvas, which counts in single
// precision, sees them. So a map of a micrometre and a wall of a thousand kilometres are drawn alike.

import { boxOf, outlineOf, ownRadius, shapeOf } from "studio/scene.js";

/**
 * @typedef {import("studio/board.js").View} View
 * @typedef {[number, number]} Pixel
 */

/** Starts and goals are drawn as discs of at least so many pixels radius. */
export const LEAST_DISC = 5;
/** Pixels beyond the board at which outlines are cut. */
const MARGIN = 64;
/** Outlines that reach farther than this many pixels from the board are cut. */
const FAR = 8192;
/** Straight pieces for the part of a large circle that is in sight. */
const PIECES = 96;

/**
 * Add a ring of places to the path of the context.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {Iterable<import("studio/scene.js").Point>} ring
 */
export function traceRing(context, view, ring) {
  const pixels = /** @type {Pixel[]} */ ([]);
  for (const [x, y] of ring) pixels.push([view.x(x), view.y(y)]);
  tracePixels(context, view, pixels);
}

/**
 * Add a chain of places to the path of the context.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {readonly import("studio/scene.js").Point[]} chain
 * @param {number} [reach] pixels that its stroke reaches beside it
 */
export function traceChain(context, view, chain, reach = 0) {
  let pen = /** @type {Pixel | null} */ (null);
  for (let k = 0; k + 1 < chain.length; k += 1) {
    const piece = cutSegment(
      [view.x(chain[k][0]), view.y(chain[k][1])], [view.x(chain[k + 1][0]), view.y(chain[k + 1][1])],
      -MARGIN - reach, -MARGIN - reach, view.width + MARGIN + reach, view.height + MARGIN + reach);
    if (!piece) continue;
    const [from, to] = piece;
    if (!pen || pen[0] !== from[0] || pen[1] !== from[1]) context.moveTo(...from);
    context.lineTo(...to);
    pen = to;
  }
}

/**
 * Add a circle to the path of the context. Of one much larger than the board the part in sight is added.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {import("studio/scene.js").Point} centre
 * @param {number} radius metres
 */
export function traceCircle(context, view, [x, y], radius) {
  const [cx, cy, r] = [view.x(x), view.y(y), radius * view.camera.scale];
  if (r < FAR) {
    context.moveTo(cx + r, cy);
    context.arc(cx, cy, r, 0, 2 * Math.PI);
    return;
  }
  const towards = Math.atan2(view.height / 2 - cy, view.width / 2 - cx);
  const spread = Math.min(Math.PI, (2 * (view.width + view.height + MARGIN)) / r);
  const sector = Array.from({ length: PIECES + 1 }, (_, k) => {
    const angle = towards + spread * ((2 * k) / PIECES - 1);
    return /** @type {Pixel} */ ([cx + r * Math.cos(angle), cy + r * Math.sin(angle)]);
  });
  if (spread < Math.PI) sector.push([cx, cy]);
  tracePixels(context, view, sector);
}

/**
 * Fill and stroke one obstacle; nothing if it is out of sight.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {import("studio/scene.js").Obstacle} obstacle
 * @param {string} face
 * @param {string} edge
 * @param {number} width pixels of the edge
 */
export function paintObstacle(context, view, obstacle, face, edge, width) {
  if (!inSight(view, boxOf(obstacle), width)) return;
  context.beginPath();
  if (shapeOf(obstacle) === "line") {
    paintWall(context, view, obstacle, face, edge, width);
    return;
  }
  traceObstacle(context, view, obstacle);
  context.fillStyle = face;
  context.fill();
  context.strokeStyle = edge;
  context.lineWidth = width;
  context.stroke();
}

/**
 * Add the outline of an obstacle (of a wall: its middle line) to the path of the context.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {import("studio/scene.js").Obstacle} obstacle
 */
export function traceObstacle(context, view, obstacle) {
  const outline = outlineOf(obstacle);
  if (obstacle.circle) traceCircle(context, view, obstacle.circle, obstacle.radius ?? 0);
  else if (obstacle.line) traceChain(context, view, outline, ownRadius(obstacle) * view.camera.scale);
  else traceRing(context, view, outline);
}

/**
 * Pixels of the radius with which a start or goal is drawn.
 * @param {{camera: {scale: number}}} view
 * @param {{radius?: number}} robot
 */
export function discRadius({ camera }, { radius = 0 }) {
  return Math.max(radius * camera.scale, LEAST_DISC);
}

/**
 * Whether any of a box is on the board.
 * @param {View} view
 * @param {import("studio/scene.js").Box} box
 * @param {number} reach pixels beyond it that count
 */
export function inSight(view, [xmin, ymin, xmax, ymax], reach) {
  return view.x(xmax) >= -reach && view.x(xmin) <= view.width + reach
    && view.y(ymin) >= -reach && view.y(ymax) <= view.height + reach;
}

/**
 * A wall is a broad stroke with round ends and joints, and its edge a slightly broader one beneath.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {import("studio/scene.js").Obstacle} wall
 * @param {string} face
 * @param {string} edge
 * @param {number} width
 */
function paintWall(context, view, wall, face, edge, width) {
  const broad = 2 * ownRadius(wall) * view.camera.scale;
  if (broad > FAR) {
    paintBroadWall(context, view, wall, face, edge, width);
    return;
  }
  traceObstacle(context, view, wall);
  context.lineCap = "round";
  context.lineJoin = "round";
  context.strokeStyle = edge;
  context.lineWidth = broad + width;
  context.stroke();
  if (broad > width) {
    context.strokeStyle = face;
    context.lineWidth = broad - width;
    context.stroke();
  }
}

/**
 * A wall broader than the board: too broad for a stroke to be exact, so its straight parts and joints are shapes.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {import("studio/scene.js").Obstacle} wall
 * @param {string} face
 * @param {string} edge
 * @param {number} width
 */
function paintBroadWall(context, view, wall, face, edge, width) {
  const [chain, radius] = [outlineOf(wall), ownRadius(wall)];
  const parts = chain.map((joint) => () => traceCircle(context, view, joint, radius));
  for (let k = 0; k + 1 < chain.length; k += 1) {
    const [[ax, ay], [bx, by]] = [chain[k], chain[k + 1]];
    const reach = radius / (Math.hypot(bx - ax, by - ay) || 1);
    const [nx, ny] = [(by - ay) * reach, (ax - bx) * reach];
    parts.push(() => traceRing(context, view,
      [[ax + nx, ay + ny], [bx + nx, by + ny], [bx - nx, by - ny], [ax - nx, ay - ny]]));
  }
  context.strokeStyle = edge;
  context.lineWidth = 2 * width; // half of it is covered by the faces, which come after all edges
  context.fillStyle = face;
  for (const finish of [() => context.stroke(), () => context.fill()]) {
    for (const trace of parts) {
      context.beginPath();
      trace();
      finish();
    }
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {Pixel[]} ring
 */
function tracePixels(context, { width, height }, ring) {
  const far = ring.some(([x, y]) => x < -FAR || y < -FAR || x > width + FAR || y > height + FAR);
  const kept = far ? cutRing(ring, -MARGIN, -MARGIN, width + MARGIN, height + MARGIN) : ring;
  kept.forEach(([x, y], k) => (k === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
  if (kept.length > 0) context.closePath();
}

/**
 * Cut a ring to a box, side by side; edges that this makes run along the box.
 * @param {Pixel[]} ring
 * @param {number} left
 * @param {number} top
 * @param {number} right
 * @param {number} low
 * @returns {Pixel[]}
 */
function cutRing(ring, left, top, right, low) {
  let kept = ring;
  for (const [axis, limit, sign] of [[0, left, 1], [0, right, -1], [1, top, 1], [1, low, -1]]) {
    const all = kept;
    kept = [];
    all.forEach((point, k) => {
      const before = all[(k + all.length - 1) % all.length];
      const [inside, wasInside] = [sign * (point[axis] - limit) >= 0, sign * (before[axis] - limit) >= 0];
      if (inside !== wasInside) kept.push(crossing(before, point, axis, limit));
      if (inside) kept.push(point);
    });
  }
  return kept;
}

/**
 * Where the straight line between two points has a coordinate.
 * @param {Pixel} a
 * @param {Pixel} b
 * @param {number} axis
 * @param {number} limit
 * @returns {Pixel}
 */
function crossing(a, b, axis, limit) {
  const share = (limit - a[axis]) / (b[axis] - a[axis]);
  const other = a[1 - axis] + share * (b[1 - axis] - a[1 - axis]);
  return axis === 0 ? [limit, other] : [other, limit];
}

/**
 * The part of a segment in a box, or null.
 * @param {Pixel} a
 * @param {Pixel} b
 * @param {number} left
 * @param {number} top
 * @param {number} right
 * @param {number} low
 * @returns {[Pixel, Pixel] | null}
 */
function cutSegment(a, b, left, top, right, low) {
  let [begin, end] = [0, 1];
  const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
  for (const [step, room] of [[-dx, a[0] - left], [dx, right - a[0]], [-dy, a[1] - top], [dy, low - a[1]]]) {
    if (step === 0) {
      if (room < 0) return null;
    } else if (step < 0) begin = Math.max(begin, room / step);
    else end = Math.min(end, room / step);
  }
  if (begin > end) return null;
  const at = (/** @type {number} */ share) => /** @type {Pixel} */ ([a[0] + share * dx, a[1] + share * dy]);
  return [begin === 0 ? a : at(begin), end === 1 ? b : at(end)];
}
