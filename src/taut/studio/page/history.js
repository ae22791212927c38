// @ts-check
// Undo and redo of the document (scene and underlay): every step keeps the frozen values themselves, so going back
// gives back what was, byte for byte. What one edit did not change is shared between steps.

import { deepFreeze, existing } from "studio/scene.js";

/** @typedef {import("./scene.js").Scene} Scene */
/** @typedef {import("./scene.js").Ref} Ref */
/** @typedef {{label: string, scene: Scene, underlay: any, selection: readonly Ref[]}} Step what was before the edit */

/**
 * Make the history of a store's document. The store's keys scene, revision, underlay, history and the `dirty` of file
 * are its alone to set.
 * @param {import("./store.js").Store} store
 */
export function createHistory(store) {
  /** @type {Step[]} */
  let past = [];
  /** @type {Step[]} */
  let future = [];
  /** @type {Step | null} the drag under way */
  let drag = null;
  let saved = store.get().scene;

  /**
   * @param {string} label
   * @returns {Step}
   */
  const now = (label) => {
    const { scene, underlay = null, selection = [] } = store.get();
    return { label, scene, underlay, selection };
  };

  /**
   * @param {Scene} scene
   * @param {any} underlay
   * @param {readonly Ref[]} selection
   */
  const show = (scene, underlay, selection) => {
    const state = store.get();
    store.set({
      scene,
      underlay,
      selection: existing(scene, selection),
      revision: scene === state.scene ? state.revision : (state.revision ?? 0) + 1,
      file: withDirty(state.file, scene),
      history: labelsFor(state.history),
    });
  };

  /**
   * @param {any} file
   * @param {Scene} scene
   */
  const withDirty = (file, scene) => {
    const dirty = scene !== saved;
    return file && file.dirty !== dirty ? { ...file, dirty } : file;
  };

  /** @param {any} before kept when nothing changed, so that watchers sleep */
  const labelsFor = (before) => {
    const [undo, redo] = [past.at(-1)?.label ?? null, future.at(-1)?.label ?? null];
    return before && before.undo === undo && before.redo === redo ? before : { undo, redo };
  };

  /**
   * @param {string} label
   * @param {Partial<Step>} patch
   */
  const edit = (label, patch) => {
    abandon();
    const before = now(label);
    const after = { ...before, ...patch };
    if (after.scene !== before.scene || after.underlay !== before.underlay) {
      past.push(before);
      future = [];
    }
    show(after.scene, after.underlay, after.selection);
  };

  /** Give up a drag: all is as it was at its beginning. */
  const abandon = () => {
    if (!drag) return;
    const { scene, underlay, selection } = drag;
    drag = null;
    show(scene, underlay, selection);
  };

  /**
   * Go one step from one stack to the other; the label is that of the edit undone or done again.
   * @param {Step[]} from
   * @param {Step[]} to
   */
  const step = (from, to) => {
    abandon();
    const target = from.pop();
    if (!target) return null;
    to.push(now(target.label));
    show(target.scene, target.underlay, target.selection);
    return target.label;
  };

  return {
    /**
     * Do an edit: one step.
     * @param {string} label
     * @param {Scene} scene
     * @param {{selection?: readonly Ref[]}} [with_] what is selected after it
     */
    change(label, scene, with_ = {}) {
      edit(label, { scene: deepFreeze(scene), ...with_ });
    },

    /**
     * @param {string} label
     * @param {any} underlay
     */
    changeUnderlay(label, underlay) {
      edit(label, { underlay: deepFreeze(underlay) });
    },

    /**
     * Begin a drag: previews until commit or abandon are one step.
     * @param {string} label
     */
    begin(label) {
      abandon();
      drag = now(label);
    },

    /** @param {Scene} scene */
    preview(scene) {
      if (!drag) throw new Error("a preview needs a drag that has begun");
      const { underlay, selection } = store.get();
      show(deepFreeze(scene), underlay, selection);
    },

    /** @param {any} underlay */
    previewUnderlay(underlay) {
      if (!drag) throw new Error("a preview needs a drag that has begun");
      const { scene, selection } = store.get();
      show(scene, deepFreeze(underlay), selection);
    },

    /**
     * End a drag: one step, or none where nothing changed.
     * @param {string} [label] instead of that of its beginning
     */
    commit(label) {
      if (!drag) return;
      const before = { ...drag, label: label ?? drag.label };
      drag = null;
      const { scene, underlay, selection } = store.get();
      if (scene === before.scene && underlay === before.underlay) return;
      past.push(before);
      future = [];
      show(scene, underlay, selection);
    },

    abandon,

    /** The scene from which a drag is computed: that of its beginning. */
    base: () => /** @type {Scene} */ (drag ? drag.scene : store.get().scene),

    dragging: () => drag !== null,

    /** Take the last edit back; a drag under way is given up first. Returns its label, or null. */
    undo: () => step(past, future),

    /** Do again what was undone last. Returns its label, or null. */
    redo: () => step(future, past),

    /** Labels of the steps that can be undone and done again, nearest first. */
    labels: () => ({
      undo: past.map(({ label }) => label).reverse(),
      redo: future.map(({ label }) => label).reverse(),
    }),

    /**
     * Show another document: history begins anew and is clean.
     * @param {{scene: Scene, underlay?: any, file?: any, selection?: readonly Ref[]}} document_
     */
    replaceAll({ scene, underlay = null, file, selection = [] }) {
      [past, future, drag] = [[], [], null];
      saved = deepFreeze(scene);
      if (file !== undefined) store.set({ file: { ...file, dirty: false } });
      show(saved, deepFreeze(underlay), selection);
      store.set({ opened: (store.get().opened ?? 0) + 1 });
    },

    /**
     * Say that the scene is in its file; with no scene given, the one shown.
     * @param {Scene | null} [scene] null: what is shown is in no file
     */
    markSaved(scene = store.get().scene) {
      saved = scene;
      const { file, scene: shown } = store.get();
      store.set({ file: withDirty(file, shown) });
    },
  };
}

/** @typedef {ReturnType<typeof createHistory>} History */
