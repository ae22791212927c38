// @ts-check
// The two things done to the picture on the board: moving it, and giving two points of it their distance.

import { toWorld } from "studio/camera.js";
import { resolution, rounded } from "studio/snapping.js";
import { calibrated, movedUnderlay } from "studio/underlay.js";

/** @typedef {import("./scene.js").Point} Point */
/** @typedef {{name: string, from: Point | null}} Gesture the tool and the place where it began, if it has */

/**
 * Listen for the tools "underlay-move" and "underlay-scale" on the board; all other tools are left alone.
 * @param {{canvas: HTMLCanvasElement, camera: {get(): any}, store: import("./store.js").Store,
 *   history: import("./history.js").History, dialogs: typeof import("./dialogs.js")}} page
 * @returns {() => void} stops it
 */
export function attachUnderlay({ canvas, camera, store, history, dialogs }) {
  /** @type {Point | null} */
  let from = null;
  /** @type {any} the picture when its move began */
  let base = null;

  const placeOf = (/** @type {PointerEvent} */ event) => {
    const box = canvas.getBoundingClientRect();
    const window_ = { camera: camera.get(), width: box.width, height: box.height };
    const step = resolution(camera.get());
    const [x, y] = toWorld(window_, [event.clientX - box.left, event.clientY - box.top]);
    return /** @type {Point} */ ([rounded(x, step), rounded(y, step)]);
  };

  const end = () => {
    [from, base] = [null, null];
    history.abandon();
    store.set({ sketch: null });
  };

  const leave = () => {
    end();
    store.set({ tool: "select", said: "" });
  };

  const down = (/** @type {PointerEvent} */ event) => {
    const at = placeOf(event);
    if (store.get().tool === "underlay-scale") return void second(at);
    [from, base] = [at, store.get().underlay];
    canvas.setPointerCapture(event.pointerId);
    history.begin("move the picture");
  };

  const move = (/** @type {PointerEvent} */ event) => {
    const at = placeOf(event);
    store.set({ pointer: at });
    if (!from) return;
    if (base) history.previewUnderlay(movedUnderlay(base, at[0] - from[0], at[1] - from[1]));
    else store.set({ sketch: { kind: "measure", points: [from, at] } });
  };

  const up = () => {
    if (!base) return;
    history.commit();
    [from, base] = [null, null];
  };

  /** @param {Point} at */
  const second = async (at) => {
    if (!from) {
      from = at;
      store.set({ said: "Click the second point of the picture", sketch: { kind: "measure", points: [at, at] } });
      return;
    }
    const first = from;
    const apart = Math.hypot(at[0] - first[0], at[1] - first[1]);
    if (!(apart > 4 / camera.get().scale)) return;
    leave();
    const answer = await dialogs.form({
      title: "Scale of the picture",
      text: "How far apart are the two points?",
      fields: [{ name: "metres", label: "Distance", type: "number", unit: "m", above: 0,
        value: Number(apart.toPrecision(4)) }],
      submit: "Set scale",
    });
    const { underlay } = store.get();
    if (answer && underlay) {
      history.changeUnderlay("scale the picture", calibrated(underlay, first, at, answer.values.metres));
    }
  };

  const isOurs = () => String(store.get().tool).startsWith("underlay-") && store.get().underlay;
  /** @type {[string, (event: any) => void][]} */
  const listeners = [["pointerdown", down], ["pointermove", move], ["pointerup", up], ["pointercancel", end]];
  const guarded = listeners.map(([name, run]) => {
    const listener = (/** @type {any} */ event) => {
      // Middle and right buttons, the wheel and two fingers still push the paper.
      if (!isOurs() || (name === "pointerdown" && event.button !== 0)) return;
      event.stopImmediatePropagation();
      run(event);
    };
    canvas.addEventListener(name, listener, { capture: true });
    return () => canvas.removeEventListener(name, listener, { capture: true });
  });
  const escape = (/** @type {KeyboardEvent} */ event) => {
    if (event.key !== "Escape" || !isOurs()) return;
    event.stopPropagation();
    leave();
  };
  window.addEventListener("keydown", escape, { capture: true });
  const off = store.on(["tool"], ({ tool }) => {
    if (tool === "underlay-scale") store.set({ said: "Click a point of the picture; Escape leaves" });
    if (tool === "underlay-move") store.set({ said: "Drag the picture; Escape leaves" });
    if (!String(tool).startsWith("underlay-") && (from || base)) end();
  });
  return () => {
    guarded.forEach((stop) => stop());
    window.removeEventListener("keydown", escape, { capture: true });
    off();
  };
}
