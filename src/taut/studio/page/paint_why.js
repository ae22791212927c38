// @ts-check
// Why a robot has no path: what it can reach from its start, what from its goal, and the gap that is too narrow.

import { toScreen } from "studio/camera.js";
import { faded } from "studio/colours.js";
import { lengthText } from "studio/grid.js";
import { discRadius, traceRing } from "studio/paint_outlines.js";
import { paintPin } from "studio/paint_problems.js";
import { paintBubble, paintPlate } from "studio/paint_words.js";
import { robotNamed } from "studio/scene.js";

/**
 * @typedef {import("studio/board.js").View} View
 * @typedef {{place: [number, number], ends?: [number, number][] | null, room: number, needed: number}} Gap
 */

/** Pixels between the lines of a hatching. */
const HATCH = 9;

/**
 * Layer beneath the robots: the two areas. Nothing while there is a plan.
 * @type {import("studio/board.js").Layer}
 */
export function paintWhy(context, view) {
  const { from = [], to = [] } = failure(view)?.why ?? {};
  paintArea(context, view, from, view.colours.start, 1);
  paintArea(context, view, to, view.colours.goal, -1);
}

/**
 * Layer above the robots: what the areas are, the gap between them, else the place of what went wrong.
 * @type {import("studio/board.js").Layer}
 */
export function paintWhyWords(context, view) {
  const wrong = failure(view);
  if (!wrong) return;
  const { from = [], to = [], gap = null } = wrong.why ?? {};
  const { scene, problems, sketch } = view.state;
  const { colours } = view;
  const robot = robotNamed(scene, wrong.names?.[0]);
  if (robot && from.length > 0) nameArea(context, view, robot, "start", gap, "reached from the start");
  if (robot && to.length > 0) nameArea(context, view, robot, "goal", gap, "reaches the goal");
  if (gap) paintGap(context, view, gap, robot?.name ?? "it");
  else if (wrong.place && !(problems?.length > 0)) {
    paintPin(context, view, wrong.place);
    const [x, y] = toScreen(view, wrong.place);
    if (!sketch) paintBubble(context, view, wrong.message, x, y - 19, colours.bad);
  }
}

/** @param {View} view */
function failure({ state: { planning, scene } }) {
  return scene && planning?.state === "failed" ? planning.wrong : null;
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
  context.fillStyle = faded(colour, 0.06);
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
  context.strokeStyle = faded(colour, 0.24);
  context.stroke();
  context.restore();
}

/**
 * A plate below a start or goal, or above it where the gap's is below.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {import("studio/scene.js").Robot} robot
 * @param {"start" | "goal"} end
 * @param {Gap | null} gap
 * @param {string} words
 */
function nameArea(context, view, robot, end, gap, words) {
  const [x, y] = [view.x(robot[end][0]), view.y(robot[end][1])];
  const aside = discRadius(view, robot) + 15;
  const near = gap && Math.abs(view.x(gap.place[0]) - x) < 180 && Math.abs(view.y(gap.place[1]) + 20 - y - aside) < 22;
  const face = { face: view.colours[end], ink: view.colours.dark ? "#16181b" : "#ffffff" };
  paintPlate(context, view, words, x, near ? y - aside : y + aside, face);
}

/**
 * The narrowest place: how much room there is, and how much is needed.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {Gap} gap
 * @param {string} name of the robot that does not fit
 */
function paintGap(context, view, { place, ends, room, needed }, name) {
  const { colours } = view;
  const [x, y] = toScreen(view, place);
  const [a, b] = ends?.length === 2 ? ends.map((end) => toScreen(view, end)) : [[x, y], [x, y]];
  const length = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
  const [nx, ny] = [(-(b[1] - a[1]) / length) * 6, ((b[0] - a[0]) / length) * 6];
  context.beginPath();
  context.moveTo(a[0], a[1]);
  context.lineTo(b[0], b[1]);
  for (const [endX, endY] of [a, b]) {
    context.moveTo(endX - nx, endY - ny);
    context.lineTo(endX + nx, endY + ny);
  }
  context.lineWidth = 5;
  context.strokeStyle = colours.halo;
  context.stroke();
  context.lineWidth = 2;
  context.strokeStyle = colours.bad;
  context.stroke();
  const face = { face: colours.bad, ink: colours.dark ? "#16181b" : "#ffffff" };
  const below = Math.max(a[1], b[1], y) + 20;
  paintPlate(context, view, `${name} needs ${lengthText(needed)}: here are ${lengthText(room)}`, x, below, face);
}
