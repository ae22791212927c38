// @ts-check
// The line at the bottom: where the pointer is, what the tool expects, how planning stands, how the server is.

import { element } from "studio/dom.js";
import { icon } from "studio/icons.js";

const SERVER_WORDS = /** @type {Record<string, string>} */ ({
  connecting: "connecting…", warming: "warming up kernels…", ready: "ready", restarting: "restarting a worker…",
  gone: "server gone",
});

const CLOCK = new Intl.DateTimeFormat("en-GB", { hour: "2-digit", minute: "2-digit" });

/**
 * Fill the status line.
 * @param {HTMLElement} root
 * @param {import("studio/store.js").Store} store
 */
export function createStatus(root, store) {
  const coordinates = element("span", { class: "coordinates number" });
  const said = element("span", { class: "said" });
  const planning = element("span", { id: "planning", class: "pill number" });
  const saved = element("span", { class: "pill" });
  const server = element("span", { id: "server", class: "pill" });
  root.append(coordinates, said, saved, planning, server);

  store.on(["pointer"], ({ pointer }) => {
    coordinates.textContent = pointer ? `${metres(pointer[0])}, ${metres(pointer[1])} m` : "";
  });
  store.on(["said", "snap", "selection", "tool"], ({ said: words, snap, selection }) => {
    const chosen = selection.length > 1 ? `${selection.length} selected` : "";
    said.textContent = words || chosen || (snap.grid ? "Snapping to the grid" : "");
  });
  store.on(["planning", "answer", "server"], showPlanning);
  store.on(["saved"], (state) => {
    const wrong = state.saved?.wrong;
    saved.className = `pill ${wrong ? "bad" : ""}`;
    saved.textContent = wrong ?? (state.saved?.time ? `draft kept ${clock(state.saved.time)}` : "");
  });
  store.on(["server"], ({ server: { state } }) => {
    server.className = `pill ${state === "gone" ? "bad" : state === "ready" ? "" : "warn"}`;
    server.replaceChildren(state === "ready" ? "" : dot(), SERVER_WORDS[state] ?? state);
  });
  showPlanning(store.get());

  /** @param {import("studio/store.js").State} state */
  function showPlanning({ planning: now, answer, server: { state } }) {
    const [look, ...parts] = wordsOf(now, answer, state);
    planning.className = `pill number ${look}`;
    planning.dataset.state = now.state;
    planning.replaceChildren(...parts);
  }
}

/**
 * @param {any} planning @param {any} answer @param {string} server
 * @returns {[string, ...(Node | string)[]]} a look and what to show
 */
function wordsOf({ state, running, seconds, progress, improving }, answer, server) {
  if (improving && running) return ["", dot(), progress?.text ?? "improving…"];
  if (running && !answer && state !== "failed") {
    return ["", dot(), server === "ready" ? (progress?.text ?? "planning…") : "waiting for the planner…"];
  }
  switch (state) {
    case "planning":
    case "fresh": {
      if (!answer) return ["", ""];
      const took = seconds === null || seconds === undefined ? "from file" : duration(seconds);
      const ok = answer.certificate?.ok;
      return [ok ? "good" : answer.certificate ? "bad" : "", ok ? icon("check", 14) : "",
        `${ok ? "certified" : answer.certificate ? "not certified" : "plan"} · ${took}`];
    }
    case "stale": return running ? ["warn", dot(), progress?.text ?? "planning, the last plan is shown…"]
      : ["warn", "the plan is stale"];
    case "failed": return ["bad", icon("warn", 14), "no plan"];
    default: return ["", ""];
  }
}

const dot = () => element("span", { class: "dot-run" });

/** @param {number} seconds */
export const duration = (seconds) =>
  seconds < 1 ? `${Math.round(seconds * 1000)} ms` : `${seconds.toFixed(seconds < 100 ? 1 : 0)} s`;

/** @param {number} value */
const metres = (value) => {
  const size = Math.abs(value);
  return value.toFixed(size >= 1000 ? 1 : size >= 0.1 || size === 0 ? 2 : 5).replace("-", "−");
};

/** @param {number | string | Date} time */
const clock = (time) => CLOCK.format(new Date(time));
