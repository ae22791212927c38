// @ts-check
// The bar under the board that rules time: play, scrub, speed, loop, and the clock.

import { element } from "studio/dom.js";
import { icon } from "studio/icons.js";

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
  const clock = element("output", { id: "clock", class: "number", for: "scrub" });

  function seek() {
    player.pause();
    player.seek(Number(scrub.value));
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
  show();
  return element("div", { class: "timebar", role: "group", "aria-label": "Time" }, play, scrub, clock, speed, loop);
}
