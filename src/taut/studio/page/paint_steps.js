// @ts-check
// A step of a method on the board: graphs, areas, paths and places, each drawn by its role.

import { faded, mix } from "studio/colours.js";
import { outlineOf, shapeOf } from "studio/scene.js";

/**
 * How each role looks: colour by its name in the palette, width and dashes of lines, radius of dots, pixels.
 * @type {Record<string, {colour: string, width?: number, dash?: number[], dot?: number, opacity?: number}>}
 */
const ROLES = {
  graph: { colour: "graph", width: 1, dot: 2.5 },
  faint: { colour: "graph", width: 0.75, dot: 1.5, opacity: 0.45 },
  removed: { colour: "bad", width: 1, dash: [3, 4], opacity: 0.55 },
  bridge: { colour: "accent", width: 3.5, dot: 5 },
  "runner-up": { colour: "warn", width: 2, dash: [6, 4], dot: 4 },
  path: { colour: "accent", width: 3, dot: 4 },
  baseline: { colour: "quiet", width: 1.5, dash: [6, 5] },
  hit: { colour: "bad", width: 2, dot: 4 },
  used: { colour: "accent", width: 2, opacity: 0.9 },
  waypoint: { colour: "good", width: 1.5, dot: 4.5 },
  dropped: { colour: "bad", width: 1.5, dot: 4.5, opacity: 0.7 },
  open: { colour: "warn", width: 1.5, dot: 4 },
  closed: { colour: "quiet", width: 1.5, dot: 3.5 },
  current: { colour: "bad", width: 3, dot: 6 },
  tree: { colour: "obstacleEdge", width: 1.75, dot: 3 },
  grown: { colour: "obstacleEdge", width: 0.75 },
  free: { colour: "good", width: 1 },
  "side-a": { colour: "sideA", width: 1.25, dot: 4 },
  "side-b": { colour: "sideB", width: 1.25, dot: 4 },
  fiedler: { colour: "graph", width: 1, dot: 5 },
};

/** Colours of the two sides of a cut, in light and in dark: ochre and blue, told apart by everybody. */
const SIDES = {
  light: { sideA: "#b8720a", sideB: "#2f5e9e", middle: "#d5d9de" },
  dark: { sideA: "#e2a33c", sideB: "#7fabdf", middle: "#5f6975" },
};

/**
 * Layer of the board, in the mode "steps".
 * @param {CanvasRenderingContext2D} context
 * @param {import("studio/board.js").View} view
 */
export function paintSteps(context, view) {
  const { mode, steps } = view.state;
  if (mode !== "steps" || !steps?.list) return;
  context.lineJoin = "round";
  context.lineCap = "round";
  for (const mark of shownMarks(steps)) paintMark(context, view, mark);
}

/** Marks from the lowest to the highest; of one kind those of later steps lie above. */
const ORDER = ["area", "obstacles", "edges", "path", "vertices", "note"];

/** @type {WeakMap<any[], {index: number, marks: any[]}>} the marks last shown of a list of steps */
const shown = new WeakMap();

/**
 * What is drawn at a step: what lies under all steps, what stays of the steps since the last `fresh` one, and its own.
 * @param {{base: any[], points: number[][][], list: any[], index: number}} steps
 * @returns {any[]}
 */
function shownMarks({ base, points, list, index }) {
  const known = shown.get(list);
  if (known?.index === index) return known.marks;
  let first = index;
  while (first > 0 && !list[first].fresh) first -= 1;
  const stayed = list.slice(first, index + 1).flatMap((step) => step.stays ?? []);
  const marks = [...base, ...stayed, ...list[index].marks]
    .map((mark) => placed(mark, points))
    .sort((a, b) => ORDER.indexOf(a.kind) - ORDER.indexOf(b.kind));
  shown.set(list, { index, marks });
  return marks;
}

/**
 * A mark with its own points: it may name a list that several share, and pick some of it.
 * @param {any} mark
 * @param {number[][][]} lists
 */
function placed(mark, lists) {
  const all = typeof mark.points === "number" ? lists[mark.points] : mark.points;
  return { ...mark, points: Array.isArray(mark.at) && mark.kind !== "note" ? mark.at.map((/** @type {number} */ k) => all[k]) : all };
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {import("studio/board.js").View} view
 * @param {any} mark
 */
function paintMark(context, view, mark) {
  const look = ROLES[mark.role] ?? ROLES.graph;
  const colour = /** @type {any} */ ({ ...view.colours, ...SIDES[view.colours.dark ? "dark" : "light"] })[look.colour];
  context.globalAlpha = look.opacity ?? 1;
  context.strokeStyle = colour;
  context.fillStyle = colour;
  context.lineWidth = look.width ?? 1;
  context.setLineDash(look.dash ?? []);
  switch (mark.kind) {
    case "edges": paintEdges(context, view, mark); break;
    case "vertices": paintVertices(context, view, mark, look.dot ?? 3); break;
    case "path": paintPath(context, view, mark); break;
    case "area": paintArea(context, view, mark, colour); break;
    case "obstacles": paintObstacles(context, view, mark, colour); break;
    case "note": paintNote(context, view, mark); break;
  }
  context.setLineDash([]);
  context.globalAlpha = 1;
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {import("studio/board.js").View} view
 * @param {any} mark
 */
function paintEdges(context, view, { points, pairs, robot, labels }) {
  ownColour(context, view, robot);
  context.beginPath();
  for (const [a, b] of pairs) {
    context.moveTo(view.x(points[a][0]), view.y(points[a][1]));
    context.lineTo(view.x(points[b][0]), view.y(points[b][1]));
  }
  context.stroke();
  if (!labels) return;
  pairs.forEach((/** @type {number[]} */ [a, b], /** @type {number} */ k) => words(context, view, labels[k],
    view.x((points[a][0] + points[b][0]) / 2) + 4, view.y((points[a][1] + points[b][1]) / 2) - 6));
}

/**
 * What belongs to a robot is drawn in its colour.
 * @param {CanvasRenderingContext2D} context
 * @param {import("studio/board.js").View} view
 * @param {string | undefined} robot
 */
function ownColour(context, view, robot) {
  const index = view.state.scene.robots.findIndex((/** @type {any} */ one) => one.name === robot);
  if (index >= 0) context.strokeStyle = view.colours.robot(index);
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {import("studio/board.js").View} view
 * @param {readonly (readonly number[])[]} points
 */
function line(context, view, points) {
  context.beginPath();
  points.forEach(([x, y], k) => (k ? context.lineTo(view.x(x), view.y(y)) : context.moveTo(view.x(x), view.y(y))));
  context.stroke();
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {import("studio/board.js").View} view
 * @param {any} mark
 * @param {number} radius
 */
function paintVertices(context, view, { points, values, labels }, radius) {
  points.forEach((/** @type {number[]} */ [x, y], /** @type {number} */ k) => {
    if (values) context.fillStyle = diverging(view.colours, values[k]);
    context.beginPath();
    context.arc(view.x(x), view.y(y), radius, 0, 2 * Math.PI);
    context.fill();
    context.lineWidth = 1;
    context.strokeStyle = view.colours.workspace;
    context.stroke();
  });
  if (!labels) return;
  points.forEach((/** @type {number[]} */ [x, y], /** @type {number} */ k) =>
    words(context, view, labels[k], view.x(x) + radius + 3, view.y(y) + radius + 7)); // names stand above
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {import("studio/board.js").View} view
 * @param {any} mark
 */
function paintPath(context, view, { points, robot }) {
  ownColour(context, view, robot);
  line(context, view, points);
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {import("studio/board.js").View} view
 * @param {any} mark
 * @param {string} colour
 */
function paintArea(context, view, { rings }, colour) {
  context.beginPath();
  for (const ring of rings) {
    ring.forEach((/** @type {number[]} */ [x, y], /** @type {number} */ k) =>
      (k ? context.lineTo(view.x(x), view.y(y)) : context.moveTo(view.x(x), view.y(y))));
    context.closePath();
  }
  context.fillStyle = faded(colour, 0.14);
  context.fill("evenodd");
  context.stroke();
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {import("studio/board.js").View} view
 * @param {any} mark
 * @param {string} colour
 */
function paintObstacles(context, view, { names }, colour) {
  const chosen = new Set(names);
  context.lineWidth = 2.5;
  context.strokeStyle = colour;
  for (const obstacle of view.state.scene.obstacles) {
    if (!chosen.has(obstacle.name)) continue;
    const outline = outlineOf(obstacle);
    if (shapeOf(obstacle) === "circle") {
      context.beginPath();
      context.arc(view.x(outline[0][0]), view.y(outline[0][1]), obstacle.radius * view.camera.scale, 0, 2 * Math.PI);
      context.stroke();
    } else line(context, view, shapeOf(obstacle) === "line" ? outline : [...outline, outline[0]]);
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {import("studio/board.js").View} view
 * @param {any} mark
 */
function paintNote(context, view, { at: [x, y], text }) {
  words(context, view, text, view.x(x) + 8, view.y(y) - 8);
}

/**
 * Small text that can be read on anything.
 * @param {CanvasRenderingContext2D} context
 * @param {import("studio/board.js").View} view
 * @param {string} text
 * @param {number} px
 * @param {number} py
 */
function words(context, { colours }, text, px, py) {
  context.font = "11px system-ui, sans-serif";
  context.textBaseline = "middle";
  context.textAlign = "left";
  context.setLineDash([]);
  context.lineWidth = 5;
  context.strokeStyle = colours.halo;
  context.strokeText(text, px, py);
  context.fillStyle = colours.ink;
  context.fillText(text, px, py);
}

/**
 * Colour of a value from −1 (one side) over 0 to 1 (the other).
 * @param {import("studio/colours.js").Colours} colours
 * @param {number} value
 */
function diverging(colours, value) {
  const { sideA, sideB, middle } = SIDES[colours.dark ? "dark" : "light"];
  return mix(middle, value < 0 ? sideA : sideB, 0.25 + 0.75 * Math.min(Math.abs(value), 1));
}
