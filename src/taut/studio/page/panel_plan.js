// @ts-check
// The tab Plan: how to plan, Improve and Stop, and what came of it.

import { element } from "studio/dom.js";
import { icon } from "studio/icons.js";
import { createField } from "studio/panel_fields.js";
import { createResult } from "studio/panel_result.js";
import { createSettingsForm } from "studio/plan_settings.js";
import { IMPROVE_SECONDS } from "studio/planner_settings.js";

/**
 * @param {any} page
 * @returns {HTMLElement}
 */
export function createPlanPanel(page) {
  const { store, planner } = page;
  const improve = element("button", { id: "improve", type: "button", class: "button primary",
    onclick: planner.improve }, icon("sparkle", 16), "Improve");
  const stop = element("button", { id: "stop", type: "button", class: "button", onclick: planner.stop },
    icon("stop", 16), "Stop");
  const words = element("p", { class: "field-help" });
  const progress = element("p", { class: "progress number", role: "status" });

  const show = () => {
    const { planning, settings, scene } = store.get();
    const long = settings.method === "repair" || settings.method === "optimal";
    const budget = settings.rounds ? `${settings.rounds} rounds` : `${settings.seconds ?? IMPROVE_SECONDS} s`;
    words.textContent = long ? `While you draw, the quick method plans. Improve runs the chosen one for ${budget}.`
      : `Improve spends ${budget} on a better plan.`;
    improve.toggleAttribute("disabled", !scene?.robots.length || (planning.running && planning.improving));
    stop.toggleAttribute("disabled", !planning.running);
    progress.hidden = !(planning.running && planning.progress);
    progress.textContent = planning.progress?.text ?? "";
  };
  store.on(["planning", "settings", "scene"], show);
  show();
  const form = createSettingsForm({
    name: "plan",
    get: () => store.get().settings,
    set: (settings) => store.set({ settings }),
    watch: (fn) => store.on(["settings"], fn),
  });
  const reach = createField({ name: "reach", label: "Show links within", type: "number", unit: "m", above: 0,
    optional: true, step: 0.5, placeholder: "not shown" }, (value) => store.set({ reach: value }));
  store.on(["reach", "answer"], () => {
    reach.show(store.get().reach);
    reach.node.hidden = Boolean(store.get().answer?.plan.claims?.contact);
  });
  return element("div", { class: "plan-tab" }, createResult(page),
    element("div", { class: "group" }, element("div", { class: "row" }, improve, stop), progress, words),
    element("details", { class: "how", open: true }, element("summary", {}, "How to plan"), form),
    element("div", { class: "group" }, reach.node));
}
