// @ts-check
// The map and the team: wall of the workspace, obstacles, where robots start and where they go.

import { faded } from "studio/colours.js";
import { nameObstacles, nameRobots } from "studio/paint_names.js";
import {
  LEAST_DISC, discRadius, inSight, paintObstacle, traceCircle, traceRing,
} from "studio/paint_outlines.js";
import { workspaceRing } from "studio/scene.js";

/** @typedef {import("studio/board.js").View} View */

/** Rings of clearance nearer than this to the disc would only blur it. */
const LEAST_RING = 2;

/**
 * Layer: wall and obstacles, with names where they fit.
 * @type {import("studio/board.js").Layer}
 */
export function paintScene(context, view) {
  const { state: { scene, show }, colours } = view;
  if (!scene) return;
  context.lineJoin = "round";
  context.beginPath();
  traceRing(context, view, workspaceRing(scene));
  context.strokeStyle = colours.wall;
  context.lineWidth = 1.5;
  context.stroke();
  for (const obstacle of scene.obstacles) {
    paintObstacle(context, view, obstacle, colours.obstacle, colours.obstacleEdge, 1.2);
  }
  if (show?.labels !== false) nameObstacles(context, view);
}

/**
 * Layer: starts as discs, goals as rings, in the colour of the robot and true to scale. While a plan runs the starts
 * are empty, as the robots have left them.
 * @type {import("studio/board.js").Layer}
 */
export function paintRobots(context, view) {
  const { state: { scene, show, time, answer } } = view;
  if (!scene) return;
  const left = (time?.now ?? 0) > 0 && Boolean(answer);
  scene.robots.forEach((/** @type {any} */ robot, /** @type {number} */ k) => paintGoal(context, view, robot, k));
  scene.robots.forEach((/** @type {any} */ robot, /** @type {number} */ k) =>
    paintStart(context, view, robot, k, left));
  if (show?.labels !== false) nameRobots(context, view, left);
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {any} robot
 * @param {number} k
 * @param {boolean} left
 */
function paintStart(context, view, robot, k, left) {
  const colour = view.colours.robot(k);
  if (!traceDisc(context, view, robot, robot.start)) return;
  context.fillStyle = left ? faded(colour, 0.14) : colour;
  context.fill();
  context.lineWidth = 1.5;
  context.strokeStyle = left ? faded(colour, 0.6) : view.colours.halo;
  context.stroke();
  paintClearance(context, view, robot, robot.start, colour);
}

/**
 * A ring with a dot: the place to come to.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {any} robot
 * @param {number} k
 */
function paintGoal(context, view, robot, k) {
  const colour = view.colours.robot(k);
  if (!traceDisc(context, view, robot, robot.goal)) return;
  context.fillStyle = faded(colour, 0.16);
  context.fill();
  context.lineWidth = 3.5;
  context.strokeStyle = view.colours.halo;
  context.stroke();
  context.lineWidth = 2;
  context.strokeStyle = colour;
  context.stroke();
  context.beginPath();
  context.arc(view.x(robot.goal[0]), view.y(robot.goal[1]), 1.75, 0, 2 * Math.PI);
  context.fillStyle = colour;
  context.fill();
  paintClearance(context, view, robot, robot.goal, colour);
}

/**
 * What the robot keeps free of obstacles, as a faint ring.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {any} robot
 * @param {readonly number[]} place
 * @param {string} colour
 */
function paintClearance(context, view, robot, place, colour) {
  const clearance = robot.clearance ?? view.state.scene.clearance ?? 0;
  const reach = (robot.radius ?? 0) + clearance;
  if (clearance * view.camera.scale < LEAST_RING || reach * view.camera.scale < LEAST_DISC + LEAST_RING) return;
  context.beginPath();
  traceCircle(context, view, place, reach);
  context.lineWidth = 1;
  context.strokeStyle = faded(colour, 0.4);
  context.stroke();
}

/**
 * Begin the path of a robot's disc; false if it is out of sight.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {any} robot
 * @param {readonly number[]} place
 */
function traceDisc(context, view, robot, [x, y]) {
  const radius = discRadius(view, robot);
  if (!inSight(view, [x, y, x, y], radius * 2 + 16)) return false;
  context.beginPath();
  if (radius > LEAST_DISC) traceCircle(context, view, [x, y], robot.radius);
  else context.arc(view.x(x), view.y(y), radius, 0, 2 * Math.PI);
  return true;
}
