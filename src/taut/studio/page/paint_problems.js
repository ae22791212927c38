// @ts-check
// What is wrong with the scene, at the places where it is: pins, and the sentence of the one that is pointed at.

import { toScreen } from "studio/camera.js";
import { paintBubble } from "studio/paint_words.js";

/**
 * @typedef {import("studio/camera.js").Window} Window
 * @typedef {{message: string, kind: string, names: string[], place: [number, number] | null}} Problem
 */

/** Pixels from a place up to the head of its pin, and the head's radius. */
const STEM = 19;
const HEAD = 9;

/**
 * Which problem's pin is at a pixel, or null.
 * @param {Window} window
 * @param {readonly Problem[]} problems
 * @param {readonly [number, number]} pixel
 */
export function problemAt(window, problems, pixel) {
  for (let k = problems.length - 1; k >= 0; k -= 1) {
    const { place } = problems[k];
    if (!place) continue;
    const [x, y] = toScreen(window, place);
    if (Math.hypot(pixel[0] - x, pixel[1] - (y - STEM)) <= HEAD + 3) return k;
  }
  return null;
}

/**
 * Layer: a pin for each problem with a place. A single one says its sentence by itself, of several the one that is
 * pointed at.
 * @type {import("studio/board.js").Layer}
 */
export function paintProblems(context, view) {
  const problems = /** @type {readonly Problem[]} */ (view.state.problems ?? []);
  const { probe = null, sketch } = view.state;
  for (const { place } of problems) if (place) paintPin(context, view, place);
  const said = problems[probe ?? (problems.length === 1 && !sketch ? 0 : -1)];
  if (said?.place) {
    const [x, y] = toScreen(view, said.place);
    paintBubble(context, view, said.message, x, y - STEM, view.colours.bad);
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {import("studio/board.js").View} view
 * @param {readonly [number, number]} place
 */
export function paintPin(context, view, place) {
  const [x, y] = toScreen(view, place);
  if (x < -20 || y < -20 || x > view.width + 20 || y > view.height + 40) return;
  const { colours } = view;
  const lean = Math.acos(HEAD / STEM);
  context.beginPath();
  context.moveTo(x, y);
  context.arc(x, y - STEM, HEAD, Math.PI / 2 + lean, Math.PI / 2 - lean);
  context.closePath();
  context.fillStyle = colours.bad;
  context.fill();
  context.lineWidth = 1.5;
  context.strokeStyle = colours.halo;
  context.stroke();
  context.fillStyle = colours.dark ? "#16181b" : "#ffffff";
  context.beginPath();
  context.roundRect(x - 1, y - STEM - 5, 2, 6, 1);
  context.roundRect(x - 1, y - STEM + 2.8, 2, 2.2, 1);
  context.fill();
}
