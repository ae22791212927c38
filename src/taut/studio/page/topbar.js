// @ts-check
// The bar at the top: file, undo and redo, modes, view, export, theme, help.

import { menuButton } from "studio/dialogs.js";
import { element } from "studio/dom.js";
import { icon } from "studio/icons.js";
import { keyText } from "studio/keys.js";

const MODES = [
  { name: "edit", label: "Edit", title: "Draw the map and watch the team plan itself (1)" },
  { name: "steps", label: "Steps", title: "Go through a method step by step (2)" },
  { name: "compare", label: "Compare", title: "Two methods side by side (3)" },
];
const SHOWN = [
  ["grid", "Grid"], ["labels", "Names"], ["routes", "Routes"], ["trails", "Trails"], ["conflicts", "Conflicts"],
  ["contact", "Contact links"],
];
const THEME_WORDS = /** @type {Record<string, string>} */ ({ system: "as the system", light: "light", dark: "dark" });

/**
 * @param {{store: import("studio/store.js").Store, commands: any, files: any}} page
 * @returns {HTMLElement[]}
 */
export function createTopbar({ store, commands, files }) {
  const undo = button("undo", "Undo", commands.undo, "undo");
  const redo = button("redo", "Redo", commands.redo, "redo");
  const save = button("save", `Save (${keyText("mod+s")})`, () => files.save(), "save");
  const open = button("open", `Open (${keyText("mod+o")})`, () => files.open(), "open");
  const theme = button("theme", "Theme", commands.nextTheme, "system");
  const help = button("help", "Keys and help (?)", commands.help, "help");
  const out = element("button", { id: "out", type: "button", class: "button", "aria-label": "Export", title: `Export (${keyText("mod+e")})`,
    onclick: commands.out }, icon("out", 16), element("span", { class: "button-words" }, "Export"));
  const name = element("b", {});
  const dot = element("span", { class: "dot", role: "img", "aria-label": "not saved", title: "Not saved" });
  const modes = MODES.map((mode) => element("button", { type: "button", "data-mode": mode.name, title: mode.title,
    onclick: () => commands.mode(mode.name) }, mode.label));

  store.on(["file", "history", "mode", "theme", "themeChoice"], show);
  show();

  function show() {
    const { file, history, mode, theme: shown, themeChoice } = store.get();
    name.textContent = file?.name || "Untitled";
    name.title = file?.path ?? "Not on disk yet";
    dot.hidden = !file?.dirty;
    document.title = `${file?.dirty ? "• " : ""}${name.textContent} – taut studio`;
    step(undo, "undo", history.undo, "mod+z");
    step(redo, "redo", history.redo, "mod+shift+z");
    for (const each of modes) each.setAttribute("aria-pressed", String(each.dataset.mode === mode));
    theme.replaceChildren(icon(themeChoice === "system" ? "system" : shown));
    state(theme, true, `Theme: ${THEME_WORDS[themeChoice]}`);
  }

  const start = element("div", {},
    element("span", { class: "brand" }, icon("brand", 20), element("span", { class: "only-wide" }, "taut studio")),
    menuButton({ id: "file-menu", label: "File", content: [document.createTextNode("File"), icon("down", 14)],
      items: () => fileItems(files, store) }),
    open, save,
    element("span", { class: "divider" }), undo, redo,
    element("span", { class: "divider" }),
    element("span", { class: "file-name" }, name, dot));
  const middle = element("div", {},
    element("div", { class: "segmented", role: "group", "aria-label": "Mode" }, ...modes));
  const end = element("div", { class: "top-end" },
    menuButton({ id: "view-menu", label: "View", content: [icon("eye", 16), element("span", { class: "button-words" }, "View"), icon("down", 14)],
      items: () => viewItems(store, commands) }),
    out, theme, help);
  return [start, middle, end];
}

/** @param {string} id @param {string} label @param {() => void} run @param {string} picture */
function button(id, label, run, picture) {
  return element("button", { id, type: "button", class: "button ghost square", title: label, "aria-label": label,
    onclick: () => run() }, icon(picture));
}

/** @param {HTMLElement} node @param {string} verb @param {string | null} label @param {string} keys */
function step(node, verb, label, keys) {
  const capital = verb[0].toUpperCase() + verb.slice(1);
  state(node, Boolean(label), label ? `${capital}: ${label} (${keyText(keys)})` : `Nothing to ${verb}`);
}

/** @param {HTMLElement} node @param {boolean} on @param {string} label */
function state(node, on, label) {
  node.toggleAttribute("disabled", !on);
  node.title = label;
  node.setAttribute("aria-label", label);
}

/** @param {any} files @param {import("studio/store.js").Store} store */
function fileItems(files, store) {
  const path = store.get().file?.path;
  return [
    { label: "New empty scene", icon: "plus", run: () => files.fresh() },
    { label: "Open…", icon: "open", keys: keyText("mod+o"), run: () => files.open() },
    { label: "Ready scenes…", icon: "file", id: "ready-scenes", run: () => files.ready() },
    { label: "Random scene…", icon: "dice", id: "random-scene", run: () => files.random() },
    null,
    { label: path ? `Save to ${path.split(/[\\/]/).pop()}` : "Save", icon: "save", keys: keyText("mod+s"),
      run: () => files.save() },
    { label: "Download as YAML", icon: "out", run: () => files.saveAs("yaml") },
    { label: "Download as JSON", icon: "out", run: () => files.saveAs("json") },
  ];
}

/** @param {import("studio/store.js").Store} store @param {any} commands */
function viewItems(store, commands) {
  const { show } = store.get();
  return [
    { label: "Show everything", icon: "fit", keys: "0", run: commands.fit },
    null,
    ...SHOWN.map(([name, label]) => ({ label, checked: show[name] !== false,
      run: () => store.set({ show: Object.freeze({ ...show, [name]: show[name] === false }) }) })),
  ];
}
