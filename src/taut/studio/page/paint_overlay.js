// @ts-check
// What lies above the map while it is edited: what is selected and pointed at, grips, problems, the running tool.

import { faded } from "studio/colours.js";
import { gripsOf } from "studio/hit.js";
import { discRadius, inSight, traceChain, traceCircle, traceObstacle, traceRing } from "studio/paint_outlines.js";
import { paintProblems } from "studio/paint_problems.js";
import { paintSketch } from "studio/paint_sketch.js";
import { paintWhyWords } from "studio/paint_why.js";
import { paintBubble } from "studio/paint_words.js";
import { boxOf, obstacleNamed, ownRadius, robotNamed, verticesOf, workspaceRing } from "studio/scene.js";

/**
 * @typedef {import("studio/board.js").View} View
 * @typedef {import("studio/scene.js").Ref} Ref
 */

/**
 * Layer: the topmost of the board.
 * @type {import("studio/board.js").Layer}
 */
export function paintOverlay(context, view) {
  const { scene, selection, hover, tool, sketch } = view.state;
  if (!scene) return;
  context.lineJoin = "round";
  context.lineCap = "round";
  if (hover) paintOutline(context, view, hover, faded(view.colours.accent, 0.65), 2);
  for (const ref of selection ?? []) paintOutline(context, view, ref, view.colours.accent, 2);
  paintPairs(context, view);
  if (tool === "select" && !sketch) paintGrips(context, view);
  paintWhyWords(context, view);
  paintEncounter(context, view);
  paintProblems(context, view);
  paintSketch(context, view);
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {Ref} ref
 * @param {string} colour
 * @param {number} width
 */
function paintOutline(context, view, ref, colour, width) {
  const { scene } = view.state;
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.beginPath();
  if (ref.kind === "workspace") traceRing(context, view, workspaceRing(scene));
  else if (ref.kind === "obstacle") {
    const obstacle = obstacleNamed(scene, ref.name);
    if (!obstacle || !inSight(view, boxOf(obstacle), width)) return;
    if (obstacle.line) {
      outlineWall(context, view, obstacle, colour);
      return;
    }
    traceObstacle(context, view, obstacle);
  } else {
    const robot = robotNamed(scene, ref.name);
    if (!robot) return;
    for (const [x, y] of verticesOf(scene, ref)) {
      const radius = discRadius(view, robot) + 3.5;
      context.moveTo(view.x(x) + radius, view.y(y));
      if (radius > 4000) traceCircle(context, view, [x, y], radius / view.camera.scale);
      else context.arc(view.x(x), view.y(y), radius, 0, 2 * Math.PI);
    }
  }
  context.stroke();
}

/**
 * The sentence of the conflict that is pointed at.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 */
function paintEncounter(context, view) {
  const { encounter, sketch, answer } = view.state;
  if (sketch || !answer?.conflicts.includes(encounter)) return; // it may be one of an older plan
  const [x, y] = encounter.place;
  paintBubble(context, view, encounter.sentence, view.x(x), view.y(y), view.colours.bad);
}

/**
 * A wall's outline is a band round its stroke: a broad translucent one does as well and follows round joints.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {import("studio/scene.js").Obstacle} wall
 * @param {string} colour
 */
function outlineWall(context, view, wall, colour) {
  traceObstacle(context, view, wall);
  context.save();
  context.globalAlpha = 0.45;
  context.strokeStyle = colour;
  context.lineWidth = 2 * ownRadius(wall) * view.camera.scale + 4;
  context.stroke();
  context.restore();
  context.beginPath();
  traceChain(context, view, wall.line ?? []);
  context.lineWidth = 1;
  context.stroke();
}

/**
 * While no route is shown, a straight dashed line tells which goal belongs to which start.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 */
function paintPairs(context, view) {
  const { scene, selection, hover, answer, planning } = view.state;
  if (answer && planning?.state !== "failed") return;
  const names = new Set([...(selection ?? []), hover].filter((ref) => ref && ref.kind !== "obstacle")
    .map((ref) => ref.name));
  context.setLineDash([3, 5]);
  context.lineWidth = 1.5;
  scene.robots.forEach((/** @type {any} */ { name, start, goal }, /** @type {number} */ k) => {
    if (!names.has(name)) return;
    context.beginPath();
    traceChain(context, view, [start, goal]);
    context.strokeStyle = view.colours.robot(k);
    context.stroke();
  });
  context.setLineDash([]);
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 */
function paintGrips(context, view) {
  const { scene, selection } = view.state;
  const { colours } = view;
  const chosen = new Set((selection ?? []).map((/** @type {Ref} */ { vertex }) => vertex));
  const grips = gripsOf(view, scene, selection ?? []);
  context.lineWidth = 1.5;
  context.strokeStyle = colours.accent;
  for (const { kind, index, pixel: [x, y] } of grips) {
    if (x < -10 || y < -10 || x > view.width + 10 || y > view.height + 10) continue;
    context.beginPath();
    if (kind === "vertex") context.arc(x, y, chosen.has(index) ? 5.5 : 4.5, 0, 2 * Math.PI);
    else if (kind === "size") context.roundRect(x - 4, y - 4, 8, 8, 1.5);
    else context.arc(x, y, 5.5, 0, 2 * Math.PI);
    context.fillStyle = kind === "vertex" && chosen.has(index) ? colours.accent : colours.halo;
    context.fill();
    context.stroke();
    if (kind === "turn") paintTurn(context, x, y);
  }
}

/**
 * A bow round the grip that turns, so that it is told from the others.
 * @param {CanvasRenderingContext2D} context
 * @param {number} x
 * @param {number} y
 */
function paintTurn(context, x, y) {
  context.beginPath();
  context.arc(x, y, 10, -Math.PI * 0.85, -Math.PI * 0.15);
  context.stroke();
  context.beginPath();
  const [tipX, tipY] = [x + 10 * Math.cos(-Math.PI * 0.15), y + 10 * Math.sin(-Math.PI * 0.15)];
  context.moveTo(tipX - 4.5, tipY - 1.5);
  context.lineTo(tipX, tipY);
  context.lineTo(tipX + 1.5, tipY - 4.5);
  context.stroke();
}
