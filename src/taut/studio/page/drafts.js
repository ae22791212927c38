// @ts-check
// Drafts: the document as this browser keeps it from edit to edit, so that a crash of page or server loses nothing.
//
// Each tab writes its own draft; what a draft holds is the document, not its history. A tab that lives holds a lock of
// the browser, which goes with it however it ends: so two tabs never take each other's draft for that of a dead one.
// Only a tab that the server refuses (it was started anew and has another token) gives its draft away while it lives.

import { clearDraft, createShelf } from "studio/drafts_shelf.js";
import { claimTab, livingTabs } from "studio/drafts_tabs.js";
import { deepFreeze } from "studio/scene.js";
import { prepareUnderlay } from "studio/underlay.js";

/** @typedef {import("./drafts_shelf.js").Draft} Draft */

/** Milliseconds from an edit to its draft at most. */
const DELAY = 250;
const WATCHED = ["scene", "underlay", "settings", "reach", "file", "server"];

/**
 * Make the keeper of drafts.
 * @param {{store: import("./store.js").Store, history: import("./history.js").History,
 *   dialogs: typeof import("./dialogs.js")}} page
 */
export function createDrafts({ store, history, dialogs }) {
  const shelf = createShelf();
  let tab = "";
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let timer;
  let told = "";

  const write = () => {
    clearTimeout(timer);
    timer = undefined;
    const { scene, underlay, settings, reach, file, server } = store.get();
    if (!tab || !scene) return;
    const cut = Boolean(server?.refused);
    const wrong = shelf.put(tab, { version: 1, time: Date.now(), cut, scene, settings, reach, file }, underlay);
    store.set({ saved: wrong ? { wrong } : { time: Date.now() } });
    if (wrong && wrong !== told) dialogs.toast(wrong, { kind: "bad" });
    told = wrong ?? "";
  };

  const soon = () => {
    timer ??= setTimeout(write, DELAY);
  };

  const flush = () => {
    if (timer !== undefined) write();
  };

  /** Another tab has taken the draft of this one: it is not written again, or two tabs would be one. */
  const giveUp = (/** @type {StorageEvent} */ { key, newValue }) => {
    if (!tab || newValue !== null || !shelf.isOf(tab, key)) return;
    tab = "";
    const wrong = "This work goes on in another tab: what you do here is not kept any more.";
    store.set({ saved: { wrong } });
    dialogs.toast(wrong, { kind: "bad" });
  };

  /**
   * Put the document of a draft on the page; it counts as not saved unless it was when the draft was written.
   * @param {Draft} draft
   * @param {any} underlay
   */
  const show = async (draft, underlay) => {
    if (underlay) await prepareUnderlay(underlay);
    store.set({ answer: null, timelines: null, ...settingsOf(draft) });
    history.replaceAll({ scene: deepFreeze(draft.scene), underlay, file: draft.file });
    if (draft.file?.dirty) history.markSaved(null);
  };

  /**
   * Show what this tab held before it was loaded again, if that is not what the file holds.
   * @param {any} hello
   */
  const resume = async (hello) => {
    const draft = shelf.get(tab);
    if (!draft) return;
    const underlay = shelf.underlay(tab);
    const { scene, file } = store.get();
    const same = (draft.file?.path ?? null) === (hello.file?.path ?? null) && draft.file?.name === file?.name;
    if (same && !draft.file?.dirty) {
      // What the file holds now is newer than a draft without changes of its own.
      store.set(settingsOf(draft));
      if (!underlay) return;
      await prepareUnderlay(underlay);
      history.replaceAll({ scene, underlay, file });
      return;
    }
    await show(draft, underlay);
    if (draft.file?.dirty) dialogs.toast(`Your unsaved work from ${clock(draft.time)} is back.`, { kind: "good" });
  };

  /**
   * Offer the newest work that a dead tab left unsaved; drafts that hold nothing of their own are cleared away.
   * @param {any} hello
   * @param {Set<string>} living
   */
  const offer = async (hello, living) => {
    const now = JSON.stringify(hello.scene);
    /** @type {{id: string, draft: Draft}[]} */
    const left = [];
    for (const id of shelf.ids()) {
      const draft = id === tab ? null : shelf.get(id);
      if (!draft || (living.has(id) && !draft.cut)) continue;
      const unsaved = draft.file?.dirty && JSON.stringify(draft.scene) !== now;
      const path = draft.file?.path ?? null;
      if (!unsaved && !shelf.hasUnderlay(id)) forget(id, living);
      else if (path === null || path === (hello.file?.path ?? null)) left.push({ id, draft });
    }
    const newest = left.sort((a, b) => b.draft.time - a.draft.time)[0];
    if (!newest) return;
    const { id, draft } = newest;
    const others = left.length > 1 ? ` ${left.length - 1} older drafts are kept.` : "";
    const answer = await dialogs.ask({
      title: `Recover unsaved work from ${clock(draft.time)}?`,
      text: `${draft.file?.name ?? "A scene"} with ${counted(draft.scene.obstacles.length, "obstacle")} and `
        + `${counted(draft.scene.robots.length, "robot")} was not saved when its page went away.${others}`,
      buttons: [
        { label: "Discard", value: "discard", kind: "danger" },
        { label: "Recover", value: "recover", kind: "primary" },
      ],
    });
    if (answer === "recover") {
      await show(draft, shelf.underlay(id));
      write();
    }
    // Escape decides nothing: the draft stays for the next time.
    if (answer !== null) clearDraft(id);
  };

  return {
    /**
     * Bring back what was not saved, then keep a draft from now on.
     * @param {any} hello what the server said first
     */
    async start(hello) {
      const claimed = await claimTab();
      tab = claimed.tab;
      const living = await livingTabs();
      if (claimed.own) await resume(hello);
      // Not awaited: the page is there, and may be looked at, under the question.
      if (!claimed.own || !shelf.get(tab)) void offer(hello, living);
      store.on(WATCHED, soon);
      document.addEventListener("visibilitychange", () => document.visibilityState === "hidden" && flush());
      window.addEventListener("pagehide", flush);
      window.addEventListener("storage", giveUp);
      soon();
    },

    /** Write the draft now if anything changed. */
    flush,
  };
}

/** @typedef {ReturnType<typeof createDrafts>} Drafts */

/**
 * Clear away a draft that holds nothing of its own, unless its tab is still there to hold more.
 * @param {string} id
 * @param {Set<string>} living
 */
function forget(id, living) {
  if (!living.has(id)) clearDraft(id);
}

/** @param {Draft} draft */
function settingsOf({ settings, reach }) {
  return { settings: deepFreeze(settings ?? {}), reach: reach ?? null };
}

/** @param {number} time */
function clock(time) {
  const [then, today] = [new Date(time), new Date()];
  const hours = then.toLocaleTimeString("en-GB", { hour: "2-digit", minute: "2-digit" });
  if (then.toDateString() === today.toDateString()) return hours;
  return `${then.toLocaleDateString("en-GB", { day: "numeric", month: "long" })}, ${hours}`;
}

/**
 * @param {number} count
 * @param {string} thing
 */
function counted(count, thing) {
  return `${count} ${thing}${count === 1 ? "" : "s"}`;
}
