// @ts-check
// What edits refuse, each in one sentence: numbers of the wrong kind or sign, names that are taken, things gone.

import { obstacleNamed, robotNamed } from "studio/scene.js";

/** @typedef {import("./scene.js").Scene} Scene */
/** @typedef {import("./scene.js").Ref} Ref */
/** @typedef {import("./scene.js").Obstacle} Obstacle */
/** @typedef {import("./scene.js").Robot} Robot */

/** An edit that cannot be; its message is one sentence for the user. */
export class EditError extends Error {
  /** @param {string} message */
  constructor(message) {
    super(message);
    this.name = "EditError";
  }
}

/**
 * @param {any} value
 * @param {string} what
 * @returns {number}
 */
export function finite(value, what) {
  if (typeof value !== "number" || !Number.isFinite(value)) {
    throw new EditError(`${what} must be a number, not ${shown(value)}.`);
  }
  return value;
}

/**
 * @param {any} value
 * @param {string} what
 */
export function positive(value, what) {
  if (!(finite(value, what) > 0)) throw new EditError(`${what} must be more than zero, not ${shown(value)}.`);
  return value;
}

/**
 * @param {any} value
 * @param {string} what
 */
export function notNegative(value, what) {
  if (!(finite(value, what) >= 0)) throw new EditError(`${what} must not be negative, not ${shown(value)}.`);
  return value;
}

/**
 * @param {any} value
 * @param {string} what
 * @returns {[number, number]}
 */
export function place(value, what) {
  if (!Array.isArray(value) || value.length !== 2) {
    throw new EditError(`${what} must be a point x, y, not ${shown(value)}.`);
  }
  return [finite(value[0], `${what}: x`), finite(value[1], `${what}: y`)];
}

/**
 * @param {any} value
 * @param {string} what
 * @param {readonly string[]} choices
 */
export function oneOf(value, what, choices) {
  if (!choices.includes(value)) throw new EditError(`${what} must be ${choices.join(" or ")}, not ${shown(value)}.`);
  return value;
}

/**
 * Numbers that make bounds.
 * @param {any} value
 * @returns {[number, number, number, number]}
 */
export function boundsOf(value) {
  if (!Array.isArray(value) || value.length !== 4) {
    throw new EditError("Bounds are four numbers: xmin, ymin, xmax, ymax.");
  }
  const [xmin, ymin, xmax, ymax] = value.map((number) => finite(number, "Each bound"));
  if (!(xmin < xmax)) throw new EditError(`Bounds need xmin < xmax, not ${xmin} and ${xmax}.`);
  if (!(ymin < ymax)) throw new EditError(`Bounds need ymin < ymax, not ${ymin} and ${ymax}.`);
  return [xmin, ymin, xmax, ymax];
}

/**
 * The name, if it is one and nothing else of its kind has it.
 * @param {Scene} scene
 * @param {"obstacle" | "robot"} kind
 * @param {any} name
 * @param {string} [own] the name that the thing has now
 * @returns {string}
 */
export function freeName(scene, kind, name, own) {
  if (typeof name !== "string" || name.trim() === "") throw new EditError(`Every ${kind} needs a name.`);
  const taken = kind === "obstacle" ? obstacleNamed(scene, name) : robotNamed(scene, name);
  if (taken && name !== own) throw new EditError(`There is another ${kind} named ${name}; every name must be unique.`);
  return name;
}

/**
 * @param {Scene} scene
 * @param {Ref} ref
 * @returns {Obstacle}
 */
export function theObstacle(scene, ref) {
  const obstacle = ref.kind === "obstacle" ? obstacleNamed(scene, ref.name) : undefined;
  if (!obstacle) throw new EditError(`There is no obstacle ${ref.name ?? ""} any more.`);
  return obstacle;
}

/**
 * @param {Scene} scene
 * @param {Ref} ref
 * @returns {Robot}
 */
export function theRobot(scene, ref) {
  const robot = robotNamed(scene, ref.name);
  if (!robot) throw new EditError(`There is no robot ${ref.name ?? ""} any more.`);
  return robot;
}

/** @param {any} value */
function shown(value) {
  return typeof value === "string" ? `“${value}”` : String(value);
}
