// @ts-check
// Scenes with one part replaced: everything else is shared, the order of things stays, the result is frozen.

import { deepFreeze } from "studio/scene.js";

/** @typedef {import("./scene.js").Scene} Scene */
/** @typedef {import("./scene.js").Point} Point */
/** @typedef {import("./scene.js").Obstacle} Obstacle */
/** @typedef {import("./scene.js").Robot} Robot */

/**
 * @param {Scene} scene
 * @param {readonly Obstacle[]} obstacles
 * @returns {Scene}
 */
export function withObstacles(scene, obstacles) {
  return deepFreeze({ ...scene, obstacles });
}

/**
 * @param {Scene} scene
 * @param {readonly Robot[]} robots
 * @returns {Scene}
 */
export function withRobots(scene, robots) {
  return deepFreeze({ ...scene, robots });
}

/**
 * Put an entry in the place of the one of that name.
 * @param {Scene} scene
 * @param {string} name
 * @param {Obstacle} entry
 * @returns {Scene}
 */
export function withObstacle(scene, name, entry) {
  return withObstacles(scene, scene.obstacles.map((obstacle) => (obstacle.name === name ? entry : obstacle)));
}

/**
 * Put an entry in the place of the one of that name.
 * @param {Scene} scene
 * @param {string} name
 * @param {Robot} entry
 * @returns {Scene}
 */
export function withRobot(scene, name, entry) {
  return withRobots(scene, scene.robots.map((robot) => (robot.name === name ? entry : robot)));
}

/**
 * Give the scene another outline; bounds stay bounds while their corners are those of a box.
 * @param {Scene} scene
 * @param {readonly Point[]} ring
 * @returns {Scene}
 */
export function withWorkspace(scene, ring) {
  const [[xmin, ymin], , [xmax, ymax]] = ring;
  const box = [[xmin, ymin], [xmax, ymin], [xmax, ymax], [xmin, ymax]];
  const isBox = ring.length === 4 && ring.every(([x, y], k) => x === box[k][0] && y === box[k][1]);
  const outline = scene.bounds && isBox && xmin < xmax && ymin < ymax
    ? { bounds: [xmin, ymin, xmax, ymax] }
    : { workspace: ring };
  const entries = Object.entries(scene).flatMap((entry) =>
    entry[0] === "bounds" || entry[0] === "workspace" ? Object.entries(outline) : [entry],
  );
  return deepFreeze(/** @type {any} */ (Object.fromEntries(entries)));
}

/**
 * An entry with another outline: polygons and walls stay what they are, a rectangle becomes a polygon.
 * @param {Obstacle} obstacle
 * @param {readonly Point[]} points
 * @returns {Obstacle}
 */
export function withOutline(obstacle, points) {
  if (!obstacle.rectangle) return { ...obstacle, [obstacle.line ? "line" : "polygon"]: points };
  const { rectangle, angle, ...rest } = obstacle;
  return { ...rest, polygon: points };
}
