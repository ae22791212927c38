// @ts-check
// Fields as forms give them: checked, then set; what the rest of the page need not know of files.

import { EditError, boundsOf, finite, notNegative, oneOf, place, positive, theObstacle, theRobot }
  from "studio/edits_checks.js";
import { difference, wrapped } from "studio/edits_numbers.js";
import { movedObstacle } from "studio/edits_moving.js";
import { withObstacle, withRobot, withWorkspace } from "studio/edits_replacing.js";
import { boxRound, deepFreeze, outlineOf, shapeOf, workspaceRing } from "studio/scene.js";

/** @typedef {import("./scene.js").Scene} Scene */
/** @typedef {import("./scene.js").Ref} Ref */
/** @typedef {import("./scene.js").Obstacle} Obstacle */
/** @typedef {import("./scene.js").Robot} Robot */

const AT_GOAL = ["stay", "leave"];

/**
 * Set one field of the scene; an empty name is none.
 * @param {Scene} scene
 * @param {string} field
 * @param {any} value
 * @returns {Scene}
 */
export function sceneWithField(scene, field, value) {
  if (field === "bounds") {
    const bounds = boundsOf(value);
    return withWorkspace({ ...scene, bounds }, workspaceRing({ ...scene, workspace: undefined, bounds }));
  }
  if (field === "name") {
    if (typeof value !== "string") throw new EditError("The name of a scene is a text.");
    const { taut, name, ...rest } = scene;
    return deepFreeze(value === "" ? { taut, ...rest } : { taut, name: value, ...rest });
  }
  if (field === "at_goal") return deepFreeze({ ...scene, at_goal: oneOf(value, "At goal", AT_GOAL) });
  if (!["clearance", "gap", "headway"].includes(field)) throw new EditError(`A scene has no field ${field}.`);
  return deepFreeze({ ...scene, [field]: notNegative(value, capital(field)) });
}

/**
 * Set one field of an obstacle; x and y are those of a circle's centre, a rectangle's corner before turning, or the
 * lower left of the box round the corners.
 * @param {Scene} scene
 * @param {Ref} ref
 * @param {string} field
 * @param {any} value
 * @returns {Scene}
 */
export function obstacleWithField(scene, ref, field, value) {
  const obstacle = theObstacle(scene, ref);
  const what = `${obstacle.name}: ${field}`;
  const shape = shapeOf(obstacle);
  if (field === "x" || field === "y") return put(scene, withPosition(obstacle, field, finite(value, what)));
  if (shape === "rectangle" && field === "angle") {
    const { angle, ...rest } = obstacle;
    const turn = wrapped(finite(value, what));
    return put(scene, turn === 0 ? rest : { ...rest, angle: turn });
  }
  const size = { width: 2, height: 3 }[field];
  if (shape === "rectangle" && size !== undefined) {
    return put(scene, { ...obstacle, rectangle: replaced(obstacle.rectangle, size, positive(value, what)) });
  }
  if ((shape === "circle" && field === "radius") || (shape === "line" && field === "width")) {
    return put(scene, { ...obstacle, [field]: positive(value, what) });
  }
  throw new EditError(`${obstacle.name} has no field ${field}.`);
}

/**
 * Set one field of a robot; null gives clearance and what it does at its goal back to the scene.
 * @param {Scene} scene
 * @param {Ref} ref of the robot or of one of its ends (fields x and y)
 * @param {string} field
 * @param {any} value
 * @returns {Scene}
 */
export function robotWithField(scene, ref, field, value) {
  const robot = theRobot(scene, ref);
  const what = `${robot.name}: ${field.replace("_", " ")}`;
  if (ref.kind !== "robot" && (field === "x" || field === "y")) {
    const end = ref.kind === "start" ? robot.start : robot.goal;
    const at = field === "x" ? [finite(value, what), end[1]] : [end[0], finite(value, what)];
    return withRobot(scene, robot.name, { ...robot, [ref.kind]: at });
  }
  if (field === "start" || field === "goal") {
    return withRobot(scene, robot.name, { ...robot, [field]: place(value, what) });
  }
  if (field === "radius") return withRobot(scene, robot.name, { ...robot, radius: notNegative(value, what) });
  if (field === "speed") return withRobot(scene, robot.name, { ...robot, speed: positive(value, what) });
  return withRobot(scene, robot.name, withOption(robot, field, value, what));
}

/**
 * @param {Robot} robot
 * @param {string} field
 * @param {any} value
 * @param {string} what
 * @returns {Robot}
 */
function withOption(robot, field, value, what) {
  const { clearance, start_time: startTime, at_goal: atGoal, ...rest } = robot;
  const options = { clearance, start_time: startTime, at_goal: atGoal };
  if (!(field in options)) throw new EditError(`${robot.name} has no field ${field}.`);
  const none = value === null || (field === "start_time" && value === 0);
  const checked = none ? undefined : field === "at_goal" ? oneOf(value, what, AT_GOAL) : notNegative(value, what);
  const given = Object.entries({ ...options, [field]: checked }).filter((entry) => entry[1] !== undefined);
  return { ...rest, ...Object.fromEntries(given) };
}

/**
 * @param {Obstacle} obstacle
 * @param {"x" | "y"} field
 * @param {number} value
 * @returns {Obstacle}
 */
function withPosition(obstacle, field, value) {
  const axis = field === "x" ? 0 : 1;
  if (obstacle.circle) return { ...obstacle, circle: replaced(obstacle.circle, axis, value) };
  if (obstacle.rectangle) return { ...obstacle, rectangle: replaced(obstacle.rectangle, axis, value) };
  const by = difference(value, boxRound(outlineOf(obstacle))?.[axis] ?? 0);
  return axis === 0 ? movedObstacle(obstacle, by, 0) : movedObstacle(obstacle, 0, by);
}

/**
 * @param {readonly number[] | undefined} numbers
 * @param {number} which
 * @param {number} number
 */
function replaced(numbers, which, number) {
  return (numbers ?? []).map((before, k) => (k === which ? number : before));
}

/**
 * @param {Scene} scene
 * @param {Obstacle} obstacle
 */
function put(scene, obstacle) {
  return withObstacle(scene, obstacle.name, obstacle);
}

/** @param {string} text */
function capital(text) {
  return text[0].toUpperCase() + text.slice(1);
}
