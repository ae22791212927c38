// @ts-check
// What a tool is drawing: shapes to be, the box of a selection, snapping guides, and live sizes.

import { faded } from "studio/colours.js";
import { discRadius, traceChain, traceCircle, traceRing } from "studio/paint_outlines.js";
import { paintPlate } from "studio/paint_words.js";
import { distance } from "studio/tool_labels.js";

/** @typedef {import("studio/board.js").View} View */

/** Pixels from a line to the number that measures it, and from a thing to the number beneath. */
const BESIDE = 16;
const BENEATH = 18;

/**
 * Layer: the sketch of the running tool.
 * @type {import("studio/board.js").Layer}
 */
export function paintSketch(context, view) {
  const { sketch } = view.state;
  if (!sketch) return;
  context.lineJoin = "round";
  context.lineCap = "round";
  PAINTERS[/** @type {keyof typeof PAINTERS} */ (sketch.kind)]?.(context, view, sketch);
  for (const guide of sketch.guides ?? []) paintGuide(context, view, guide);
  for (const label of sketch.labels ?? []) paintLabel(context, view, label);
}

/** @type {Record<string, (context: CanvasRenderingContext2D, view: View, sketch: any) => void>} */
const PAINTERS = {
  box(context, view, { points: [a, b] }) {
    traced(context, view, () => traceRing(context, view, corners(a, b)), 1, 0.1);
  },

  rectangle(context, view, { points: [a, b] }) {
    traced(context, view, () => traceRing(context, view, corners(a, b)), 2, 0.18);
  },

  circle(context, view, { points: [centre, rim] }) {
    traced(context, view, () => traceCircle(context, view, centre, distance(centre, rim)), 2, 0.18);
    paintLine(context, view, centre, rim, []);
    paintDot(context, view, centre);
  },

  polygon(context, view, { points, cursor, closing }) {
    const ring = cursor && !closing ? [...points, cursor] : points;
    traced(context, view, () => traceRing(context, view, ring), 0, 0.14);
    paintChain(context, view, points, cursor);
    if (!closing && cursor && points.length > 1) paintLine(context, view, cursor, points[0], [4, 4]);
    paintFirst(context, view, points, closing);
  },

  wall(context, view, { points, cursor, closing, width }) {
    context.beginPath();
    const chain = cursor ? [...points, cursor] : points;
    traceChain(context, view, chain.length > 1 ? chain : [...chain, ...chain], width * view.camera.scale);
    context.strokeStyle = faded(view.colours.accent, 0.3);
    context.lineWidth = Math.max(width * view.camera.scale, 2);
    context.stroke();
    paintChain(context, view, points, cursor);
    paintFirst(context, view, points, closing);
  },

  robot(context, view, { points: [start, goal] }) {
    const { scene, robotRadius } = view.state;
    const radius = discRadius(view, { radius: robotRadius ?? scene.robots.at(-1)?.radius ?? 0.2 });
    const colour = view.colours.robot(scene.robots.length);
    context.strokeStyle = colour;
    context.lineWidth = 1.5;
    context.setLineDash([5, 5]);
    context.beginPath();
    traceChain(context, view, [start, goal]);
    context.stroke();
    context.setLineDash([]);
    for (const [place, solid] of /** @type {const} */ ([[start, true], [goal, false]])) {
      context.beginPath();
      context.arc(view.x(place[0]), view.y(place[1]), radius, 0, 2 * Math.PI);
      context.fillStyle = solid ? colour : faded(colour, 0.2);
      context.fill();
      context.lineWidth = 2;
      context.strokeStyle = colour;
      context.stroke();
    }
  },

  measure(context, view, { points: [a, b] }) {
    paintLine(context, view, a, b, []);
    const angle = Math.atan2(view.y(b[1]) - view.y(a[1]), view.x(b[0]) - view.x(a[0])) + Math.PI / 2;
    context.beginPath();
    for (const place of [a, b]) {
      const [x, y] = [view.x(place[0]), view.y(place[1])];
      context.moveTo(x - 6 * Math.cos(angle), y - 6 * Math.sin(angle));
      context.lineTo(x + 6 * Math.cos(angle), y + 6 * Math.sin(angle));
    }
    context.stroke();
  },

  cursor(context, view, { points: [place] }) {
    paintDot(context, view, place);
  },
};

/**
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {() => void} trace
 * @param {number} width
 * @param {number} opacity
 */
function traced(context, view, trace, width, opacity) {
  context.beginPath();
  trace();
  context.fillStyle = faded(view.colours.accent, opacity);
  context.fill();
  if (width === 0) return;
  context.strokeStyle = view.colours.accent;
  context.lineWidth = width;
  context.stroke();
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {any[]} points
 * @param {any} cursor
 */
function paintChain(context, view, points, cursor) {
  context.beginPath();
  traceChain(context, view, cursor ? [...points, cursor] : points);
  context.strokeStyle = view.colours.accent;
  context.lineWidth = 2;
  context.stroke();
  for (const point of points) paintDot(context, view, point);
}

/**
 * The corner that closes when it is clicked again.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {any[]} points
 * @param {boolean} closing
 */
function paintFirst(context, view, [first, , third], closing) {
  if (!third) return;
  context.beginPath();
  context.arc(view.x(first[0]), view.y(first[1]), closing ? 8 : 6, 0, 2 * Math.PI);
  context.fillStyle = closing ? view.colours.accent : view.colours.halo;
  context.fill();
  context.strokeStyle = view.colours.accent;
  context.lineWidth = 2;
  context.stroke();
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {readonly number[]} a
 * @param {readonly number[]} b
 * @param {number[]} dashes
 */
function paintLine(context, view, a, b, dashes) {
  context.beginPath();
  traceChain(context, view, [a, b]);
  context.setLineDash(dashes);
  context.strokeStyle = view.colours.accent;
  context.lineWidth = 1.5;
  context.stroke();
  context.setLineDash([]);
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {readonly number[]} place
 */
function paintDot(context, view, [x, y]) {
  context.beginPath();
  context.arc(view.x(x), view.y(y), 3.5, 0, 2 * Math.PI);
  context.fillStyle = view.colours.accent;
  context.fill();
  context.lineWidth = 1.5;
  context.strokeStyle = view.colours.halo;
  context.stroke();
}

/**
 * What a place snapped to: a line that it lies on, or a mark on what it took.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {any} guide
 */
function paintGuide(context, view, guide) {
  context.strokeStyle = view.colours.bad;
  context.lineWidth = 1;
  context.beginPath();
  if (guide.kind === "line") {
    traceChain(context, view, [guide.from, guide.to]);
    context.setLineDash([4, 3]);
    context.stroke();
    context.setLineDash([]);
    return;
  }
  if (guide.what === "grid") return; // the grid is there to be seen
  const [x, y] = [view.x(guide.at[0]), view.y(guide.at[1])];
  context.lineWidth = 1.5;
  if (guide.what === "vertex") context.rect(x - 5, y - 5, 10, 10);
  else {
    context.moveTo(x - 5, y - 5);
    context.lineTo(x + 5, y + 5);
    context.moveTo(x + 5, y - 5);
    context.lineTo(x - 5, y + 5);
  }
  context.stroke();
}

/**
 * A number beside the line that it measures, or beneath its place.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {import("studio/tool_labels.js").Label} label
 */
function paintLabel(context, view, { at, text, from }) {
  const [x, y] = [view.x(at[0]), view.y(at[1])];
  if (!from) {
    paintPlate(context, view, text, x, y + BENEATH, {});
    return;
  }
  const [dx, dy] = [x - view.x(from[0]), y - view.y(from[1])];
  const length = Math.hypot(dx, dy) || 1;
  const up = dx >= 0 ? -1 : 1; // above the line, whichever way it was drawn
  const aside = BESIDE + Math.abs(dy / length) * 26;
  paintPlate(context, view, text, x - (up * dy * aside) / length, y + (up * dx * aside) / length, {});
}

/**
 * @param {readonly number[]} a
 * @param {readonly number[]} b
 */
function corners(a, b) {
  return [a, [b[0], a[1]], b, [a[0], b[1]]];
}
