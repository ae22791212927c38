// @ts-check
// The bar under the board that rules time: play, scrub, speed, loop, and the clock.

import { element } from "studio/dom.js";
import { icon } from "studio/icons.js";

/** Pixels left of the slider and right of it: buttons here, names and arrivals in the timelines on the same axis. */
export const LEFT = 158;
export const RIGHT = 148;
/** Below this height of the window, in pixels, the board gets the room of the timelines until somebody unfolds them. */
const LOW = 700;

/** Speeds offered, seconds of the plan a second. */
export const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10, 25];

/**
 * @param {import("studio/store.js").Store} store
 * @param {import("studio/player.js").Player} player
 * @returns {HTMLElement}
 */
export function createTimebar(store, player) {
  const play = element("button", { id: "play", class: "button square", type: "button", onclick: () => player.toggle() });
  const scrub = /** @type {HTMLInputElement} */ (
    element("input", { id: "scrub", type: "range", min: 0, step: "any", "aria-label": "Time", oninput: seek })
  );
  const speed = /** @type {HTMLSelectElement} */ (
    element("select", { id: "speed", "aria-label": "Speed", onchange: () => player.setSpeed(Number(speed.value)) },
      ...SPEEDS.map((factor) => element("option", { value: factor }, `${factor}×`)))
  );
  const loop = element("button", { id: "loop", class: "button square", type: "button", title: "Loop (L)", "aria-label": "Loop",
    onclick: () => player.setLoop(!store.get().time.loop) }, icon("loop"));
  const fold = element("button", { id: "fold", class: "button square ghost", type: "button",
    "aria-controls": "timelines", onclick: toggleFold }, icon("down"));
  let chosen = false;
  const clock = element("output", { id: "clock", class: "number", for: "scrub" });

  function seek() {
    player.pause();
    player.seek(Number(scrub.value));
  }

  function toggleFold() {
    chosen = true;
    store.set({ folded: !store.get().folded });
  }

  /** Until somebody says otherwise. */
  function foldIfLow() {
    if (!chosen) store.set({ folded: innerHeight < LOW });
  }

  function showFold() {
    const folded = Boolean(store.get().folded);
    fold.setAttribute("aria-expanded", String(!folded));
    fold.setAttribute("aria-label", folded ? "Show the timelines" : "Fold the timelines");
    fold.title = folded ? "Show the timelines" : "Fold the timelines";
  }

  function show() {
    const { now, playing, speed: factor, loop: looping } = store.get().time;
    const end = player.until();
    const shown = Math.min(now, end);
    if (play.dataset.playing !== String(playing)) {
      play.dataset.playing = String(playing);
      play.replaceChildren(icon(playing ? "pause" : "play"));
      play.title = playing ? "Pause (Space)" : "Play (Space)";
      play.setAttribute("aria-label", playing ? "Pause" : "Play");
    }
    scrub.max = String(end);
    scrub.value = String(shown);
    scrub.setAttribute("aria-valuetext", `${shown.toFixed(2)} of ${end.toFixed(2)} seconds`);
    scrub.style.setProperty("--share", end > 0 ? `${(100 * shown) / end}%` : "0%");
    clock.textContent = `${shown.toFixed(2)} / ${end.toFixed(2)} s`;
    speed.value = String(factor);
    loop.setAttribute("aria-pressed", String(looping));
    for (const control of [play, scrub, speed, loop]) control.toggleAttribute("disabled", end <= 0);
  }

  store.on(["time", "answer", "compared", "mode"], show);
  store.on(["folded"], showFold);
  window.addEventListener("resize", foldIfLow);
  foldIfLow();
  showFold();
  show();
  const bar = element("div", { class: "timebar", role: "group", "aria-label": "Time" },
    element("div", { class: "timebar-start" }, play, loop, speed), scrub,
    element("div", { class: "timebar-end" }, clock, fold));
  bar.style.setProperty("--left", `${LEFT}px`);
  bar.style.setProperty("--right", `${RIGHT}px`);
  return bar;
}
