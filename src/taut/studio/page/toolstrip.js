// @ts-check
// The strip of tools at the left, what points snap to, and the buttons that zoom.

import { menuButton } from "studio/dialogs.js";
import { element } from "studio/dom.js";
import { icon } from "studio/icons.js";

const SNAPS = [["grid", "Grid"], ["vertex", "Corners"], ["edge", "Edges"], ["angle", "Angles of 15° with Shift"]];

/**
 * @param {{store: import("studio/store.js").Store, commands: any}} page
 * @param {readonly {name: string, title: string, key?: string}[]} tools
 * @returns {HTMLElement[]}
 */
export function createToolstrip({ store, commands }, tools) {
  const buttons = tools.map(({ name, title, key }) => {
    const words = key ? `${title} (${key.toUpperCase()})` : title;
    return element("button", { type: "button", class: "button tool", "data-tool": name, title: words,
      "aria-label": words, onclick: () => commands.tool(name) }, icon(name, 20));
  });
  const show = () => {
    const { tool, mode } = store.get();
    for (const button of buttons) {
      button.setAttribute("aria-pressed", String(button.dataset.tool === tool));
      button.toggleAttribute("disabled", mode === "compare");
    }
  };
  store.on(["tool", "mode"], show);
  show();
  const snap = menuButton({ id: "snap", label: "Snapping", class: "button tool", content: [icon("snap", 20)],
    items: () => SNAPS.map(([name, label]) => ({ label, checked: Boolean(store.get().snap[name]),
      run: () => commands.toggleSnap(name) })) });
  return [...buttons, element("hr", {}), snap];
}

/** @param {{commands: any}} page @returns {HTMLElement} */
export function createZoom({ commands }) {
  const button = (/** @type {string} */ picture, /** @type {string} */ label, /** @type {() => void} */ run) =>
    element("button", { type: "button", class: "button ghost square small", title: label, "aria-label": label,
      onclick: run }, icon(picture, 16));
  return element("div", { class: "zoom", role: "group", "aria-label": "Zoom" },
    button("minus", "Zoom out (−)", () => commands.zoom(0.8)),
    button("plus", "Zoom in (+)", () => commands.zoom(1.25)),
    button("fit", "Show everything (0)", () => commands.fit()));
}
