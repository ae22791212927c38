// @ts-check
// The strip that tells when the server is gone, and what to do.

import { announce } from "studio/announce.js";
import { clear, element } from "studio/dom.js";
import { icon } from "studio/icons.js";

/** A short break, as when a laptop wakes, is not worth a word. */
const PATIENCE = 800;

/**
 * @param {HTMLElement} root
 * @param {{store: import("studio/store.js").Store, link: import("studio/link.js").Link, drafts: any}} page
 */
export function showBanner(root, { store, link, drafts }) {
  let timer = 0;
  let shown = "";

  store.on(["server"], ({ server: { state, refused, message } }) => {
    clearTimeout(timer);
    const want = state === "gone" ? (refused ? "new" : message || "gone") : "";
    if (want === shown) return;
    timer = setTimeout(() => show(want), want && !shown ? PATIENCE : 0);
  });

  /** @param {string} want */
  function show(want) {
    const was = shown;
    shown = want;
    clear(root);
    if (!want) {
      if (was) announce("The server is back.");
      return;
    }
    drafts.flush();
    root.append(icon("warn", 18), element("span", {}, ...wordsOf(want)),
      element("button", { type: "button", class: "button small", onclick: () => link.retry() }, "Try now"));
    announce(root.textContent ?? "", { urgent: true });
  }
}

/**
 * What is told: "new" and "gone" are known here, everything else is the sentence with which the server closed.
 * @param {string} want
 */
function wordsOf(want) {
  const command = element("code", {}, "taut studio");
  if (want === "gone") return ["Server gone: your work is kept in this browser; start ", command, " again."];
  if (want !== "new") return [`The server closed the link: ${want}.`];
  return ["The studio was started anew and has a new address. Your work is kept in this browser: open the address that ",
    command, " printed, and it is offered there."];
}
