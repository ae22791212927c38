// @ts-check
// Moving and turning things, one or many at once, in one pass over the scene.

import { finite } from "studio/edits_checks.js";
import { shifted, sum, turned, wrapped } from "studio/edits_numbers.js";
import { withObstacles, withOutline, withRobots, withWorkspace } from "studio/edits_replacing.js";
import { centreOf, obstacleNamed, outlineOf, workspaceRing } from "studio/scene.js";

/** @typedef {import("./scene.js").Scene} Scene */
/** @typedef {import("./scene.js").Ref} Ref */
/** @typedef {import("./scene.js").Point} Point */
/** @typedef {import("./scene.js").Obstacle} Obstacle */
/** @typedef {(point: Point) => [number, number]} Motion */

/**
 * Move things by dx, dy; a ref with a vertex moves that corner only, one of a robot both of its ends.
 * @param {Scene} scene
 * @param {readonly Ref[]} refs
 * @param {number} dx
 * @param {number} dy
 * @returns {Scene}
 */
export function moved(scene, refs, dx, dy) {
  finite(dx, "A move");
  finite(dy, "A move");
  if (dx === 0 && dy === 0) return scene;
  return mapped(scene, refs, (point) => shifted(point, dx, dy), (obstacle) => movedObstacle(obstacle, dx, dy));
}

/**
 * Turn things about a centre, or about what `pivotOf` says; rectangles keep their kind by their angle.
 * @param {Scene} scene
 * @param {readonly Ref[]} refs
 * @param {number} angle radians, counter-clockwise
 * @param {Point} [centre]
 * @returns {Scene}
 */
export function rotated(scene, refs, angle, centre) {
  finite(angle, "An angle");
  const pivot = centre ?? pivotOf(scene, refs);
  if (angle === 0 || !pivot) return scene;
  const whole = (/** @type {Obstacle} */ obstacle) => turnedObstacle(obstacle, angle, pivot);
  return mapped(scene, refs, (point) => turned(point, pivot, angle), whole);
}

/**
 * What things turn about unless told: the middle of one rectangle itself, else that of the box round them.
 * @param {Scene} scene
 * @param {readonly Ref[]} refs
 * @returns {Point | null}
 */
export function pivotOf(scene, refs) {
  const [first] = refs;
  const only = refs.length === 1 && first.kind === "obstacle" ? obstacleNamed(scene, first.name) : undefined;
  return only?.rectangle ? middleOf(only.rectangle) : centreOf(scene, refs);
}

/**
 * An obstacle moved by dx, dy.
 * @param {Obstacle} obstacle
 * @param {number} dx
 * @param {number} dy
 * @returns {Obstacle}
 */
export function movedObstacle(obstacle, dx, dy) {
  if (obstacle.circle) return { ...obstacle, circle: shifted(obstacle.circle, dx, dy) };
  if (obstacle.rectangle) {
    const [x, y, ...size] = obstacle.rectangle;
    return { ...obstacle, rectangle: [sum(x, dx), sum(y, dy), ...size] };
  }
  return withOutline(obstacle, outlineOf(obstacle).map((point) => shifted(point, dx, dy)));
}

/**
 * @param {Obstacle} obstacle
 * @param {number} angle
 * @param {Point} pivot
 * @returns {Obstacle}
 */
function turnedObstacle(obstacle, angle, pivot) {
  if (obstacle.circle) return { ...obstacle, circle: turned(obstacle.circle, pivot, angle) };
  if (!obstacle.rectangle) {
    return withOutline(obstacle, outlineOf(obstacle).map((point) => turned(point, pivot, angle)));
  }
  const middle = middleOf(obstacle.rectangle);
  const [cx, cy] = turned(middle, pivot, angle);
  const { angle: before = 0, ...rest } = movedObstacle(obstacle, cx - middle[0], cy - middle[1]);
  const after = wrapped(before + angle);
  return after === 0 ? rest : { ...rest, angle: after };
}

/**
 * @param {readonly number[]} rectangle
 * @returns {[number, number]}
 */
function middleOf([x, y, width, height]) {
  return [x + width / 2, y + height / 2];
}

/**
 * The scene with a motion done to all that the refs name.
 * @param {Scene} scene
 * @param {readonly Ref[]} refs
 * @param {Motion} motion of points
 * @param {(obstacle: Obstacle) => Obstacle} whole what it does to a whole obstacle
 * @returns {Scene}
 */
function mapped(scene, refs, motion, whole) {
  const asked = gathered(refs);
  let out = scene;
  if (asked.obstacles.size) {
    out = withObstacles(out, out.obstacles.map((obstacle) => {
      const corners = asked.obstacles.get(obstacle.name);
      if (!corners) return obstacle;
      return corners === "all" ? whole(obstacle) : withOutline(obstacle, some(outlineOf(obstacle), corners, motion));
    }));
  }
  if (asked.starts.size || asked.goals.size) {
    out = withRobots(out, out.robots.map((robot) => {
      const [start, goal] = [asked.starts.has(robot.name), asked.goals.has(robot.name)];
      if (!start && !goal) return robot;
      const ends = { start: start ? motion(robot.start) : robot.start, goal: goal ? motion(robot.goal) : robot.goal };
      return { ...robot, ...ends };
    }));
  }
  if (!asked.workspace) return out;
  return withWorkspace(out, some(workspaceRing(scene), asked.workspace, motion));
}

/**
 * @param {readonly Point[]} points
 * @param {Set<number> | "all"} which
 * @param {Motion} motion
 */
function some(points, which, motion) {
  return points.map((point, k) => (which === "all" || which.has(k) ? motion(point) : point));
}

/**
 * What refs ask for together: a whole thing outweighs its corners, a robot its ends.
 * @param {readonly Ref[]} refs
 */
function gathered(refs) {
  /** @type {Map<string, Set<number> | "all">} */
  const obstacles = new Map();
  const [starts, goals] = [new Set(), new Set()];
  /** @type {Set<number> | "all" | undefined} */
  let workspace;
  /**
   * @param {Set<number> | "all" | undefined} before
   * @param {number | undefined} vertex
   */
  const joined = (before, vertex) =>
    vertex === undefined || before === "all" ? "all" : new Set([...(before ?? []), vertex]);
  for (const { kind, name = "", vertex } of refs) {
    if (kind === "obstacle") obstacles.set(name, joined(obstacles.get(name), vertex));
    else if (kind === "workspace") workspace = joined(workspace, vertex);
    if (kind === "robot" || kind === "start") starts.add(name);
    if (kind === "robot" || kind === "goal") goals.add(name);
  }
  return { obstacles, starts, goals, workspace };
}
