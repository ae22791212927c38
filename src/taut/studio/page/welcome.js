// @ts-check
// What an empty scene says: how to begin.

import { element } from "studio/dom.js";
import { icon } from "studio/icons.js";

/**
 * Fill the middle of the board while there is nothing on it and nothing is being drawn.
 * @param {HTMLElement} root
 * @param {{store: import("studio/store.js").Store, files: any, commands: any}} page
 */
export function createWelcome(root, { store, files, commands }) {
  const button = (/** @type {string} */ picture, /** @type {string} */ label, /** @type {() => void} */ run) =>
    element("button", { type: "button", class: "button", onclick: run }, icon(picture, 16), label);
  const card = element("section", { class: "welcome", "aria-label": "How to begin" },
    element("h2", {}, "An empty floor"),
    element("p", {}, "Draw obstacles, put in robots, and the team plans itself while you draw."),
    element("div", { class: "row" },
      button("rectangle", "Draw", () => commands.tool("rectangle")),
      button("file", "Ready scenes", () => files.ready()),
      button("dice", "Random scene", () => files.random()),
      button("open", "Open", () => files.open())));

  const show = () => {
    const { scene, tool, mode, underlay } = store.get();
    const empty = scene !== null && scene.obstacles.length + scene.robots.length === 0 && underlay === null;
    const wanted = empty && tool === "select" && mode === "edit";
    if (wanted !== card.isConnected) wanted ? root.append(card) : card.remove();
  };
  store.on(["scene", "tool", "mode", "underlay"], show);
  show();
}
