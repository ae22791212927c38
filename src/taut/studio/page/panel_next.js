// @ts-check
// What the tools for walls and robots make next, at the top of the tab Properties while they are in hand.

import { element } from "studio/dom.js";
import { createField } from "studio/panel_fields.js";
import { wallWidthOf } from "studio/tool_chains.js";

/**
 * @param {import("studio/store.js").Store} store
 * @returns {HTMLElement}
 */
export function createNext(store) {
  const metres = { type: /** @type {const} */ ("number"), unit: "m", step: 0.05 };
  const width = createField({ ...metres, name: "wall-width", label: "Wall width", above: 0 },
    (value) => store.set({ wallWidth: value }));
  const radius = createField({ ...metres, name: "robot-radius", label: "Robot radius", min: 0 },
    (value) => store.set({ robotRadius: value }));
  const legend = element("legend", {});
  const root = element("fieldset", { class: "group next" }, legend, width.node, radius.node);

  const show = () => {
    const { tool, scene, wallWidth, robotRadius } = store.get();
    root.hidden = tool !== "wall" && tool !== "robot";
    width.node.hidden = tool !== "wall";
    radius.node.hidden = tool !== "robot";
    legend.textContent = tool === "wall" ? "Next wall" : "Next robot";
    if (!scene || root.hidden) return;
    if (!width.edited()) width.show(wallWidthOf({ wallWidth, scene }));
    if (!radius.edited()) radius.show(robotRadius ?? scene.robots.at(-1)?.radius ?? 0.2);
  };
  store.on(["tool", "scene", "wallWidth", "robotRadius"], show);
  show();
  return root;
}
