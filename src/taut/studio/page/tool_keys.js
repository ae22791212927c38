// @ts-check
// The keyboard on the board: Tab walks through the objects, arrows move them, Enter goes to their numbers.

import { EditError, moved } from "studio/edits.js";
import { gridSteps, roundStep } from "studio/grid.js";
import { covers } from "studio/hit.js";
import { boxOfRefs, called } from "studio/scene.js";
import { wallWidthOf } from "studio/tool_chains.js";

/**
 * @typedef {import("studio/tools.js").Desk} Desk
 * @typedef {import("studio/tools.js").BoardEvent} BoardEvent
 * @typedef {import("studio/scene.js").Ref} Ref
 */

/** Pixels of what Enter makes, at most. */
const MADE_SIZE = 60;

const ARROWS = /** @type {Record<string, [number, number]>} */ ({
  ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1],
});

/**
 * Keys of the select tool at rest. Escape with nothing selected lets the next Tab leave the board.
 * @param {Desk} desk
 * @param {BoardEvent} event
 * @param {any} state
 */
export function selectKey(desk, event, state) {
  const { selection } = desk.store.get();
  if (ARROWS[event.key]) return selection.length > 0 ? beginNudge(desk, event) : undefined;
  if (event.key === "Escape") {
    event.use();
    if (selection.length > 0) return void desk.select([]);
    desk.say("Tab leaves the map now.");
    return { ...state, leaving: true };
  }
  if (event.key === "Enter" && selection.length > 0) {
    event.use();
    desk.editFields();
  }
  if (event.key === "Tab" && event.onBoard) return walk(desk, event, state);
  return undefined;
}

/**
 * Arrows move what is selected by a step of the grid, with Shift by ten; while they are held it is one step to undo.
 * @param {Desk} desk
 * @param {BoardEvent} event
 */
function beginNudge(desk, event) {
  const { scene, selection } = desk.store.get();
  desk.history.begin(`move ${called(scene, selection)}`);
  return nudge(desk, event, { name: "select.nudge", refs: selection, dx: 0, dy: 0 });
}

/**
 * @param {Desk} desk
 * @param {BoardEvent} event
 * @param {any} state
 */
export function nudge(desk, event, state) {
  const arrow = ARROWS[event.key];
  if (!arrow || !desk.history.dragging()) return undefined;
  event.use();
  const { snap } = desk.store.get();
  const step = (snap?.step ?? gridSteps(desk.camera.get().scale).fine) * (event.shift ? 10 : 1);
  const [dx, dy] = [state.dx + arrow[0] * step, state.dy + arrow[1] * step];
  try {
    const [x, y] = desk.round([dx, dy]);
    desk.history.preview(moved(desk.history.base(), state.refs, x, y));
  } catch (error) {
    if (!(error instanceof EditError)) throw error;
    desk.say(error.message);
    return state;
  }
  return { ...state, dx, dy };
}

/**
 * The arrows are let go, or something else begins: the move is a step.
 * @param {Desk} desk
 */
export function endNudge(desk) {
  desk.history.commit();
  return desk.idle();
}

/**
 * Escape in a drag gives it up.
 * @param {Desk} desk
 * @param {BoardEvent} event
 */
export function escapeDrag(desk, event) {
  if (event.key !== "Escape") return undefined;
  event.use();
  desk.history.abandon();
  return desk.idle();
}

/**
 * In a tool that has nothing begun Escape goes back to selecting, and Enter puts one of its things in the middle of the
 * board, to be moved by arrows and set by numbers: so drawing needs no pointer.
 * @param {Desk} desk
 * @param {BoardEvent} event
 * @param {any} state
 */
export function toolKey(desk, event, { name }) {
  const make = MADE[name];
  if (event.key !== "Escape" && !(event.key === "Enter" && make)) return;
  event.use();
  desk.sketch(null);
  if (event.key === "Enter") {
    const { camera } = desk.window();
    const size = roundStep(MADE_SIZE / camera.scale);
    const round = (/** @type {number} */ metres) => desk.round([Math.round(metres / size) * size, 0])[0];
    make(desk, round(camera.x), round(camera.y), size);
  }
  desk.store.set({ tool: "select" });
}

/** What Enter makes, of a size in metres about a place. */
const MADE = /** @type {Record<string, (desk: Desk, x: number, y: number, size: number) => void>} */ ({
  polygon: (desk, x, y, size) =>
    desk.addObstacle({ polygon: [desk.round([x - size, y - size]), desk.round([x + size, y - size]), [x, y]] }),
  rectangle: (desk, x, y, size) =>
    desk.addObstacle({ rectangle: [...desk.round([x - size, y - size]), ...desk.round([2 * size, size])] }),
  circle: (desk, x, y, size) => desk.addObstacle({ circle: [x, y], radius: size }),
  wall: (desk, x, y, size) => desk.addObstacle({
    line: [desk.round([x - size, y]), desk.round([x + size, y])], width: wallWidthOf(desk.store.get()),
  }),
  robot: (desk, x, y, size) => desk.addRobot(desk.round([x - size, y]), desk.round([x + size, y])),
});

/**
 * Select the object after the one selected, with Shift the one before; past the ends Tab leaves the board.
 * @param {Desk} desk
 * @param {BoardEvent} event
 * @param {any} state
 */
function walk(desk, event, state) {
  if (state.leaving) return { name: "select" };
  const { scene, selection } = desk.store.get();
  const all = everything(scene);
  const places = all.flatMap((ref, k) => (covers(selection, ref) ? [k] : []));
  const next = event.shift ? all[(places[0] ?? 0) - 1] : all[(places[places.length - 1] ?? -1) + 1];
  if (!next) {
    desk.select([]);
    return undefined;
  }
  event.use();
  desk.select([next]);
  desk.reveal(boxOfRefs(scene, [next]));
  return undefined;
}

/**
 * Everything on the map, in the order in which Tab walks.
 * @param {any} scene
 * @returns {Ref[]}
 */
function everything(scene) {
  return [
    ...scene.obstacles.map((/** @type {any} */ { name }) => ({ kind: "obstacle", name })),
    ...scene.robots.flatMap((/** @type {any} */ { name }) => [{ kind: "start", name }, { kind: "goal", name }]),
    { kind: "workspace" },
  ];
}
