// @ts-check
// Moving about the map: dragging the paper, wheel and trackpad, two fingers. It works in the middle of any tool.

import { panned, toWorld, zoomedAt } from "studio/camera.js";
import { createMachine } from "studio/tool_machine.js";

/** Zoom a pixel of the wheel, and of a trackpad's pinch. */
const WHEEL = 0.0016;
const PINCH = 0.011;
/** Pixels of a line, where wheels count in lines. */
const LINE = 33;
/** Milliseconds for which a wheel that looked like a trackpad is taken for one. */
const GESTURE = 300;

/** States of moving about and what they hear; `grab` begins with a drag, `second` with another finger. */
const TABLE = Object.freeze({
  rest: { grab: [grab, "pan"], second: [hold, "pinch"] },
  pan: { move: [pan], release: [rest, "rest"], second: [hold, "pinch"] },
  pinch: { move: [pinch], release: [rest, "rest"] },
});

/**
 * Make what moves the camera. `takes(event)` says whether a press is for it; then feed it.
 * @param {{canvas: HTMLCanvasElement, camera: import("studio/camera.js").Camera,
 *   window: () => import("studio/camera.js").Window, store: import("studio/store.js").Store,
 *   pixelOf: (event: MouseEvent) => [number, number]}} parts
 */
export function createNavigation(parts) {
  const { canvas, pixelOf } = parts;
  /** @type {Map<number, [number, number]>} */
  const fingers = new Map();
  const machine = createMachine(/** @type {any} */ (TABLE), { ...parts, fingers }, { name: "rest" });
  let space = false;
  let trackpadUntil = 0;

  /** @param {WheelEvent} event */
  function wheel(event) {
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? LINE : 1;
    const [dx, dy] = [event.deltaX * lines, event.deltaY * lines];
    const { camera, window } = parts;
    if (event.ctrlKey || event.metaKey) {
      const rate = isNotch(event) ? WHEEL : PINCH;
      camera.set(zoomedAt(window(), pixelOf(event), Math.exp(-dy * rate)));
      return;
    }
    if (!isNotch(event)) trackpadUntil = event.timeStamp + GESTURE;
    if (event.shiftKey && dx === 0) camera.set(panned(camera.get(), -dy, 0));
    else if (event.timeStamp < trackpadUntil) camera.set(panned(camera.get(), -dx, -dy));
    else camera.set(zoomedAt(window(), pixelOf(event), Math.exp(-dy * WHEEL)));
  }

  canvas.addEventListener("wheel", wheel, { passive: false });

  return {
    /** @param {boolean} held whether the space bar is held */
    hold(held) {
      space = held;
    },

    held: () => space,

    busy: () => machine.state().name !== "rest",

    /**
     * A press; whether it is for moving about. The second finger of a hand always is.
     * @param {PointerEvent} event
     * @returns {"no" | "yes" | "second"}
     */
    down(event) {
      if (event.pointerType === "touch") {
        fingers.set(event.pointerId, pixelOf(event));
        if (fingers.size === 2) {
          machine.send("second", event);
          return "second";
        }
        if (fingers.size > 2) return "yes";
      }
      const grabs = event.button === 1 || (event.button === 0 && (space || parts.store.get().tool === "pan"));
      if (grabs) machine.send("grab", event);
      return grabs ? "yes" : "no";
    },

    /**
     * @param {PointerEvent} event
     * @returns {boolean} whether the camera was moved with it
     */
    move(event) {
      if (fingers.has(event.pointerId)) fingers.set(event.pointerId, pixelOf(event));
      return machine.send("move", event);
    },

    /**
     * @param {PointerEvent} event
     * @returns {boolean} whether this ended a move of the camera
     */
    up(event) {
      fingers.delete(event.pointerId);
      return machine.send("release", event);
    },

    destroy() {
      canvas.removeEventListener("wheel", wheel);
    },
  };
}

/**
 * Whether a wheel turned by notches: mice count 120 each and never sideways.
 * @param {WheelEvent & {wheelDeltaY?: number}} event
 */
function isNotch({ deltaX, deltaMode, wheelDeltaY = 0 }) {
  return deltaMode !== 0 || (deltaX === 0 && wheelDeltaY !== 0 && wheelDeltaY % 120 === 0);
}

/**
 * @param {any} desk
 * @param {PointerEvent} event
 */
function grab({ pixelOf }, event) {
  return { name: "pan", id: event.pointerId, at: pixelOf(event) };
}

/**
 * @param {any} desk
 * @param {PointerEvent} event
 * @param {any} state
 */
function pan({ camera, pixelOf }, event, { id, at }) {
  if (event.pointerId !== id) return undefined;
  const [x, y] = pixelOf(event);
  camera.set(panned(camera.get(), x - at[0], y - at[1]));
  return { name: "pan", id, at: [x, y] };
}

/**
 * Two fingers hold two places of the map.
 * @param {any} desk
 */
function hold({ fingers, window }) {
  const [a, b] = [...fingers.values()];
  return { name: "pinch", place: toWorld(window(), middle(a, b)), span: apart(a, b), scale: window().camera.scale };
}

/**
 * @param {any} desk
 * @param {PointerEvent} event
 * @param {any} state
 */
function pinch({ fingers, window, camera }, event, state) {
  if (fingers.size < 2) return undefined;
  const [a, b] = [...fingers.values()];
  const now = window();
  const [x, y] = middle(a, b);
  const factor = (state.scale * apart(a, b)) / state.span / now.camera.scale;
  camera.set(zoomedAt(now, [x, y], factor));
  const { scale } = camera.get();
  camera.set({
    x: state.place[0] - (x - now.width / 2) / scale, y: state.place[1] + (y - now.height / 2) / scale, scale,
  });
  return undefined;
}

function rest() {
  return { name: "rest" };
}

/**
 * @param {[number, number]} a
 * @param {[number, number]} b
 * @returns {[number, number]}
 */
function middle(a, b) {
  return [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
}

/**
 * @param {[number, number]} a
 * @param {[number, number]} b
 */
function apart(a, b) {
  return Math.max(Math.hypot(b[0] - a[0], b[1] - a[1]), 1);
}
