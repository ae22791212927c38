// @ts-check
// The panel at the right: tabs Properties, Objects and Plan; the stepper in the mode for steps.

import { element } from "studio/dom.js";
import { createNext } from "studio/panel_next.js";
import { createObjects } from "studio/panel_objects.js";
import { createPlanPanel } from "studio/panel_plan.js";
import { createProperties } from "studio/panel_properties.js";
import { underlayPanel } from "studio/underlay_panel.js";

/**
 * @param {any} page
 * @param {HTMLElement} stepper
 * @returns {HTMLElement[]}
 */
export function createPanels(page, stepper) {
  const { store } = page;
  const tabs = [
    { name: "properties", label: "Properties",
      parts: [createNext(store), createProperties(page, underlayPanel(page))] },
    { name: "objects", label: "Objects", parts: [createObjects(page)] },
    { name: "plan", label: "Plan", parts: [createPlanPanel(page)] },
  ].map((tab) => ({
    ...tab,
    button: element("button", { type: "button", role: "tab", id: `tab-${tab.name}`, "aria-controls": `body-${tab.name}`,
      "data-tab": tab.name, onclick: () => store.set({ tab: tab.name }), onkeydown: walk }, tab.label),
    pane: element("div", { role: "tabpanel", id: `body-${tab.name}`, class: "pane",
      "aria-labelledby": `tab-${tab.name}` }, ...tab.parts),
  }));
  const strip = element("div", { class: "tabs segmented", role: "tablist", "aria-label": "Panel" },
    ...tabs.map(({ button }) => button));
  const steps = element("div", { class: "pane" }, stepper);

  /** @param {KeyboardEvent} event */
  function walk(event) {
    const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!by) return;
    const here = tabs.findIndex(({ button }) => button === event.currentTarget);
    const to = tabs[(here + by + tabs.length) % tabs.length];
    store.set({ tab: to.name });
    to.button.focus();
  }

  function show() {
    const { tab, mode, problems } = store.get();
    strip.hidden = mode !== "edit";
    steps.hidden = mode !== "steps";
    for (const { name, button, pane } of tabs) {
      button.setAttribute("aria-selected", String(name === tab));
      button.tabIndex = name === tab ? 0 : -1;
      button.classList.toggle("troubled", name === "plan" && problems.length > 0);
      pane.hidden = mode !== "edit" || name !== tab;
    }
  }
  store.on(["tab", "mode", "problems"], show);
  show();
  return [strip, ...tabs.map(({ pane }) => pane), steps];
}
