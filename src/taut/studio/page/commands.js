// @ts-check
// What keys, buttons and menus do: one function a command, each undoable, each said.

import { announce } from "studio/announce.js";
import { fitted, zoomedAt } from "studio/camera.js";
import { toast } from "studio/dialogs.js";
import { duplicated, removed } from "studio/edits.js";
import { openHelp } from "studio/help.js";
import { openOut } from "studio/out.js";
import { boxOfRefs, boxOfScene, called } from "studio/scene.js";
import { nextTheme } from "studio/theme.js";
import { TOOLS } from "studio/tools.js";

/** Pixels by which a copy lies beside what it was made of. */
const ASIDE = 24;

/**
 * @param {{store: import("studio/store.js").Store, history: any, board: import("studio/board.js").Board,
 *   camera: import("studio/camera.js").Camera, link: import("studio/link.js").Link,
 *   player: import("studio/player.js").Player}} page
 */
export function createCommands({ store, history, board, camera, link, player }) {
  /** The selection, or nothing said but why. */
  const chosen = (/** @type {string} */ verb) => {
    const { selection } = store.get();
    if (selection.length === 0) announce(`Select what to ${verb} first.`);
    return selection;
  };
  const attempt = (/** @type {() => void} */ run) => {
    try {
      run();
    } catch (error) {
      toast(/** @type {Error} */ (error).message, { kind: "bad", seconds: 6 });
    }
  };
  const step = (/** @type {string} */ word, /** @type {string | null} */ label) =>
    announce(label ? `${word}: ${label}` : `Nothing to ${word === "Undid" ? "undo" : "redo"}.`);
  /** What was shown whole last, and the camera that did it. @type {{box: any, camera: any}} */
  let whole = { box: null, camera: null };
  const fitBox = (/** @type {any} */ box) => {
    const { width, height } = board.window();
    if (!box || !width) return;
    camera.set(fitted(box, width, height));
    whole = { box, camera: camera.get() };
  };

  return {
    undo: () => step("Undid", history.undo()),
    redo: () => step("Did again", history.redo()),
    out: () => openOut(store, link),
    help: () => openHelp(TOOLS, store.get().hello?.version ?? ""),

    selectAll() {
      const { scene } = store.get();
      const selection = Object.freeze([
        ...scene.obstacles.map((/** @type {any} */ { name }) => ({ kind: "obstacle", name })),
        ...scene.robots.map((/** @type {any} */ { name }) => ({ kind: "robot", name })),
      ]);
      store.set({ selection, tool: "select" });
      announce(`${selection.length} objects selected.`);
    },

    duplicate() {
      const refs = chosen("duplicate");
      if (refs.length === 0) return;
      attempt(() => {
        const aside = ASIDE / camera.get().scale;
        const { scene, refs: made } = duplicated(store.get().scene, refs, aside, -aside);
        history.change(`duplicate ${called(store.get().scene, refs)}`, scene, { selection: made });
        announce(`Duplicated: ${called(scene, made)} selected.`);
      });
    },

    remove() {
      const refs = chosen("delete");
      if (refs.length === 0) return;
      attempt(() => {
        const { scene } = store.get();
        const label = `delete ${called(scene, refs)}`;
        history.change(label, removed(scene, refs));
        announce(`Did: ${label}`);
      });
    },

    /** Give the name field of the selection the focus. */
    rename() {
      if (chosen("rename").length !== 1) return;
      store.set({ tab: "properties" });
      // The panel shows a new selection with the next frame.
      requestAnimationFrame(() => {
        const field = document.querySelector('#panel [data-field="name"] input');
        if (field instanceof HTMLInputElement) (field.focus(), field.select());
      });
    },

    fit() {
      const { scene } = store.get();
      if (scene) fitBox(boxOfScene(scene));
    },

    /** Fit again what was fitted last, while nobody has edited or moved the camera since. Whether it did. */
    refit() {
      const { undo, redo } = store.get().history;
      if (undo || redo || whole.camera !== camera.get()) return false;
      fitBox(whole.box);
      return true;
    },

    fitSelection() {
      const { scene, selection } = store.get();
      if (selection.length) fitBox(boxOfRefs(scene, selection));
    },

    /** Bring a place into view without zooming, if it is not there already. */
    reveal(/** @type {readonly [number, number]} */ [x, y]) {
      const { width, height } = board.window();
      const now = camera.get();
      const [across, up] = [Math.abs(x - now.x) * now.scale, Math.abs(y - now.y) * now.scale];
      if (across > width / 2 - 40 || up > height / 2 - 40) camera.set({ ...now, x, y });
    },

    zoom(/** @type {number} */ factor) {
      const window = board.window();
      camera.set(zoomedAt(window, [window.width / 2, window.height / 2], factor));
    },

    tool(/** @type {string} */ tool) {
      if (store.get().mode !== "compare") store.set({ tool });
    },

    mode(/** @type {string} */ mode) {
      player.pause();
      store.set({ mode });
      announce(`Mode: ${mode}.`);
    },

    toggleSnap(/** @type {string} */ name) {
      const { snap } = store.get();
      store.set({ snap: Object.freeze({ ...snap, [name]: !snap[name] }) });
      announce(`Snapping to ${name} ${snap[name] ? "off" : "on"}.`);
    },

    /** Go some steps on or back in the mode for steps. */
    step(/** @type {number} */ by) {
      const { mode, steps } = store.get();
      const last = (steps.list?.length ?? 0) - 1;
      if (mode !== "steps" || last < 0) return;
      store.set({ steps: Object.freeze({ ...steps, index: Math.min(Math.max(0, steps.index + by), last) }) });
    },

    nudgeTime(/** @type {number} */ seconds) {
      player.pause();
      player.seek(store.get().time.now + seconds);
    },

    nextTheme() {
      const choice = nextTheme(store);
      announce(`Theme: ${choice === "system" ? "as the system" : choice}.`);
    },
  };
}
