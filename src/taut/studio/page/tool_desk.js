// @ts-check
// What tools work on: the scene and its history, places that snap, what is drawn meanwhile, and words for the user.

import { EditError, addObstacle, addRobot } from "studio/edits.js";
import { gridSteps } from "studio/grid.js";
import { freshName, sameRef } from "studio/scene.js";
import { resolution, rounded, snapped, snappedMove } from "studio/snapping.js";

/**
 * @typedef {import("studio/scene.js").Ref} Ref
 * @typedef {import("studio/tools.js").BoardEvent} BoardEvent
 */

/** Pixels from the border of the board within which something counts as out of sight. */
const BORDER = 40;
/** Snapping that is held off. */
const FREE = Object.freeze({ grid: false, step: null, vertex: false, edge: false, angle: false });

/**
 * @param {{canvas: HTMLCanvasElement, board: import("studio/board.js").Board, store: import("studio/store.js").Store,
 *   history: ReturnType<typeof import("studio/history.js").createHistory>,
 *   camera: import("studio/camera.js").Camera}} parts
 */
export function createDesk({ canvas, board, store, history, camera }) {
  const free = (/** @type {BoardEvent} */ event) => event.control;
  const snap = (/** @type {BoardEvent} */ event) => {
    const chosen = free(event) ? FREE : store.get().snap ?? FREE;
    return { ...chosen, step: chosen.step ?? gridSteps(camera.get().scale).fine };
  };

  return {
    store,
    history,
    camera,
    window: () => board.window(),

    /** Whether an event asks for no snapping. */
    free,

    /**
     * The place that an event means, with what it snapped to; from: the place about which angles are kept.
     * @param {BoardEvent} event
     * @param {{scene?: any, except?: Ref[], from?: readonly number[] | null}} about
     * @returns {{point: [number, number], guides: any[]}}
     */
    snap(event, { scene = store.get().scene, except = [], from = null }) {
      const options = from ? { except, from, constrain: true } : { except };
      return /** @type {any} */ (snapped(event.point, scene, snap(event), camera.get(), options));
    },

    /**
     * The move that an event means.
     * @param {BoardEvent} event
     * @param {any} scene
     * @param {readonly Ref[]} refs
     * @param {number} dx
     * @param {number} dy
     */
    snapMove(event, scene, refs, dx, dy) {
      return snappedMove(scene, refs, dx, dy, snap(event), camera.get());
    },

    /**
     * A place with no more digits than can be seen.
     * @param {readonly number[]} point
     * @returns {[number, number]}
     */
    round([x, y]) {
      const digit = resolution(camera.get());
      return [rounded(x, digit), rounded(y, digit)];
    },

    /**
     * Do an edit as one step; what cannot be is said.
     * @param {string} label
     * @param {(scene: any) => any} edit
     * @param {(scene: any) => Ref[]} choose what is selected after it
     */
    change(label, edit, choose) {
      try {
        const scene = edit(store.get().scene);
        history.change(label, scene, { selection: Object.freeze(choose(scene)) });
      } catch (error) {
        if (!(error instanceof EditError)) throw error;
        this.say(error.message);
      }
    },

    /** @param {Record<string, any>} shape an obstacle without its name */
    addObstacle(shape) {
      this.change(`add ${freshName(store.get().scene, "obstacle")}`, (scene) => addObstacle(scene, shape),
        (scene) => [{ kind: "obstacle", name: scene.obstacles.at(-1).name }]);
    },

    /**
     * @param {[number, number]} start
     * @param {[number, number]} goal
     */
    addRobot(start, goal) {
      const { scene: now, robotRadius: radius } = store.get();
      this.change(`add ${freshName(now, "robot")}`, (scene) => addRobot(scene, { start, goal, radius }),
        (scene) => [{ kind: "robot", name: scene.robots.at(-1).name }]);
    },

    /** @param {readonly Ref[]} refs */
    select(refs) {
      const { selection } = store.get();
      const same = refs.length === selection.length
        && refs.every((ref, k) => sameRef(ref, selection[k]));
      if (!same) store.set({ selection: Object.freeze([...refs]) });
    },

    /** @param {any} sketch what the running tool draws, or null */
    sketch(sketch) {
      if (sketch !== store.get().sketch) store.set({ sketch });
    },

    /** @param {string} words */
    say(words) {
      if (words !== store.get().said) store.set({ said: words });
    },

    /**
     * Show what the pointer is on.
     * @param {Ref | null} hover
     * @param {string} cursor
     */
    point(hover, cursor) {
      const before = store.get().hover;
      const same = hover === before || (hover && before && sameRef(hover, before));
      if (!same) store.set({ hover });
      canvas.style.cursor = cursor;
    },

    /**
     * The state of the tool at rest.
     * @param {any} [sketch] what stays drawn
     */
    idle(sketch = null) {
      this.sketch(sketch);
      return { name: String(store.get().tool) };
    },

    /**
     * Bring a box into sight without zooming.
     * @param {import("studio/scene.js").Box | null} box
     */
    reveal(box) {
      if (!box) return;
      const { width, height, camera: now } = board.window();
      const [x, y] = [(box[0] + box[2]) / 2, (box[1] + box[3]) / 2];
      const hidden = Math.abs(x - now.x) * now.scale > width / 2 - BORDER
        || Math.abs(y - now.y) * now.scale > height / 2 - BORDER;
      if (hidden) camera.set({ x, y, scale: now.scale });
    },

    /** Go to the numbers of what is selected. */
    editFields() {
      store.set({ tab: "properties" });
      requestAnimationFrame(() => {
        const fields = /** @type {HTMLInputElement[]} */ ([...document.querySelectorAll("#panel [data-field] input")]);
        const field = fields.find((each) => each.offsetParent !== null); // those of other tabs are hidden
        field?.focus();
        field?.select();
      });
    },
  };
}

/** @typedef {ReturnType<typeof createDesk>} Desk */
