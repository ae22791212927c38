// @ts-check
// The state of the studio: one plain object, changed by patches, watched by keys.

/**
 * @typedef {Record<string, any>} State
 * @typedef {(state: State, before: State) => void} Watcher
 */

/**
 * Make a store. Watchers run once after each patch that changed one of their keys, in the order in which they came.
 * @param {State} initial
 */
export function createStore(initial) {
  let state = Object.freeze({ ...initial });
  /** @type {{keys: string[], watcher: Watcher}[]} */
  let watchers = [];

  return {
    /** @returns {State} */
    get: () => state,

    /** @param {State} patch */
    set(patch) {
      const before = state;
      state = Object.freeze({ ...state, ...patch });
      for (const { keys, watcher } of watchers) {
        if (keys.some((key) => before[key] !== state[key])) watcher(state, before);
      }
    },

    /**
     * Watch keys; returns a function that ends it.
     * @param {string[]} keys
     * @param {Watcher} watcher
     */
    on(keys, watcher) {
      const entry = { keys, watcher };
      watchers = [...watchers, entry];
      return () => {
        watchers = watchers.filter((other) => other !== entry);
      };
    },
  };
}

/** @typedef {ReturnType<typeof createStore>} Store */
