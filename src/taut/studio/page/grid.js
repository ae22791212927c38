// @ts-check
// The ground of the board: workspace, a grid of round metres that follows the zoom, its numbers, and the scale bar.

import { shownBox } from "studio/camera.js";
import { traceRing } from "studio/paint_outlines.js";
import { workspaceRing } from "studio/scene.js";

const FONT = "11px system-ui, sans-serif";
/** Pixels that a labelled step of the grid spans at least. */
const ROOM = 64;
/** Pixels that the scale bar spans at most. */
const LONGEST_BAR = 140;
/** Narrower than this many pixels fine lines are not drawn; from twice as many on they are whole. */
const FINE = 9;

/** Units, largest first: [metres, name, least step that is written in it]. */
const UNITS = /** @type {[number, string, number][]} */ ([
  [1000, "km", 100], [1, "m", 1e-3], [1e-3, "mm", 1e-6], [1e-6, "µm", 0],
]);

/**
 * The largest of 1, 2, 5 · 10ⁿ that is at most a number.
 * @param {number} most
 */
export function roundStep(most) {
  const exponent = Math.floor(Math.log10(most));
  for (const lead of [5, 2, 1]) {
    const step = power(lead, exponent);
    if (step <= most * (1 + 1e-12)) return step;
  }
  return power(1, exponent);
}

/**
 * Steps of the grid at a scale: metres between labelled lines and between fine ones.
 * @param {number} scale pixels a metre
 */
export function gridSteps(scale) {
  const least = ROOM / scale;
  let strong = roundStep(least);
  if (strong < least) strong = roundStep(strong * 2.5);
  const lead = Math.round(strong / 10 ** Math.floor(Math.log10(strong) + 1e-9));
  return { strong, fine: strong / (lead === 2 ? 4 : 5) };
}

/**
 * A length as text with a unit that suits it and about three digits: "2.4 m", "35 mm", "1.2 km".
 * @param {number} metres
 */
export function lengthText(metres) {
  return lengthsText([metres], "");
}

/**
 * Lengths in one unit, that of the largest: "2.40 × 0.35 m".
 * @param {readonly number[]} lengths metres
 * @param {string} between
 * @param {(text: string, length: number) => string} [each]
 */
export function lengthsText(lengths, between, each = (text) => text) {
  const largest = Math.max(...lengths.map(Math.abs));
  const [size, unit] = largest >= 1000 ? [1000, "km"] : largest >= 0.995 || !(largest > 0) ? [1, "m"]
    : largest >= 0.01 ? [0.01, "cm"] : largest >= 1e-3 ? [1e-3, "mm"] : [1e-6, "µm"];
  const value = largest / size;
  const digits = value === 0 || value >= 99.95 ? 0 : value >= 9.995 ? 1 : 2;
  return `${lengths.map((length) => each(plain(length / size, digits), length)).join(between)} ${unit}`;
}

/** @type {import("studio/board.js").Layer} */
export function paintGround(context, view) {
  const { state, colours } = view;
  if (!state.scene) return;
  context.beginPath();
  traceRing(context, view, workspaceRing(state.scene));
  context.fillStyle = colours.workspace;
  context.fill();
}

/** @type {import("studio/board.js").Layer} */
export function paintGrid(context, view) {
  const { camera, colours, state, ratio } = view;
  if (state.show?.grid === false) return;
  const { strong, fine } = gridSteps(camera.scale);
  const unseen = Math.min(Math.max((fine * camera.scale) / FINE - 1, 0), 1);
  context.lineWidth = Math.max(1, Math.floor(ratio)) / ratio;
  if (unseen > 0) {
    context.globalAlpha = unseen;
    paintLines(context, view, fine, colours.grid);
    context.globalAlpha = 1;
  }
  paintLines(context, view, strong, colours.gridStrong);
}

/**
 * Numbers of the grid along the lower and left edge, and the scale bar.
 * @type {import("studio/board.js").Layer}
 */
export function paintScale(context, view) {
  const { camera, width, height, colours, state } = view;
  context.font = FONT;
  context.lineJoin = "round";
  context.strokeStyle = colours.halo;
  if (state.show?.grid !== false) paintNumbers(context, view);
  const length = roundStep(LONGEST_BAR / camera.scale);
  const span = length * camera.scale;
  const [right, low] = [crisp(view, width - 16), crisp(view, height - 30)];
  const left = crisp(view, right - span);
  context.beginPath();
  context.moveTo(left, low - 5);
  context.lineTo(left, low);
  context.lineTo(right, low);
  context.lineTo(right, low - 5);
  context.lineWidth = 4;
  context.stroke();
  context.lineWidth = 1.5;
  context.strokeStyle = colours.ink;
  context.stroke();
  context.strokeStyle = colours.halo;
  context.textAlign = "center";
  context.textBaseline = "alphabetic";
  written(context, scaleText(length), (left + right) / 2, low - 7, colours.ink);
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {import("studio/board.js").View} view
 * @param {number} step
 * @param {string} colour
 */
function paintLines(context, view, step, colour) {
  const [xmin, ymin, xmax, ymax] = shownBox(view);
  context.beginPath();
  for (let k = Math.ceil(xmin / step); k * step <= xmax; k += 1) {
    const x = crisp(view, view.x(k * step));
    context.moveTo(x, 0);
    context.lineTo(x, view.height);
  }
  for (let k = Math.ceil(ymin / step); k * step <= ymax; k += 1) {
    const y = crisp(view, view.y(k * step));
    context.moveTo(0, y);
    context.lineTo(view.width, y);
  }
  context.strokeStyle = colour;
  context.stroke();
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {import("studio/board.js").View} view
 */
function paintNumbers(context, view) {
  const { width, height, colours } = view;
  const { strong } = gridSteps(view.camera.scale);
  const [xmin, ymin, xmax, ymax] = shownBox(view);
  const [metres, unit] = UNITS.find(([, , least]) => strong >= least) ?? UNITS[UNITS.length - 1];
  const digits = Math.max(0, Math.ceil(-Math.log10(strong / metres) - 1e-9));
  context.lineWidth = 3;
  context.textAlign = "center";
  context.textBaseline = "alphabetic";
  for (let k = Math.ceil(xmin / strong); k * strong <= xmax; k += 1) {
    const x = view.x(k * strong);
    if (x < 44 || x > width - 20) continue;
    written(context, plain((k * strong) / metres, digits), x, height - 7, colours.quiet);
  }
  context.textAlign = "left";
  context.textBaseline = "middle";
  for (let k = Math.ceil(ymin / strong); k * strong <= ymax; k += 1) {
    const y = view.y(k * strong);
    if (y < 12 || y > height - 26) continue;
    written(context, plain((k * strong) / metres, digits), 7, y, colours.quiet);
  }
  context.textBaseline = "alphabetic";
  written(context, unit, 7, height - 7, colours.quiet);
}

/**
 * Text with a halo of the paper, readable on everything.
 * @param {CanvasRenderingContext2D} context
 * @param {string} text
 * @param {number} x
 * @param {number} y
 * @param {string} colour
 */
function written(context, text, x, y, colour) {
  context.strokeText(text, x, y);
  context.fillStyle = colour;
  context.fillText(text, x, y);
}

/**
 * The middle of the device pixel (or the border, for lines of an even number of them) at a place.
 * @param {{ratio: number}} view
 * @param {number} pixel CSS pixels
 */
function crisp({ ratio }, pixel) {
  const odd = Math.max(1, Math.floor(ratio)) % 2;
  return (Math.floor(pixel * ratio) + odd / 2) / ratio;
}

/**
 * A round length with its unit: "200 µm", "5 mm", "20 cm", "1 m", "2 km".
 * @param {number} metres
 */
function scaleText(metres) {
  const [size, unit] = metres >= 1000 ? [1000, "km"] : metres >= 1 ? [1, "m"] : metres >= 0.01 ? [0.01, "cm"]
    : metres >= 1e-3 ? [1e-3, "mm"] : [1e-6, "µm"];
  return `${Number((metres / size).toPrecision(3))} ${unit}`;
}

/**
 * @param {number} value
 * @param {number} digits
 */
function plain(value, digits) {
  const text = value.toFixed(Math.min(digits, 12));
  return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "−");
}

/**
 * Lead · 10ⁿ as the nearest double (10 ** -3 is not exact where 1e-3 is).
 * @param {number} lead
 * @param {number} exponent
 */
function power(lead, exponent) {
  return Number(`${lead}e${exponent}`);
}
