// @ts-check
// The table of corners of a polygon, a wall or the workspace, in the tab Properties.

import { toast } from "studio/dialogs.js";
import { clear, element } from "studio/dom.js";
import { icon } from "studio/icons.js";
import { createField } from "studio/panel_fields.js";
import { cornerProperties, withCorner, withoutCorner } from "studio/panel_property_list.js";
import { called } from "studio/scene.js";

/** Rows that are made at a time: an outline of thousands of corners is opened in pages. */
const PAGE = 50;

/**
 * @param {import("studio/panel_property_list.js").Corners} corners
 * @param {{store: import("studio/store.js").Store, history: any}} page
 * @returns {{node: HTMLElement, show: (scene: any) => void}}
 */
export function createCorners({ ref, count, ring, fewest }, { store, history }) {
  const body = element("div", { class: "corners", role: "table", "aria-label": "Corners" });
  /** @type {{property: any, field: any}[]} */
  let fields = [];
  let first = 0;

  const attempt = (/** @type {string} */ label, /** @type {() => any} */ edit) => {
    try {
      history.change(label, edit());
      return null;
    } catch (error) {
      return /** @type {Error} */ (error).message;
    }
  };

  const row = (/** @type {number} */ vertex) => {
    const corner = { ...ref, vertex };
    const cells = cornerProperties(corner).map((property) => {
      const field = createField({ ...property.spec, value: property.get(store.get().scene) }, (value) =>
        attempt(property.label(store.get().scene, value), () => property.set(store.get().scene, value)));
      field.input.addEventListener("focus", () => store.set({ selection: Object.freeze([corner]) }));
      fields.push({ property, field });
      return element("div", { role: "cell" }, field.node);
    });
    const act = (/** @type {string} */ picture, /** @type {string} */ label, /** @type {boolean} */ off,
      /** @type {() => any} */ edit) =>
      element("button", { type: "button", class: "button ghost square small", title: label, disabled: off,
        "aria-label": `${label} ${vertex + 1}`, onclick: () => {
          const wrong = attempt(`${label.toLowerCase()} of ${called(store.get().scene, [ref])}`, edit);
          if (wrong) toast(wrong, { kind: "bad", seconds: 6 });
        } }, icon(picture, 14));
    return element("div", { class: "corner", role: "row", "data-vertex": vertex },
      element("span", { class: "quiet number", role: "rowheader" }, String(vertex + 1)), ...cells,
      act("plus", "Add a corner after corner", !ring && vertex === count - 1,
        () => withCorner(store.get().scene, corner)),
      act("minus", "Remove corner", count <= fewest, () => withoutCorner(store.get().scene, corner)));
  };

  const turn = () => {
    clear(body);
    fields = [];
    const last = Math.min(count, first + PAGE);
    for (let vertex = first; vertex < last; vertex++) body.append(row(vertex));
  };
  turn();

  const pages = count <= PAGE ? null : element("div", { class: "row" },
    ...[["previous", "Corners before", -PAGE], ["next", "Corners after", PAGE]].map(([picture, label, by]) =>
      element("button", { type: "button", class: "button ghost square small", "aria-label": label, title: label,
        onclick: () => {
          first = Math.min(Math.max(0, first + Number(by)), Math.floor((count - 1) / PAGE) * PAGE);
          said.textContent = range();
          turn();
        } }, icon(String(picture), 14))));
  const range = () => `${first + 1} to ${Math.min(count, first + PAGE)} of ${count}`;
  const said = element("span", { class: "quiet number" }, count > PAGE ? range() : "");
  pages?.append(said);

  return {
    node: element("details", { class: "group", open: count <= 12 },
      element("summary", {}, `Corners (${count})`), ...(pages ? [pages] : []), body),
    show(scene) {
      const { selection } = store.get();
      const chosen = selection.length === 1 ? selection[0].vertex : undefined;
      [...body.children].forEach((line, k) => line.classList.toggle("chosen", first + k === chosen));
      for (const { property, field } of fields) if (!field.edited()) field.show(property.get(scene));
    },
  };
}
