// @ts-check
// Words on the board that lie above everything: small plates with a number, and bubbles with a sentence.

/** @typedef {import("studio/board.js").View} View */

const FONT = "500 11px system-ui, sans-serif";
const SENTENCE = "12px system-ui, sans-serif";
const LINE = 16;
/** Pixels that a bubble's text spans at most. */
const WIDEST = 250;
/** Pixels between a plate or bubble and the border of the board. */
const BORDER = 6;

/**
 * How wide the plate of a text is, pixels.
 * @param {CanvasRenderingContext2D} context
 * @param {string} text
 */
export function plateWidth(context, text) {
  context.font = FONT;
  return context.measureText(text).width + 12;
}

/**
 * A plate with a short text, its middle at a pixel (moved in where the board ends).
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {string} text
 * @param {number} x
 * @param {number} y
 * @param {{face?: string, ink?: string}} [look]
 */
export function paintPlate(context, view, text, x, y, look = {}) {
  const width = plateWidth(context, text);
  const left = within(x - width / 2, width, view.width);
  const top = within(y - 9, 18, view.height);
  context.beginPath();
  context.roundRect(left, top, width, 18, 5);
  context.fillStyle = look.face ?? view.colours.ink;
  context.fill();
  context.fillStyle = look.ink ?? view.colours.workspace;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText(text, left + width / 2, top + 9.5);
}

/**
 * A bubble with a sentence beside a pixel: right of it, or left where the board ends.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {string} text
 * @param {number} x
 * @param {number} y
 * @param {string} edge colour of its border
 */
export function paintBubble(context, view, text, x, y, edge) {
  context.font = SENTENCE;
  const lines = wrapped(text, (part) => context.measureText(part).width, WIDEST);
  const width = Math.max(...lines.map((line) => context.measureText(line).width)) + 20;
  const height = lines.length * LINE + 12;
  const room = x + 16 + width + BORDER <= view.width;
  const left = within(room ? x + 16 : x - 16 - width, width, view.width);
  const top = within(y - height / 2, height, view.height);
  context.beginPath();
  context.roundRect(left, top, width, height, 7);
  context.fillStyle = view.colours.workspace;
  context.fill();
  context.lineWidth = 1.5;
  context.strokeStyle = edge;
  context.stroke();
  context.fillStyle = view.colours.ink;
  context.textAlign = "left";
  context.textBaseline = "middle";
  lines.forEach((line, k) => context.fillText(line, left + 10, top + 6 + LINE * (k + 0.5)));
}

/**
 * A text in lines that are not wider than asked, where its words allow.
 * @param {string} text
 * @param {(part: string) => number} widthOf
 * @param {number} widest
 */
export function wrapped(text, widthOf, widest) {
  /** @type {string[]} */
  const lines = [];
  for (const word of text.split(/\s+/)) {
    const longer = lines.length > 0 ? `${lines[lines.length - 1]} ${word}` : word;
    if (lines.length > 0 && widthOf(longer) <= widest) lines[lines.length - 1] = longer;
    else lines.push(word);
  }
  return lines;
}

/**
 * @param {number} begin
 * @param {number} size
 * @param {number} room
 */
function within(begin, size, room) {
  return Math.max(BORDER, Math.min(begin, room - size - BORDER));
}
