// @ts-check
// The tools that need two places: rectangle, circle, robot, measure. Drag from one to the other, or click each.

import { boxLabel, distance, lineLabel, radiusLabel } from "studio/tool_labels.js";
import { SLACK, dragged } from "studio/tool_select.js";

/**
 * @typedef {import("studio/tools.js").Desk} Desk
 * @typedef {import("studio/tools.js").BoardEvent} BoardEvent
 * @typedef {[number, number]} Place
 */

/** Pixels that a rectangle's sides and a circle's radius have at least: less was a click. */
const LEAST = 3;

/**
 * What each kind shows and adds. `about`: whether Shift keeps angles about the first place; `large`: whether there is
 * enough of it, in metres a pixel.
 * @typedef {{about: boolean, label: (a: Place, b: Place) => any,
 *   large: (a: Place, b: Place, pixel: number) => boolean,
 *   add: ((desk: Desk, a: Place, b: Place) => void) | null}} Kind
 */

/** @type {Record<"rectangle" | "circle" | "robot" | "measure", Kind>} */
const KINDS = {
  rectangle: {
    about: false,
    label: boxLabel,
    large: (a, b, pixel) =>
      Math.min(Math.abs(b[0] - a[0]), Math.abs(b[1] - a[1])) > LEAST * pixel,
    add: (desk, a, b) => desk.addObstacle({
      rectangle: [Math.min(a[0], b[0]), Math.min(a[1], b[1]),
        desk.round([Math.abs(b[0] - a[0]), 0])[0], desk.round([Math.abs(b[1] - a[1]), 0])[0]],
    }),
  },
  circle: {
    about: false,
    label: (a, b) => radiusLabel(a, distance(a, b)),
    large: (a, b, pixel) => distance(a, b) > LEAST * pixel,
    add: (desk, a, b) =>
      desk.addObstacle({ circle: a, radius: desk.round([distance(a, b), 0])[0] }),
  },
  robot: {
    about: true,
    label: lineLabel,
    large: (a, b, pixel) => distance(a, b) > SLACK * pixel,
    add: (desk, start, goal) => desk.addRobot(start, goal),
  },
  measure: {
    about: true,
    label: lineLabel,
    large: (a, b, pixel) => distance(a, b) > SLACK * pixel,
    add: null,
  },
};

/**
 * The first place is taken.
 * @param {Desk} desk
 * @param {BoardEvent} event
 * @param {any} state
 */
export function beginSpan(desk, event, { name }) {
  const { point } = desk.snap(event, {});
  return stretchSpan(desk, event, { name: `${name}.span`, from: event, first: point });
}

/**
 * The second place follows the pointer.
 * @param {Desk} desk
 * @param {BoardEvent} event
 * @param {any} state
 */
export function stretchSpan(desk, event, state) {
  const kind = kindOf(state);
  const { about, label } = KINDS[kind];
  const { point: free, guides } = desk.snap(event, { from: about && event.shift ? state.first : null });
  const point = kind === "rectangle" && event.shift ? squared(state.first, free) : free;
  desk.sketch({ kind, points: [state.first, point], labels: [label(state.first, point)], guides });
  return { ...state, second: point };
}

/**
 * The second place is taken, if there is something between; else the first was a click and the second is yet to come.
 * @param {Desk} desk
 * @param {BoardEvent} event
 * @param {any} state
 */
export function endSpan(desk, event, state) {
  const { first, second } = stretchSpan(desk, event, state);
  const kind = KINDS[kindOf(state)];
  if (!kind.large(first, second, 1 / desk.camera.get().scale)) {
    if (dragged(state.from, event)) desk.say("Too small to be kept: drag farther, or click the second place.");
    return { ...state, second };
  }
  if (kind.add) kind.add(desk, first, second);
  return desk.idle(kind.add ? null : desk.store.get().sketch);
}

/**
 * @param {{name: string}} state
 * @returns {keyof typeof KINDS}
 */
function kindOf({ name }) {
  return /** @type {keyof typeof KINDS} */ (name.split(".")[0]);
}

/**
 * The corner that makes a square.
 * @param {Place} from
 * @param {readonly number[]} to
 * @returns {Place}
 */
function squared([x, y], to) {
  const [dx, dy] = [to[0] - x, to[1] - y];
  const side = Math.max(Math.abs(dx), Math.abs(dy));
  return [x + (dx < 0 ? -side : side), y + (dy < 0 ? -side : side)];
}
