// @ts-check
// The select tool: clicks, boxes, and dragging of things, of their corners, sides and sizes, and turning them.

import { toScreen } from "studio/camera.js";
import { EditError, duplicated, moved, pivotOf, rotated } from "studio/edits.js";
import { becomesPolygon, edgeMoved, insertVertex, resized, setVertex } from "studio/edits_outline.js";
import { REACH, covers, gripAt, hitAt, wholeThings } from "studio/hit.js";
import { called, centreOf, sameRef } from "studio/scene.js";
import { edgeAt, refsInBox } from "studio/scene_hits.js";
import { cornerLabels, moveLabel, sizeLabel, turnLabel } from "studio/tool_labels.js";

/**
 * @typedef {import("studio/tools.js").Desk} Desk
 * @typedef {import("studio/tools.js").BoardEvent} BoardEvent
 * @typedef {import("studio/tool_machine.js").State} State
 */

/** Pixels after which a press is a drag. */
export const SLACK = 4;
/** Radians to which turning with Shift keeps. */
const TURN_STEP = Math.PI / 12;

/**
 * Show what would be grasped here.
 * @param {Desk} desk
 * @param {BoardEvent} event
 */
export function hover(desk, event) {
  const { scene, selection } = desk.store.get();
  const reach = REACH[event.device];
  const grip = gripAt(desk.window(), scene, selection, event.pixel, reach);
  const hit = grip ? null : hitAt(desk.window(), scene, selection, event.pixel, reach);
  desk.point(hit, grip ? gripCursor(desk, grip) : !hit ? "default" : covers(selection, hit) ? "move" : "pointer");
}

/**
 * @param {Desk} desk
 * @param {BoardEvent} event
 * @returns {State}
 */
export function press(desk, event) {
  const { scene, selection } = desk.store.get();
  const reach = REACH[event.device];
  const grip = gripAt(desk.window(), scene, selection, event.pixel, reach);
  if (grip) return { name: "select.grip", from: event, grip };
  const hit = hitAt(desk.window(), scene, selection, event.pixel, reach);
  const onThing = hit && (hit.kind !== "workspace" || covers(selection, hit));
  return { name: onThing ? "select.body" : "select.void", from: event, hit };
}

/**
 * A press that was let go at once selects; with Shift it adds or takes away.
 * @param {Desk} desk
 * @param {BoardEvent} event
 * @param {any} state
 * @returns {State}
 */
export function click(desk, event, { hit, from }) {
  const { selection } = desk.store.get();
  if (!hit) {
    if (!from.shift) desk.select([]);
  } else if (!from.shift) desk.select([hit]);
  else desk.select(toggled(selection, hit));
  return desk.idle();
}

/**
 * @param {Desk} desk
 * @param {BoardEvent} event
 * @param {any} state
 * @returns {State}
 */
export function clickGrip(desk, event, { grip, from }) {
  if (grip.kind === "vertex") {
    const corners = desk.store.get().selection.filter((/** @type {any} */ ref) => ref.vertex !== undefined);
    desk.select(from.shift ? toggled(corners, grip.ref) : [grip.ref]);
  }
  return desk.idle();
}

/**
 * A press on the paper becomes a box.
 * @param {Desk} desk
 * @param {BoardEvent} event
 * @param {any} state
 */
export function beginBox(desk, event, { from }) {
  if (!dragged(from, event)) return undefined;
  const kept = from.shift ? wholeThings(desk.store.get().selection) : [];
  return stretchBox(desk, event, { name: "select.box", from, kept });
}

/**
 * @param {Desk} desk
 * @param {BoardEvent} event
 * @param {any} state
 */
export function stretchBox(desk, event, state) {
  const [a, b] = [state.from.point, event.point];
  desk.sketch({ kind: "box", points: [a, b] });
  const box = /** @type {[number, number, number, number]} */ (
    [Math.min(a[0], b[0]), Math.min(a[1], b[1]), Math.max(a[0], b[0]), Math.max(a[1], b[1])]);
  const found = refsInBox(desk.store.get().scene, box);
  desk.select([...state.kept, ...found.filter((ref) => !covers(state.kept, ref))]);
  return state;
}

/**
 * A press on a thing becomes its move; with Alt that of a copy. The side of a workspace moves by itself.
 * @param {Desk} desk
 * @param {BoardEvent} event
 * @param {any} state
 */
export function beginMove(desk, event, { from, hit }) {
  if (!dragged(from, event)) return undefined;
  const { scene, selection } = desk.store.get();
  if (!covers(selection, hit)) desk.select(from.shift ? [...wholeThings(selection), hit] : [hit]);
  const refs = wholeThings(desk.store.get().selection);
  if (hit.kind === "workspace") {
    const reach = REACH[event.device] / desk.camera.get().scale;
    const side = edgeAt(scene, hit, from.point, reach);
    if (side) {
      desk.history.begin("move a side of the workspace");
      return drag(desk, event, { name: "select.drag", from, refs: [hit], way: "side", edge: side.edge });
    }
  }
  if (event.alt && refs.every(({ kind }) => kind !== "workspace")) {
    const copies = duplicated(scene, refs, 0, 0);
    desk.history.begin(`duplicate ${called(scene, refs)}`);
    desk.history.preview(copies.scene);
    desk.select(copies.refs);
    return drag(desk, event, { name: "select.drag", from, refs: copies.refs, way: "move", origin: copies.scene });
  }
  desk.history.begin(`move ${called(scene, refs)}`);
  return drag(desk, event, { name: "select.drag", from, refs, way: "move" });
}

/**
 * @param {Desk} desk
 * @param {BoardEvent} event
 * @param {any} state
 */
export function beginGrip(desk, event, { from, grip }) {
  if (!dragged(from, event)) return undefined;
  const { scene, selection } = desk.store.get();
  if (grip.kind === "turn") {
    const refs = wholeThings(selection);
    desk.history.begin(`turn ${called(scene, refs)}`);
    return drag(desk, event, { name: "select.drag", from, refs, way: "turn", centre: pivotOf(scene, refs) });
  }
  if (grip.kind === "size") {
    desk.history.begin(`resize ${called(scene, [grip.ref])}`);
    return drag(desk, event, { name: "select.drag", from, refs: [grip.ref], way: "size", handle: grip.index });
  }
  const corners = selection.filter((/** @type {any} */ ref) => ref.vertex !== undefined);
  const several = corners.length > 1 && corners.some((/** @type {any} */ ref) => sameRef(ref, grip.ref));
  if (!several) desk.select([grip.ref]);
  const refs = several ? corners : [grip.ref];
  desk.history.begin(`move ${called(scene, refs)}`);
  return drag(desk, event, { name: "select.drag", from, refs, way: several ? "move" : "corner" });
}

/** How each way of dragging makes the scene: from the scene at its beginning, the event and the state. */
const WAYS = Object.freeze({
  /** @type {Way} */
  move(desk, base, event, { from, refs }) {
    const [x, y] = [event.point[0] - from.point[0], event.point[1] - from.point[1]];
    const [dx0, dy0] = !event.shift ? [x, y] : Math.abs(x) >= Math.abs(y) ? [x, 0] : [0, y];
    const { dx, dy, guides } = desk.snapMove(event, base, refs, dx0, dy0);
    const scene = moved(base, refs, event.shift && dx0 === 0 ? 0 : dx, event.shift && dy0 === 0 ? 0 : dy);
    return { scene, guides, labels: [moveLabel(scene, refs, dx, dy)] };
  },

  /** @type {Way} */
  side(desk, base, event, { from, refs: [ref], edge }) {
    const [x, y] = [event.point[0] - from.point[0], event.point[1] - from.point[1]];
    const { dx, dy, guides } = desk.snapMove(event, base, [ref], x, y);
    const scene = edgeMoved(base, ref, edge, dx, dy);
    return { scene, guides, labels: sizeLabel(scene, ref) };
  },

  /** @type {Way} */
  corner(desk, base, event, { refs: [ref] }) {
    const from = event.shift ? before(base, ref) : null;
    const { point, guides } = desk.snap(event, { scene: base, except: [ref], from });
    const scene = setVertex(base, ref, point);
    return { scene, guides, labels: cornerLabels(scene, ref) };
  },

  /** @type {Way} */
  size(desk, base, event, { refs: [ref], handle }) {
    const { point, guides } = desk.snap(event, { scene: base, except: [ref] });
    const scene = resized(base, ref, handle, point);
    return { scene, guides, labels: sizeLabel(scene, ref) };
  },

  /** @type {Way} */
  turn(desk, base, event, { from, refs, centre: [cx, cy] }) {
    const at = (/** @type {BoardEvent} */ { point: [x, y] }) => Math.atan2(y - cy, x - cx);
    const free = Math.atan2(Math.sin(at(event) - at(from)), Math.cos(at(event) - at(from)));
    const step = event.shift ? TURN_STEP : desk.free(event) ? 0 : Math.PI / 180;
    const angle = step ? Math.round(free / step) * step : free;
    const scene = rotated(base, refs, angle, [cx, cy]);
    return { scene, guides: [{ kind: "line", from: [cx, cy], to: event.point }], labels: [turnLabel([cx, cy], angle)] };
  },
});

/**
 * @typedef {(desk: Desk, base: any, event: BoardEvent, state: any) =>
 *   {scene: any, guides: any[], labels: any[]}} Way
 */

/**
 * Draw a drag on: what is shown is always made anew from the scene at its beginning.
 * @param {Desk} desk
 * @param {BoardEvent} event
 * @param {any} state
 */
export function drag(desk, event, state) {
  if (!desk.history.dragging()) return desk.idle(); // given up elsewhere, by an undo
  const base = state.origin ?? desk.history.base();
  try {
    const { scene, guides, labels } = WAYS[/** @type {keyof typeof WAYS} */ (state.way)](desk, base, event, state);
    desk.history.preview(scene);
    desk.sketch({ kind: "drag", guides, labels });
  } catch (error) {
    if (!(error instanceof EditError)) throw error;
    desk.say(error.message);
  }
  return state;
}

/**
 * @param {Desk} desk
 * @param {BoardEvent} event
 * @param {any} state
 */
export function drop(desk, event, state) {
  drag(desk, event, state);
  desk.history.commit();
  return desk.idle();
}

/** @param {Desk} desk */
export function giveUp(desk) {
  desk.history.abandon();
  return desk.idle();
}

/**
 * A double click on a side puts a corner there; on anything else it goes to the thing's numbers.
 * @param {Desk} desk
 * @param {BoardEvent} event
 */
export function doubleClick(desk, event) {
  const { scene, selection } = desk.store.get();
  const hit = hitAt(desk.window(), scene, selection, event.pixel, REACH[event.device]);
  if (!hit) return;
  const side = edgeAt(scene, hit, event.point, REACH[event.device] / desk.camera.get().scale);
  if (!side) {
    desk.editFields();
    return;
  }
  const label = `add a corner to ${called(scene, [hit])}${becomesPolygon(scene, hit) ? " (now a polygon)" : ""}`;
  const corner = { ...hit, vertex: side.edge + 1 };
  desk.change(label, (before) => insertVertex(before, hit, side.edge, desk.round(side.point)), () => [corner]);
}

/**
 * The cursor that tells how a grip moves: a size along the line from the middle of its thing.
 * @param {Desk} desk
 * @param {import("studio/hit.js").Grip} grip
 */
function gripCursor(desk, { kind, ref, pixel }) {
  if (kind !== "size") return kind === "turn" ? "grab" : "move";
  const [x, y] = toScreen(desk.window(), centreOf(desk.store.get().scene, [ref]) ?? [0, 0]);
  const eighth = Math.round(Math.atan2(y - pixel[1], pixel[0] - x) / (Math.PI / 4));
  return ["ew-resize", "nesw-resize", "ns-resize", "nwse-resize"][((eighth % 4) + 4) % 4];
}

/**
 * @param {BoardEvent} from
 * @param {BoardEvent} event
 */
export function dragged(from, event) {
  return Math.hypot(event.pixel[0] - from.pixel[0], event.pixel[1] - from.pixel[1]) > SLACK;
}

/**
 * @param {readonly any[]} selection
 * @param {any} ref
 */
function toggled(selection, ref) {
  if (!covers(selection, ref) || ref.vertex !== undefined) {
    const kept = selection.filter((other) => !sameRef(other, ref));
    return kept.length < selection.length ? kept : [...selection, ref];
  }
  return selection.filter(({ kind, name }) => !covers([{ kind, name }], ref));
}

/**
 * The corner before a corner, about which Shift keeps its angle.
 * @param {any} scene
 * @param {any} ref
 */
function before(scene, ref) {
  return cornerLabels(scene, ref)[0]?.from ?? null;
}
