// @ts-check
// Painting of timelines: a curve over time, and a row a robot with its moves and waits.

import { stretchesOf } from "studio/motion.js";

/** Pixels of a robot's row. */
export const ROW = 16;
const TOP = 16;
const BOTTOM = 6;
const FONT = "11px system-ui, sans-serif";

/**
 * Paint one curve with its name, its greatest value and, if it has one, the limit it must not fall below.
 * @param {CanvasRenderingContext2D} context
 * @param {import("studio/timelines.js").Axis} axis
 * @param {any} chart
 * @param {any} colours
 */
export function paintChart(context, axis, chart, colours) {
  const height = parseFloat(context.canvas.style.height);
  const top = chart.values.reduce((/** @type {number} */ a, /** @type {number} */ b) => Math.max(a, b ?? 0), chart.limit || 1e-12);
  const across = (/** @type {number} */ time) => axis.left + (time / axis.end) * axis.width;
  const up = (/** @type {number} */ value) => height - BOTTOM - (value / top) * (height - TOP - BOTTOM);
  context.font = FONT;
  context.textBaseline = "middle";
  context.strokeStyle = colours.line;
  rule(context, axis, up(0));
  context.fillStyle = colours.ink;
  context.textAlign = "left";
  context.fillText(chart.name, 10, height / 2);
  context.fillStyle = colours.quiet;
  context.textAlign = "right";
  context.fillText(top.toPrecision(3), axis.left - 6, up(top));
  context.fillText("0", axis.left - 6, up(0) - 3);
  context.textAlign = "left";
  context.fillText(chart.brief, axis.left + axis.width + 10, height / 2);

  context.beginPath();
  chart.times.forEach((/** @type {number} */ time, /** @type {number} */ k) => {
    if (chart.values[k] === null) return;
    const y = up(chart.values[k]);
    if (k === 0 || chart.values[k - 1] === null) context.moveTo(across(time), y);
    else {
      if (chart.steps) context.lineTo(across(time), up(chart.values[k - 1]));
      context.lineTo(across(time), y);
    }
  });
  context.strokeStyle = colours.accent;
  context.lineWidth = 1.5;
  context.stroke();
  if (chart.limit !== null) paintLimit(context, axis, up(chart.limit), colours);
  else if (chart.name === "λ2") paintZeros(context, chart, across, up(0), colours);
  if (chart.mark) {
    context.beginPath();
    context.arc(across(chart.mark.time), up(chart.mark.value), 3, 0, 2 * Math.PI);
    context.fillStyle = colours.accent;
    context.fill();
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {import("studio/timelines.js").Axis} axis
 * @param {number} y
 * @param {any} colours
 */
function paintLimit(context, axis, y, colours) {
  context.setLineDash([4, 3]);
  context.lineWidth = 1;
  context.strokeStyle = colours.bad;
  rule(context, axis, y);
  context.setLineDash([]);
}

/**
 * Stretches at exactly 0, where the team is apart, are thick and red.
 * @param {CanvasRenderingContext2D} context
 * @param {any} chart
 * @param {(time: number) => number} across
 * @param {number} y
 * @param {any} colours
 */
function paintZeros(context, chart, across, y, colours) {
  context.strokeStyle = colours.bad;
  context.lineWidth = 3;
  for (let k = 0; k + 1 < chart.times.length; k += 1) {
    if (chart.values[k] !== 0) continue;
    context.beginPath();
    context.moveTo(across(chart.times[k]), y);
    context.lineTo(across(chart.times[k + 1]), y);
    context.stroke();
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {import("studio/timelines.js").Axis} axis
 * @param {number} y
 */
function rule(context, { left, width }, y) {
  const level = Math.round(y) + 0.5;
  context.lineWidth = 1;
  context.beginPath();
  context.moveTo(left, level);
  context.lineTo(left + width, level);
  context.stroke();
}

/**
 * Paint a row a robot: full while it moves, thin and faint while it waits, nothing after its arrival.
 * @param {CanvasRenderingContext2D} context
 * @param {import("studio/timelines.js").Axis} axis
 * @param {import("studio/motion.js").Motion[]} motions
 * @param {Record<string, any>} state
 * @param {any} colours
 */
export function paintRows(context, axis, motions, state, colours) {
  const chosen = new Set((state.selection ?? []).map((/** @type {any} */ ref) => ref.name));
  if (state.hover) chosen.add(state.hover.name);
  context.font = FONT;
  context.textBaseline = "middle";
  const right = axis.left + axis.width;
  motions.forEach((motion, index) => {
    const y = index * ROW;
    if (chosen.has(motion.name)) {
      context.fillStyle = colours.outside;
      context.fillRect(0, y, parseFloat(context.canvas.style.width), ROW);
    }
    context.fillStyle = chosen.has(motion.name) ? colours.ink : colours.quiet;
    context.textAlign = "left";
    context.fillText(motion.name, 10, y + ROW / 2, axis.left - 16);
    context.fillText(`arrives at ${motion.arrival.toFixed(2)} s`, right + 10, y + ROW / 2);
    const colour = colours.robot(index);
    for (const { begin, end, moves } of stretchesOf(motion)) {
      const x = axis.left + (begin / axis.end) * axis.width;
      const width = Math.max(((end - begin) / axis.end) * axis.width, 0.5);
      context.globalAlpha = moves ? 1 : 0.25;
      context.fillStyle = colour;
      context.fillRect(x, y + (moves ? 4 : 6), width, moves ? ROW - 8 : ROW - 12);
      context.globalAlpha = 1;
    }
  });
}

/**
 * Name of the robot whose row is at y pixels, null if there is none.
 * @param {import("studio/motion.js").Motion[]} motions
 * @param {number} y
 */
export function nameAt(motions, y) {
  return motions[Math.floor(y / ROW)]?.name ?? null;
}
