// @ts-check
// The numbers that are shown while something is drawn or dragged: lengths, angles, sizes, at their places.

import { lengthText, lengthsText } from "studio/grid.js";
import { boxOfRefs, isRing, obstacleNamed, verticesOf } from "studio/scene.js";

/**
 * @typedef {readonly [number, number] | readonly number[]} Point
 * @typedef {{at: Point, text: string, from?: Point}} Label `from`: the other end of the line that it measures
 */

/**
 * Length, and the angle against east.
 * @param {Point} a
 * @param {Point} b
 * @returns {Label}
 */
export function lineLabel(a, b) {
  const angle = Math.atan2(b[1] - a[1], b[0] - a[0]);
  return { at: middle(a, b), from: a, text: `${lengthText(distance(a, b))} · ${angleText(angle)}` };
}

/**
 * Width and height beneath a box.
 * @param {Point} a
 * @param {Point} b
 * @returns {Label}
 */
export function boxLabel(a, b) {
  const [width, height] = [Math.abs(b[0] - a[0]), Math.abs(b[1] - a[1])];
  return { at: [(a[0] + b[0]) / 2, Math.min(a[1], b[1])], text: lengthsText([width, height], " × ") };
}

/**
 * @param {Point} centre
 * @param {number} radius
 * @returns {Label}
 */
export function radiusLabel(centre, radius) {
  return { at: [centre[0], centre[1] - radius], text: `radius ${lengthText(radius)}` };
}

/**
 * How far things have moved, beneath them.
 * @param {any} scene
 * @param {readonly any[]} refs
 * @param {number} dx
 * @param {number} dy
 * @returns {Label}
 */
export function moveLabel(scene, refs, dx, dy) {
  const box = boxOfRefs(scene, refs) ?? [0, 0, 0, 0];
  return { at: [(box[0] + box[2]) / 2, box[1]], text: lengthsText([dx, dy], ", ", signed) };
}

/**
 * @param {Point} centre
 * @param {number} angle
 * @returns {Label}
 */
export function turnLabel(centre, angle) {
  return { at: centre, text: `${angle > 0 ? "+" : ""}${angleText(angle)}` };
}

/**
 * The size of a rectangle, circle or workspace, beneath it.
 * @param {any} scene
 * @param {any} ref
 * @returns {Label[]}
 */
export function sizeLabel(scene, ref) {
  const obstacle = ref.kind === "obstacle" ? obstacleNamed(scene, ref.name) : undefined;
  if (obstacle?.circle) return [radiusLabel(obstacle.circle, obstacle.radius ?? 0)];
  const [xmin, ymin, xmax, ymax] = boxOfRefs(scene, [ref]) ?? [0, 0, 0, 0];
  if (!obstacle?.rectangle) return [boxLabel([xmin, ymin], [xmax, ymax])];
  const [, , width, height] = obstacle.rectangle;
  return [{ at: [(xmin + xmax) / 2, ymin], text: lengthsText([width, height], " × ") }];
}

/**
 * Lengths of the sides at a corner: the one that comes to it first.
 * @param {any} scene
 * @param {any} ref
 * @returns {Label[]}
 */
export function cornerLabels(scene, ref) {
  const points = verticesOf(scene, { kind: ref.kind, name: ref.name });
  const ring = isRing(scene, ref);
  const corner = points[ref.vertex];
  return [ref.vertex - 1, ref.vertex + 1].flatMap((k) => {
    const other = ring ? points[(k + points.length) % points.length] : points[k];
    return other ? [{ at: middle(other, corner), from: other, text: lengthText(distance(other, corner)) }] : [];
  });
}

/**
 * An angle in degrees with at most one digit after the point.
 * @param {number} radians
 */
function angleText(radians) {
  const degrees = Math.round((radians * 1800) / Math.PI) / 10;
  return `${String(degrees === 0 ? 0 : degrees).replace("-", "−")}°`;
}

/**
 * @param {Point} a
 * @param {Point} b
 */
export function distance(a, b) {
  return Math.hypot(b[0] - a[0], b[1] - a[1]);
}

/**
 * @param {Point} a
 * @param {Point} b
 * @returns {[number, number]}
 */
function middle(a, b) {
  return [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
}

/**
 * @param {string} text
 * @param {number} length
 */
function signed(text, length) {
  return length > 0 ? `+${text}` : text;
}
