// @ts-check
// The tab Properties: fields of what is selected, of the scene when nothing is.

import { createCorners } from "studio/panel_corners.js";
import { clear, element } from "studio/dom.js";
import { icon } from "studio/icons.js";
import { createField } from "studio/panel_fields.js";
import { propertiesOf, signatureOf, things } from "studio/panel_property_list.js";

/**
 * @param {{store: import("studio/store.js").Store, history: any, commands: any}} page
 * @param {HTMLElement} underlay the fields of the image under the scene
 * @returns {HTMLElement}
 */
export function createProperties({ store, history, commands }, underlay) {
  const root = element("div", { class: "properties" });
  /** @type {{property: any, field: any}[]} */
  let shown = [];
  let showCorners = (/** @type {any} */ _) => {};
  let signature = "";
  let frame = 0;

  const commit = (/** @type {any} */ property) => (/** @type {any} */ value) => {
    try {
      const { scene } = store.get();
      const next = property.set(scene, value);
      const label = property.label(scene, value);
      const selection = property.select?.(value);
      if (next !== scene) history.change(label, next, selection ? { selection } : undefined);
      return null;
    } catch (error) {
      return /** @type {Error} */ (error).message;
    }
  };

  function build() {
    const { scene, selection } = store.get();
    const { title, groups, corners } = propertiesOf(scene, selection);
    shown = [];
    showCorners = () => {};
    clear(root);
    root.append(heading(title, selection.length > 0 && things(selection).every(({ kind }) => kind !== "workspace")));
    for (const group of groups) {
      const fields = group.properties.map((property) => {
        const field = createField({ ...property.spec, value: property.get(scene) }, commit(property));
        shown.push({ property, field });
        return field.node;
      });
      root.append(element("fieldset", { class: pairs(group) ? "group pairs" : "group" },
        group.title ? element("legend", {}, group.title) : null, ...fields));
    }
    if (corners) {
      const made = createCorners(corners, { store, history });
      root.append(made.node);
      showCorners = made.show;
    }
    if (things(selection).length > 1 && groups.length === 0) {
      root.append(element("p", { class: "quiet" },
        "These have no field in common. They can be moved, turned, duplicated and deleted together."));
    }
    if (selection.length === 0) root.append(underlay);
  }

  function refresh() {
    frame = 0;
    const { scene, selection } = store.get();
    if (!scene) return;
    const now = signatureOf(scene, selection);
    if (now !== signature) {
      signature = now;
      build();
    }
    for (const { property, field } of shown) {
      if (field.edited()) continue;
      const mixed = property.mixed?.(scene) ?? false;
      field.show(property.get(scene), mixed ? { placeholder: "different" } : {});
    }
    showCorners(scene);
  }

  // Once a frame: a drag changes the scene more often than anybody can read.
  const later = () => {
    frame ||= requestAnimationFrame(refresh);
  };
  store.on(["scene", "selection"], later);
  later();

  /** @param {string} title @param {boolean} editable */
  function heading(title, editable) {
    const act = (/** @type {string} */ picture, /** @type {string} */ label, /** @type {() => void} */ run) =>
      element("button", { type: "button", class: "button ghost square small", title: label, "aria-label": label,
        onclick: run }, icon(picture, 16));
    return element("div", { class: "panel-head" }, element("h2", {}, title),
      ...(editable ? [act("fit", "Show it (Shift 0)", commands.fitSelection),
        act("duplicate", "Duplicate", commands.duplicate), act("trash", "Delete", commands.remove)] : []));
  }
  return root;
}

/** Whether the fields of a group stand two in a row. */
const pairs = (/** @type {any} */ { title, properties }) =>
  /^(Start|Goal|Position|Centre|Bounds|Size)$/.test(title) && properties.length > 1;
