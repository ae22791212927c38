// @ts-check
// What the pointer is on: the grips of the selection first, then the things of the scene. Grips are listed here once,
// for the pointer and for the painter.

import { toScreen, toWorld } from "studio/camera.js";
import { handlesOf } from "studio/edits_outline.js";
import { boxOfRefs, obstacleNamed, shapeOf, verticesOf } from "studio/scene.js";
import { hitsAt } from "studio/scene_hits.js";

/**
 * @typedef {import("studio/camera.js").Window} Window
 * @typedef {import("studio/scene.js").Scene} Scene
 * @typedef {import("studio/scene.js").Ref} Ref
 * @typedef {{kind: "vertex" | "size" | "turn", ref: Ref, index: number, pixel: [number, number]}} Grip
 */

/** Pixels from the pointer within which a thing or grip is meant. */
export const REACH = Object.freeze({ mouse: 7, pen: 9, touch: 18 });
/** Pixels from the selection to the grip that turns it. */
const TURN_ARM = 26;
/** Smaller than this many pixels a thing has no grips on its sides: they would cover it. */
const LEAST_SIDE = 28;

/**
 * Grips of the selection: corners of one polygon, wall or workspace, sizes of one rectangle, circle or workspace, and
 * one to turn what can be turned.
 * @param {Window} window
 * @param {Scene} scene
 * @param {readonly Ref[]} selection
 * @returns {Grip[]}
 */
export function gripsOf(window, scene, selection) {
  if (selection.length === 0 || selection.some(({ kind }) => kind === "scene")) return [];
  const things = wholeThings(selection);
  const own = things.length === 1 ? gripsOfOne(window, scene, things[0]) : [];
  const turn = canTurn(scene, things) ? turnGrip(window, scene, things) : null;
  return turn ? [...own, turn] : own;
}

/**
 * The grip at a pixel, or null; corners before sides before the one that turns.
 * @param {Window} window
 * @param {Scene} scene
 * @param {readonly Ref[]} selection
 * @param {readonly [number, number]} pixel
 * @param {number} reach pixels
 * @returns {Grip | null}
 */
export function gripAt(window, scene, selection, pixel, reach) {
  let [found, least] = [/** @type {Grip | null} */ (null), reach];
  for (const grip of gripsOf(window, scene, selection)) {
    const distance = Math.hypot(grip.pixel[0] - pixel[0], grip.pixel[1] - pixel[1]);
    if (distance < least || (distance === least && !found)) [found, least] = [grip, distance];
  }
  return found;
}

/**
 * The thing at a pixel, or null. What is selected is preferred among things that lie over each other, so that it can
 * be dragged from under others.
 * @param {Window} window
 * @param {Scene} scene
 * @param {readonly Ref[]} selection
 * @param {readonly [number, number]} pixel
 * @param {number} reach pixels
 * @returns {Ref | null}
 */
export function hitAt(window, scene, selection, pixel, reach) {
  const hits = hitsAt(scene, toWorld(window, pixel), reach / window.camera.scale);
  return hits.find((hit) => covers(selection, hit)) ?? hits[0] ?? null;
}

/**
 * Whether a thing is in a selection, itself or as an end of a robot that is.
 * @param {readonly Ref[]} selection
 * @param {Ref} ref
 */
export function covers(selection, ref) {
  return selection.some(({ kind, name }) => name === ref.name
    && (kind === ref.kind || (kind === "robot" && (ref.kind === "start" || ref.kind === "goal"))));
}

/**
 * The things that a selection is about: corners count as what they belong to.
 * @param {readonly Ref[]} selection
 * @returns {Ref[]}
 */
export function wholeThings(selection) {
  /** @type {Ref[]} */
  const things = [];
  for (const { kind, name } of selection) {
    if (!things.some((thing) => thing.kind === kind && thing.name === name)) things.push({ kind, name });
  }
  return things;
}

/**
 * @param {Window} window
 * @param {Scene} scene
 * @param {Ref} ref
 * @returns {Grip[]}
 */
function gripsOfOne(window, scene, ref) {
  const handles = handlesOf(scene, ref);
  if (handles.length > 0) {
    const box = boxOfRefs(scene, [ref]) ?? [0, 0, 0, 0];
    const small = Math.min(box[2] - box[0], box[3] - box[1]) * window.camera.scale < LEAST_SIDE;
    return handles.flatMap((place, index) => (small && index >= 4 ? [] : [{
      kind: /** @type {const} */ ("size"), ref, index, pixel: toScreen(window, [place[0], place[1]]),
    }]));
  }
  if (ref.kind !== "obstacle" && ref.kind !== "workspace") return [];
  return verticesOf(scene, ref).map((place, index) => ({
    kind: /** @type {const} */ ("vertex"), ref: { ...ref, vertex: index }, index,
    pixel: toScreen(window, [place[0], place[1]]),
  }));
}

/**
 * @param {Scene} scene
 * @param {readonly Ref[]} things
 */
function canTurn(scene, things) {
  if (things.some(({ kind }) => kind === "workspace")) return false;
  if (things.length > 1) return true;
  const obstacle = things[0].kind === "obstacle" ? obstacleNamed(scene, things[0].name) : undefined;
  return obstacle ? shapeOf(obstacle) !== "circle" : things[0].kind === "robot";
}

/**
 * Above the middle of the selection, or below where there is no room above.
 * @param {Window} window
 * @param {Scene} scene
 * @param {readonly Ref[]} things
 * @returns {Grip | null}
 */
function turnGrip(window, scene, things) {
  const box = boxOfRefs(scene, things);
  if (!box) return null;
  const middle = (box[0] + box[2]) / 2;
  const [x, top] = toScreen(window, [middle, box[3]]);
  const low = toScreen(window, [middle, box[1]])[1];
  const y = top - TURN_ARM < 8 && low + TURN_ARM < window.height - 8 ? low + TURN_ARM : top - TURN_ARM;
  return { kind: "turn", ref: things[0], index: 0, pixel: [x, y] };
}
