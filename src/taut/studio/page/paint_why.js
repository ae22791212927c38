// @ts-check
// Why a robot has no path: what it can reach from its start, what from its goal, and the gap that is too narrow.

import { toScreen } from "studio/camera.js";
import { faded } from "studio/colours.js";
import { lengthText } from "studio/grid.js";
import { discRadius, traceRing } from "studio/paint_outlines.js";
import { paintPin } from "studio/paint_problems.js";
import { paintBubble, paintPlate, plateWidth } from "studio/paint_words.js";
import { robotNamed } from "studio/scene.js";

/**
 * @typedef {import("studio/board.js").View} View
 * @typedef {[number, number, number, number]} Box pixels: left, top, right, bottom
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
  const taken = endBoxes(view);
  if (gap) paintGap(context, view, gap, robot?.name ?? "it", taken);
  if (robot && from.length > 0) nameArea(context, view, robot, "start", "reached from the start", taken);
  if (robot && to.length > 0) nameArea(context, view, robot, "goal", "reaches the goal", taken);
  if (gap) return;
  if (wrong.place && !(problems?.length > 0)) {
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
 * A plate at a start or goal.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {import("studio/scene.js").Robot} robot
 * @param {"start" | "goal"} end
 * @param {string} words
 * @param {Box[]} taken
 */
function nameArea(context, view, robot, end, words, taken) {
  const [x, y] = [view.x(robot[end][0]), view.y(robot[end][1])];
  const radius = discRadius(view, robot);
  const face = { face: view.colours[end], ink: view.colours.dark ? "#16181b" : "#ffffff" };
  paintAside(context, view, words, [x, y], [radius, radius], face, taken);
}

/**
 * A plate below something, or else above, right or left of it, where it covers no start, goal or other plate.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {string} words
 * @param {readonly [number, number]} middle pixels, of what is named
 * @param {readonly [number, number]} half its width and height, halved
 * @param {{face: string, ink: string}} face
 * @param {Box[]} taken what is covered already; the plate's own box comes to it
 */
function paintAside(context, view, words, [x, y], [across, up], face, taken) {
  const half = plateWidth(context, words) / 2;
  const spots = [[x, y + up + 15], [x, y - up - 15], [x + across + half + 8, y], [x - across - half - 8, y],
    [x, y + up + 37], [x, y - up - 37]];
  const boxes = spots.map(([left, top]) => /** @type {Box} */ ([left - half, top - 9, left + half, top + 9]));
  const within = (/** @type {Box} */ [x0, y0, x1, y1]) => x0 >= 0 && y0 >= 0 && x1 <= view.width && y1 <= view.height;
  const free = boxes.findIndex((box) => within(box) && !taken.some((other) => meet(box, other)));
  const chosen = Math.max(free, 0);
  paintPlate(context, view, words, spots[chosen][0], spots[chosen][1], face);
  taken.push(boxes[chosen]);
}

/**
 * Where starts and goals are, in pixels.
 * @param {View} view
 * @returns {Box[]}
 */
function endBoxes(view) {
  return view.state.scene.robots.flatMap((/** @type {any} */ robot) => [robot.start, robot.goal].map(([x, y]) => {
    const radius = discRadius(view, robot);
    return [view.x(x) - radius, view.y(y) - radius, view.x(x) + radius, view.y(y) + radius];
  }));
}

/** @param {Box} one @param {Box} other */
const meet = (one, other) => one[0] < other[2] && other[0] < one[2] && one[1] < other[3] && other[1] < one[3];

/**
 * The narrowest place: how much room there is, and how much is needed.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {Gap} gap
 * @param {string} name of the robot that does not fit
 * @param {Box[]} taken
 */
function paintGap(context, view, { place, ends, room, needed }, name, taken) {
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
  const there = room > 1e-6 * needed ? `there are ${lengthText(room)}` : "there is no room";
  const half = /** @type {[number, number]} */ ([Math.abs(b[0] - a[0]) / 2, Math.abs(b[1] - a[1]) / 2 + 5]);
  paintAside(context, view, `${name} needs ${lengthText(needed)}: ${there}`, [x, y], half, face, taken);
}
