// @ts-check
// Timelines of the plan on show: asked for whenever the plan, the range of contact or sight changes.

/** Milliseconds of quiet before they are asked for: not at every step of a drag. */
const QUIET = 120;

/**
 * Keep the store's `timelines` that of its `answer`: {…, answer, reach, sight}; null while there is none.
 * @param {import("studio/store.js").Store} store
 * @param {import("studio/link.js").Link} link
 */
export function keepTimelines(store, link) {
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let timer;

  async function ask() {
    const { answer } = store.get();
    if (!answer) return;
    const demand = contactOf(store.get());
    const fields = { scene: answer.scene, plan: answer.plan, ...demand };
    // one that is stopped is followed by a newer one, and a plan that is wrong says so itself
    const found = await link.ask("timelines", fields, { lane: "timelines" }).promise.catch(() => null);
    if (found && store.get().answer === answer) {
      store.set({ timelines: Object.freeze({ ...found, answer, ...demand }) });
    }
  }

  store.on(["answer", "reach", "settings"], (state, before) => {
    if (!state.answer) store.set({ timelines: null });
    if (state.answer === before.answer && same(contactOf(state), contactOf(before))) return;
    clearTimeout(timer);
    timer = setTimeout(ask, QUIET);
  });
}

/**
 * Range and sight of the contact that is shown: that which the plan was asked to keep, else the one of the field
 * "show contact within".
 * @param {Record<string, any>} state
 * @returns {{reach: number | null, sight: boolean}}
 */
export function contactOf({ answer, reach }) {
  const claimed = answer?.plan?.claims?.contact;
  if (claimed) return { reach: claimed.range, sight: Boolean(claimed.sight) };
  return { reach: reach ?? null, sight: false };
}

/**
 * @param {{reach: number | null, sight: boolean}} one
 * @param {{reach: number | null, sight: boolean}} other
 */
function same(one, other) {
  return one.reach === other.reach && one.sight === other.sight;
}
