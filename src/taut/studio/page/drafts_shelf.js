// @ts-check
// Where drafts lie: the browser's local storage, one entry a tab and one for its picture, which is large and changes
// seldom.

/**
 * @typedef {{version: 1, time: number, cut: boolean, scene: any, settings: any, reach: any, file: any}} Draft cut: the
 *   server refused its tab, which may live on but can do nothing
 */

const DRAFT = "taut:draft:";
const PICTURE = "taut:picture:";

const FULL = "This browser's storage is full: your work is not kept in it. Save the scene to a file.";
const NO_PICTURE = "The picture is too large for this browser's storage: the scene is kept, the picture is not.";
const NONE = "This browser keeps no data for this page: your work is not kept. Save the scene to a file.";

/** Make the shelf of drafts. */
export function createShelf() {
  /** @type {any} the picture that is written; null: none, undefined: not known */
  let kept;

  /**
   * @param {string} tab
   * @param {any} underlay
   * @returns {boolean} whether it is kept, or there is none
   */
  const putPicture = (tab, underlay) => {
    if (underlay === kept) return true;
    try {
      if (underlay) localStorage.setItem(PICTURE + tab, JSON.stringify(underlay));
      else localStorage.removeItem(PICTURE + tab);
      kept = underlay;
      return true;
    } catch {
      localStorage.removeItem(PICTURE + tab);
      kept = undefined;
      return false;
    }
  };

  return {
    /**
     * Write a draft; without its picture where there is no room for both.
     * @param {string} tab
     * @param {Draft} draft
     * @param {any} underlay
     * @returns {string | null} what is not kept, in a sentence
     */
    put(tab, draft, underlay) {
      const text = JSON.stringify(draft);
      try {
        localStorage.setItem(DRAFT + tab, text);
      } catch (error) {
        if (!(error instanceof DOMException && error.name === "QuotaExceededError")) return NONE;
        localStorage.removeItem(PICTURE + tab);
        kept = undefined;
        try {
          localStorage.setItem(DRAFT + tab, text);
        } catch {
          return FULL;
        }
        return underlay ? NO_PICTURE : null;
      }
      return putPicture(tab, underlay) ? null : NO_PICTURE;
    },

    /**
     * @param {string} tab
     * @returns {Draft | null}
     */
    get(tab) {
      const draft = read(DRAFT + tab);
      return draft?.version === 1 && draft.scene?.obstacles && draft.scene?.robots ? draft : null;
    },

    /** @param {string} tab */
    underlay: (tab) => read(PICTURE + tab),

    /** @param {string} tab */
    hasUnderlay: (tab) => read(PICTURE + tab) !== null,

    /**
     * Whether a storage event is about the draft of a tab.
     * @param {string} tab
     * @param {string | null} key
     */
    isOf: (tab, key) => key === DRAFT + tab,

    /** Tabs, living or dead, that have a draft. */
    ids() {
      try {
        return Object.keys(localStorage).filter((key) => key.startsWith(DRAFT)).map((key) => key.slice(DRAFT.length));
      } catch {
        return [];
      }
    },
  };
}

/** @param {string} tab */
export function clearDraft(tab) {
  localStorage.removeItem(DRAFT + tab);
  localStorage.removeItem(PICTURE + tab);
}

/** @param {string} key */
function read(key) {
  try {
    return JSON.parse(localStorage.getItem(key) ?? "null");
  } catch {
    return null;
  }
}
