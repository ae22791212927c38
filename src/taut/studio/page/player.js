// @ts-check
// The clock of the studio: play, pause, seek, speed and loop over the time of the plan on show.

import { makespanOf, motionsOf } from "studio/motion.js";

/** Seconds shown after the last arrival before it stops or begins anew. */
const REST = 0.6;

/**
 * Run the clock of a store: its key `time` is {now, playing, speed, loop}.
 * @param {import("studio/store.js").Store} store
 * @param {() => number} [until] end of time, seconds; by default the makespan of `answer`
 */
export function createPlayer(store, until = () => endOf(store.get().answer)) {
  let before = 0;
  let frame = 0;

  /** @param {Record<string, any>} patch */
  const change = (patch) => store.set({ time: Object.freeze({ ...store.get().time, ...patch }) });

  /** @param {number} stamp milliseconds */
  function tick(stamp) {
    const { now, playing, speed, loop } = store.get().time;
    if (!playing) return;
    const end = until();
    const next = now + (speed * Math.min(stamp - before, 100)) / 1000;
    before = stamp;
    if (next < end + REST * speed) change({ now: next });
    else if (loop && end > 0) change({ now: 0 });
    else change({ now: end, playing: false });
    frame = requestAnimationFrame(tick);
  }

  return {
    until,

    play() {
      if (store.get().time.playing) return;
      before = performance.now();
      const { now } = store.get().time;
      change({ playing: true, now: now >= until() ? 0 : now });
      frame = requestAnimationFrame(tick);
    },

    pause() {
      cancelAnimationFrame(frame);
      change({ playing: false });
    },

    toggle() {
      if (store.get().time.playing) this.pause();
      else this.play();
    },

    /** @param {number} time seconds */
    seek: (time) => change({ now: Math.min(Math.max(time, 0), until()) }),

    /** @param {number} speed seconds of the plan a second */
    setSpeed: (speed) => change({ speed }),

    /** @param {boolean} loop */
    setLoop: (loop) => change({ loop }),
  };
}

/** @typedef {ReturnType<typeof createPlayer>} Player */

/**
 * @param {any} answer
 * @returns {number}
 */
export function endOf(answer) {
  return answer ? makespanOf(motionsOf(answer)) : 0;
}
