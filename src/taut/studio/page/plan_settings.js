// @ts-check
// The controls of how to plan: method, order, roadmap, contact, budget, seed. Used by the Plan tab and the comparison.

import { element } from "studio/dom.js";
import { createField } from "studio/panel_fields.js";
import { applies } from "studio/planner_settings.js";

/**
 * @typedef {Record<string, any>} Settings
 * @typedef {import("studio/panel_fields.js").FieldSpec} FieldSpec
 * @typedef {{value?: () => any, put?: (chosen: any) => Settings, shown?: () => boolean}} Part where a setting is kept
 */

const METHODS = [
  { value: null, label: "Prioritized", about: "one robot after another; failed ones are moved to the front" },
  { value: "mrppa", label: "MRPPA", about: "the graph cut in two and bridged by λ2, then in order" },
  { value: "search", label: "Search for priorities", about: "priorities between pairs until all get through" },
  { value: "repair", label: "Repair", about: "a plan in order, then a few robots at a time planned anew" },
  { value: "optimal", label: "Optimal", about: "least cost on its roadmap, with a proven bound" },
];
const ORDERS = [
  { value: null, label: "Shortest way first" },
  { value: "longest", label: "Longest way first" },
  { value: "given", label: "As in the scene" },
];
const ROADMAPS = [
  { value: null, label: "Visibility graph" },
  { value: "voronoi", label: "Voronoi" },
  { value: "grid", label: "Grid" },
  { value: "prm", label: "PRM" },
  { value: "lazy-prm", label: "Lazy PRM" },
  { value: "cells", label: "Cells" },
  { value: "potential", label: "Potential field" },
  { value: "ca", label: "CA, central algorithm" },
  { value: "oca", label: "OCA, optimised CA" },
];
const OBJECTIVES = [
  { value: null, label: "Sum of costs" },
  { value: "makespan", label: "Makespan" },
];

/**
 * @param {{name: string, get: () => Settings, set: (settings: Settings) => void, watch: (fn: () => void) => unknown,
 *   compact?: boolean}} spec `name` tells several forms of a page apart; compact: one row, the rest under "More"
 * @returns {HTMLElement}
 */
export function createSettingsForm({ name, get, set, watch, compact = false }) {
  /** @type {{field: any, value: () => any, shown: () => boolean}[]} */
  const made = [];
  /** @param {FieldSpec} spec @param {Part} [part] */
  const add = (spec, part = {}) => {
    const { value = () => get()[spec.name] ?? null, put = (chosen) => ({ ...get(), [spec.name]: chosen }),
      shown = () => applies(get(), spec.name) } = part;
    const field = createField(spec, (chosen) => set(clean(put(chosen))));
    made.push({ field, value, shown });
    return field.node;
  };
  const contact = (/** @type {string} */ part, /** @type {any} */ none) => ({
    value: () => get().contact?.[part] ?? none,
    put: (/** @type {any} */ chosen) => ({ ...get(), contact: { ...get().contact, [part]: chosen } }),
    shown: () => applies(get(), "contact") && Boolean(get().contact),
  });
  const range = {
    value: () => get().contact?.range ?? null,
    put: (/** @type {number | null} */ metres) =>
      ({ ...get(), contact: metres === null ? null : { ...get().contact, range: metres } }),
  };
  const about = element("p", { class: "field-help" });

  const main = element("fieldset", { class: "group" },
    add({ name: "method", label: "Method", type: "select", options: METHODS }), about,
    add({ name: "order", label: "Order", type: "select", options: ORDERS }),
    add({ name: "roadmap", label: "Roadmap", type: "select", options: ROADMAPS }));
  const keep = element("fieldset", { class: "group" }, element("legend", {}, "Contact"),
    add({ name: "contact", label: "Range", type: "number", unit: "m", above: 0, optional: true,
      placeholder: "none", step: 0.5 }, range),
    add({ name: "sight", label: "Obstacles break contact", type: "checkbox" }, contact("sight", false)),
    add({ name: "k", label: "k", type: "number", whole: true, min: 1,
      help: "the team stays connected when any k − 1 robots fail" }, contact("k", 1)),
    add({ name: "lambda2", label: "λ2 at least", type: "number", min: 0, step: 0.1 }, contact("lambda2", 0)));
  const budget = element("fieldset", { class: "group" }, element("legend", {}, "Improve"),
    add({ name: "seconds", label: "Seconds", type: "number", unit: "s", above: 0, optional: true, placeholder: "10",
      step: 1 }),
    add({ name: "rounds", label: "Rounds", type: "number", whole: true, min: 1, max: 1000000, optional: true,
      placeholder: "until the time is over" }),
    add({ name: "objective", label: "Make least", type: "select", options: OBJECTIVES }),
    add({ name: "within", label: "Within a factor of", type: "number", min: 1, optional: true, placeholder: "1",
      step: 0.05 }),
    add({ name: "seed", label: "Seed", type: "number", whole: true, min: 0, max: Number.MAX_SAFE_INTEGER,
      optional: true, placeholder: "0" }));

  const show = () => {
    for (const { field, value, shown } of made) {
      field.node.hidden = !shown();
      if (!field.edited()) field.show(value());
    }
    about.textContent = METHODS.find(({ value }) => value === (get().method ?? null))?.about ?? "";
    keep.hidden = !applies(get(), "contact");
  };
  watch(show);
  show();
  const more = element("details", { class: "more", open: !compact }, element("summary", {}, "More"),
    element("div", {}, keep, budget));
  return element("form", { class: compact ? "settings compact" : "settings", "aria-label": `Settings: ${name}`,
    onsubmit: (/** @type {Event} */ event) => event.preventDefault() }, main, more);
}

/** @param {Settings} settings @returns {Settings} frozen, without what has its default */
function clean(settings) {
  const given = Object.entries(settings).filter(([, value]) => value !== null && value !== undefined);
  return Object.freeze(Object.fromEntries(given));
}
