// @ts-check
// One kind of work for the newest state only: at most one ask under way and one waiting.

import { Stopped } from "studio/link.js";

/**
 * Milliseconds that an ask may take before a newer one is sent regardless. The server then ends the older, which may cost
 * it a worker: one that will soon be done, as far as the last one tells, is waited for longer.
 */
const [PATIENCE, LONGEST_PATIENCE] = [250, 1000];

/**
 * `start` sends the ask for the state as it is now; `done` gets each answer, `failed` each thing found wrong. An ask
 * that a newer one ended says nothing; one that was cancelled or lost says so to `ended`.
 * @param {{start: () => import("studio/link.js").Asked, done: (ok: any, asked: any) => void,
 *   failed: (error: any, asked: any) => void, ended?: (reason: string) => void}} work
 */
export function newestOnly({ start, done, failed, ended = () => {} }) {
  /** @type {{asked: import("studio/link.js").Asked, at: number} | null} */
  let flight = null;
  let waiting = false;
  let timer = 0;
  let lately = 0; // milliseconds that the last answer took

  function want() {
    clearTimeout(timer);
    if (!flight) return go();
    waiting = true;
    const patience = Math.min(Math.max(PATIENCE, 1.5 * lately), LONGEST_PATIENCE);
    timer = setTimeout(go, Math.max(0, flight.at + patience - performance.now()));
    return undefined;
  }

  function go() {
    clearTimeout(timer);
    waiting = false;
    const asked = start();
    const mine = { asked, at: performance.now() };
    flight = mine;
    const land = (/** @type {() => void} */ tell) => {
      const newest = flight === mine;
      if (newest) flight = null;
      tell();
      // The answer of an ask that was overtaken is older than what is under way, but newer than what is shown.
      if (newest && waiting) go();
    };
    asked.promise.then(
      (ok) => land(() => {
        lately = performance.now() - mine.at;
        done(ok, asked);
      }),
      (error) => land(() => {
        if (!(error instanceof Stopped)) failed(error, asked);
        else if (error.reason !== "newer") ended(error.reason);
      }),
    );
  }

  return {
    want,
    running: () => flight !== null,
    /** Give up what is under way and what waits. */
    cancel() {
      clearTimeout(timer);
      waiting = false;
      flight?.asked.cancel();
    },
    /** Be content with the best that what is under way has so far. */
    finish() {
      clearTimeout(timer);
      waiting = false;
      flight?.asked.finish();
    },
  };
}
