// @ts-check
// Edits of whole things: each takes a scene and gives a new frozen one that shares all that it did not change.

import { EditError, freeName, notNegative, place, positive, theObstacle, theRobot } from "studio/edits_checks.js";
import { obstacleWithField, robotWithField, sceneWithField } from "studio/edits_fields.js";
import { shifted } from "studio/edits_numbers.js";
import { movedObstacle } from "studio/edits_moving.js";
import { removeVertex } from "studio/edits_outline.js";
import { withObstacle, withObstacles, withRobot, withRobots } from "studio/edits_replacing.js";
import { freshName } from "studio/scene.js";

export { EditError };
export { moved, pivotOf, rotated } from "studio/edits_moving.js";

/** @typedef {import("./scene.js").Scene} Scene */
/** @typedef {import("./scene.js").Ref} Ref */
/** @typedef {import("./scene.js").Point} Point */
/** @typedef {import("./scene.js").Obstacle} Obstacle */
/** @typedef {import("./scene.js").Robot} Robot */

/**
 * Add an obstacle as the last; without a name it gets the next free one.
 * @param {Scene} scene
 * @param {Omit<Obstacle, "name"> & {name?: string}} obstacle
 * @returns {Scene}
 */
export function addObstacle(scene, obstacle) {
  const { name: given, ...shape } = obstacle;
  const name = given === undefined ? freshName(scene, "obstacle") : freeName(scene, "obstacle", given);
  return withObstacles(scene, [...scene.obstacles, { name, ...checkedShape(name, shape) }]);
}

/**
 * Add a robot as the last; a name, radius and speed that are not given follow from the robots there are.
 * @param {Scene} scene
 * @param {Partial<Robot> & {start: Point, goal: Point}} robot
 * @returns {Scene}
 */
export function addRobot(scene, robot) {
  const { name: given, start, goal, radius, speed, ...rest } = robot;
  const name = given === undefined ? freshName(scene, "robot") : freeName(scene, "robot", given);
  const last = scene.robots.at(-1);
  const added = {
    name,
    start: place(start, `${name}: start`),
    goal: place(goal, `${name}: goal`),
    radius: notNegative(radius ?? last?.radius ?? 0.2, `${name}: radius`),
    speed: positive(speed ?? last?.speed ?? 1, `${name}: speed`),
    ...rest,
  };
  return withRobots(scene, [...scene.robots, added]);
}

/**
 * Remove things; a ref with a vertex loses that corner only, one of an end the whole robot; the workspace stays.
 * @param {Scene} scene
 * @param {readonly Ref[]} refs
 * @returns {Scene}
 */
export function removed(scene, refs) {
  const obstacles = wholeNames(refs, ["obstacle"]);
  const robots = wholeNames(refs, ["robot", "start", "goal"]);
  // From the highest corner down, so that the numbers of the others still hold.
  const corners = refs
    .filter(({ kind, name = "", vertex }) => vertex !== undefined && !(kind === "obstacle" && obstacles.has(name)))
    .sort((a, b) => Number(b.vertex) - Number(a.vertex));
  let out = corners.reduce(removeVertex, scene);
  if (obstacles.size) out = withObstacles(out, out.obstacles.filter(({ name }) => !obstacles.has(name)));
  if (robots.size) out = withRobots(out, out.robots.filter(({ name }) => !robots.has(name)));
  return out;
}

/**
 * Put a moved copy of each thing, with a fresh name, behind the others.
 * @param {Scene} scene
 * @param {readonly Ref[]} refs
 * @param {number} dx
 * @param {number} dy
 * @returns {{scene: Scene, refs: Ref[]}} the refs are those of the copies
 */
export function duplicated(scene, refs, dx, dy) {
  const obstacles = wholeNames(refs, ["obstacle"]);
  const robots = wholeNames(refs, ["robot", "start", "goal"]);
  let out = scene;
  /** @type {Ref[]} */
  const copies = [];
  for (const obstacle of scene.obstacles.filter(({ name }) => obstacles.has(name))) {
    const name = freshName(out, "obstacle", obstacle.name);
    out = withObstacles(out, [...out.obstacles, { ...movedObstacle(obstacle, dx, dy), name }]);
    copies.push({ kind: "obstacle", name });
  }
  for (const robot of scene.robots.filter(({ name }) => robots.has(name))) {
    const name = freshName(out, "robot", robot.name);
    const ends = { start: shifted(robot.start, dx, dy), goal: shifted(robot.goal, dx, dy) };
    out = withRobots(out, [...out.robots, { ...robot, name, ...ends }]);
    copies.push({ kind: "robot", name });
  }
  return { scene: out, refs: copies };
}

/**
 * Set one field of a thing as a form gives it; null takes an optional one away.
 * @param {Scene} scene
 * @param {Ref} ref
 * @param {string} field
 * @param {any} value
 * @returns {Scene}
 */
export function setField(scene, ref, field, value) {
  if (ref.kind === "scene" || ref.kind === "workspace") return sceneWithField(scene, field, value);
  if (field === "name") return renamed(scene, ref, value);
  if (ref.kind === "obstacle") return obstacleWithField(scene, ref, field, value);
  return robotWithField(scene, ref, field, value);
}

/**
 * Give an obstacle or a robot another name.
 * @param {Scene} scene
 * @param {Ref} ref
 * @param {string} name
 * @returns {Scene}
 */
export function renamed(scene, ref, name) {
  if (ref.kind === "obstacle") {
    const obstacle = theObstacle(scene, ref);
    if (freeName(scene, "obstacle", name, obstacle.name) === obstacle.name) return scene;
    return withObstacle(scene, obstacle.name, { ...obstacle, name });
  }
  const robot = theRobot(scene, ref);
  if (freeName(scene, "robot", name, robot.name) === robot.name) return scene;
  return withRobot(scene, robot.name, { ...robot, name });
}

/**
 * @param {string} name
 * @param {Omit<Obstacle, "name">} shape
 * @returns {Omit<Obstacle, "name">}
 */
function checkedShape(name, shape) {
  if (shape.polygon) {
    if (shape.polygon.length < 3) throw new EditError(`${name}: a polygon needs at least 3 corners.`);
    return { polygon: shape.polygon.map((point) => place(point, `${name}: a corner`)) };
  }
  if (shape.line) {
    if (shape.line.length < 2) throw new EditError(`${name}: a wall needs at least 2 points.`);
    const points = shape.line.map((point) => place(point, `${name}: a point`));
    return { line: points, width: positive(shape.width, `${name}: width`) };
  }
  if (shape.circle) {
    return { circle: place(shape.circle, `${name}: the centre`), radius: positive(shape.radius, `${name}: radius`) };
  }
  const [x, y, width, height] = shape.rectangle ?? [];
  const [left, bottom] = place([x, y], `${name}: the corner`);
  const rectangle = [left, bottom, positive(width, `${name}: width`), positive(height, `${name}: height`)];
  return shape.angle ? { rectangle, angle: shape.angle } : { rectangle };
}

/**
 * Names of the whole things of these kinds.
 * @param {readonly Ref[]} refs
 * @param {readonly string[]} kinds
 * @returns {Set<string>}
 */
function wholeNames(refs, kinds) {
  const whole = refs.filter(({ kind, vertex }) => vertex === undefined && kinds.includes(kind));
  return new Set(whole.map(({ name }) => name ?? ""));
}
