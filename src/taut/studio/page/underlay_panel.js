// @ts-check
// The fields of the picture under the scene.

import { clear, element } from "studio/dom.js";
import { createField } from "studio/panel_fields.js";
import { boxOfScene } from "studio/scene.js";
import { underlayFromFile } from "studio/underlay.js";

/**
 * The part of the panel that shows the picture: a button to choose one, or its fields.
 * @param {{store: import("./store.js").Store, history: import("./history.js").History,
 *   dialogs: typeof import("./dialogs.js")}} page
 * @returns {HTMLElement}
 */
export function underlayPanel({ store, history, dialogs }) {
  const root = element("section", { class: "card", "aria-label": "Floor plan picture" });
  const change = (/** @type {string} */ label, /** @type {any} */ patch) => {
    const { underlay } = store.get();
    if (underlay) history.changeUnderlay(label, { ...underlay, ...patch });
  };

  const choose = () => {
    const input = /** @type {HTMLInputElement} */ (element("input", { type: "file", accept: "image/*" }));
    input.addEventListener("change", () => input.files?.[0] && layUnder(input.files[0], { store, history, dialogs }));
    input.click();
  };

  const fields = () => {
    const number = (/** @type {any} */ spec, /** @type {string} */ label) =>
      createField({ type: "number", unit: "m", ...spec }, (value) => change(label, { [spec.name]: value }));
    const x = number({ name: "x", label: "Left" }, "move the picture");
    const y = number({ name: "y", label: "Bottom" }, "move the picture");
    const width = createField({ name: "width", label: "Width", type: "number", unit: "m", above: 0 }, (value) => {
      const { underlay } = store.get();
      if (underlay) change("scale the picture", { scale: value / underlay.pixels[0] });
    });
    const opacity = createField({ name: "opacity", label: "Strength", type: "range", min: 0.05, max: 1, step: 0.05 },
      (value) => change("strength of the picture", { opacity: value }));
    const locked = createField({ name: "locked", label: "Locked in place", type: "checkbox" },
      (value) => change(value ? "lock the picture" : "unlock the picture", { locked: value }));
    return { x, y, width, opacity, locked };
  };

  /** @type {ReturnType<typeof fields> | null} */
  let made = null;
  const title = element("p", { class: "quiet" });
  const tool = (/** @type {string} */ name, /** @type {string} */ label) =>
    element("button", { type: "button", class: "button", onclick: () => store.set({ tool: name }) }, label);
  const move = tool("underlay-move", "Move");
  const scale = tool("underlay-scale", "Set scale by two points…");
  const remove = element("button", { type: "button", class: "button",
    onclick: () => history.changeUnderlay("remove the picture", null) }, "Remove");

  const show = () => {
    const { underlay } = store.get();
    if (!underlay) {
      made = null;
      clear(root);
      root.append(element("h3", {}, "Picture"),
        element("p", { class: "quiet" }, "Lay a floor plan under the scene, to draw over it."),
        element("button", { type: "button", class: "button", id: "underlay", onclick: choose }, "Choose a picture…"));
      return;
    }
    if (!made) {
      made = fields();
      clear(root);
      root.append(element("h3", {}, "Picture"), title, ...Object.values(made).map(({ node }) => node),
        element("div", { class: "row" }, scale), element("div", { class: "row" }, move, remove));
    }
    title.textContent = `${underlay.name}, ${underlay.pixels.join(" × ")} pixels`;
    made.x.show(underlay.x);
    made.y.show(underlay.y);
    made.width.show(underlay.scale * underlay.pixels[0]);
    made.opacity.show(underlay.opacity);
    made.locked.show(underlay.locked);
    for (const { input } of [made.x, made.y, made.width]) input.disabled = underlay.locked;
    for (const button of [move, scale]) /** @type {HTMLButtonElement} */ (button).disabled = underlay.locked;
  };
  store.on(["underlay"], show);
  show();
  return root;
}

/**
 * Lay a picture under the scene and say how to put it to scale.
 * @param {File} file
 * @param {{store: import("./store.js").Store, history: import("./history.js").History,
 *   dialogs: typeof import("./dialogs.js")}} page
 */
export async function layUnder(file, { store, history, dialogs }) {
  try {
    const underlay = await underlayFromFile(file, boxOfScene(store.get().scene));
    history.changeUnderlay("lay a picture under", underlay);
    dialogs.toast(`${file.name} lies under the scene.`, {
      action: { label: "Set its scale", run: () => store.set({ tool: "underlay-scale" }) },
    });
  } catch (error) {
    dialogs.toast(/** @type {Error} */ (error).message, { kind: "bad" });
  }
}
