// @ts-check
// Why a robot has no path: what it can reach from its start, what from its goal, and the gap that is too narrow.

import { toScreen } from "studio/camera.js";
import { faded } from "studio/colours.js";
import { lengthText } from "studio/grid.js";
import { traceRing } from "studio/paint_outlines.js";
import { paintPin } from "studio/paint_problems.js";
import { paintBubble, paintPlate } from "studio/paint_words.js";
import { robotNamed } from "studio/scene.js";

/** @typedef {import("studio/board.js").View} View */

/** Pixels between the lines of a hatching. */
const HATCH = 9;

/**
 * Layer: nothing while there is a plan.
 * @type {import("studio/board.js").Layer}
 */
export function paintWhy(context, view) {
  const { planning, scene, problems } = view.state;
  const wrong = planning?.state === "failed" ? planning.wrong : null;
  if (!wrong || !scene) return;
  const { from = [], to = [], gap = null } = wrong.why ?? {};
  const { colours } = view;
  paintArea(context, view, from, colours.start, 1);
  paintArea(context, view, to, colours.goal, -1);
  const robot = robotNamed(scene, wrong.names?.[0]);
  if (robot && from.length > 0) nameArea(context, view, robot.start, "reached from the start", colours.start);
  if (robot && to.length > 0) nameArea(context, view, robot.goal, "reaches the goal", colours.goal);
  if (gap) paintGap(context, view, gap);
  const place = gap?.place ?? wrong.place;
  if (place && !(problems?.length > 0)) {
    paintPin(context, view, place);
    const [x, y] = toScreen(view, place);
    paintBubble(context, view, wrong.message, x, y - 36, colours.bad);
  }
}

/**
 * An area as a light tint with hatching; its rings together are filled by the even-odd rule.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {readonly (readonly [number, number][])[]} rings
 * @param {string} colour
 * @param {1 | -1} slope
 */
function paintArea(context, view, rings, colour, slope) {
  if (rings.length === 0) return;
  context.save();
  context.beginPath();
  for (const ring of rings) traceRing(context, view, ring);
  context.fillStyle = faded(colour, 0.07);
  context.fill("evenodd");
  context.lineWidth = 1;
  context.strokeStyle = faded(colour, 0.5);
  context.stroke();
  context.clip("evenodd");
  context.beginPath();
  const { width, height } = view;
  // Anchored to the map, so that the hatching moves with it.
  const offset = (((slope === 1 ? view.x(0) + view.y(0) : view.x(0) - view.y(0)) % HATCH) + HATCH) % HATCH;
  for (let at = offset - (slope === 1 ? 0 : height); at < width + height; at += HATCH) {
    context.moveTo(at, 0);
    context.lineTo(at - slope * height, height);
  }
  context.strokeStyle = faded(colour, 0.32);
  context.stroke();
  context.restore();
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {readonly number[]} place
 * @param {string} words
 * @param {string} colour
 */
function nameArea(context, view, place, words, colour) {
  const face = { face: colour, ink: view.colours.dark ? "#16181b" : "#ffffff" };
  paintPlate(context, view, words, view.x(place[0]), view.y(place[1]) + 22, face);
}

/**
 * The narrowest place: how much room there is, and how much is needed.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {{place: [number, number], ends?: [number, number][], room: number, needed: number}} gap
 */
function paintGap(context, view, { place, ends, room, needed }) {
  const { colours } = view;
  if (ends?.length === 2) {
    const [a, b] = ends.map((end) => toScreen(view, end));
    const length = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
    const [nx, ny] = [(-(b[1] - a[1]) / length) * 6, ((b[0] - a[0]) / length) * 6];
    context.beginPath();
    context.moveTo(...a);
    context.lineTo(...b);
    for (const [x, y] of [a, b]) {
      context.moveTo(x - nx, y - ny);
      context.lineTo(x + nx, y + ny);
    }
    context.lineWidth = 2;
    context.strokeStyle = colours.bad;
    context.stroke();
  }
  const text = `${lengthText(room)} free, ${lengthText(needed)} needed`;
  const face = { face: colours.bad, ink: colours.dark ? "#16181b" : "#ffffff" };
  paintPlate(context, view, text, view.x(place[0]), view.y(place[1]) + 18, face);
}
