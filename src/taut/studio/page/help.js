// @ts-check
// The help sheet, written from the tables of keys and tools.

import { modal } from "studio/dialogs.js";
import { element } from "studio/dom.js";
import { KEYS, keyText } from "studio/keys.js";

/**
 * Show the sheet.
 * @param {readonly {name: string, title: string, key?: string}[]} tools
 * @param {string} version
 */
export function openHelp(tools, version) {
  const drawing = tools.flatMap(({ title, key }) => (key ? [{ title, keys: [key], also: "" }] : []));
  const names = [...new Set(KEYS.map(({ group }) => group))];
  const groups = names.map((name) => ({ name, rows: KEYS.filter(({ group }) => group === name) }));
  return modal({
    title: "Keys",
    wide: true,
    body: [
      element("div", { class: "keys-sheet" }, ...[{ name: "Tools", rows: drawing }, ...groups].map(section)),
      element("p", {}, "Wheel or pinch zooms at the pointer; the middle button, two fingers or Space and drag pan. ",
        "Shift while drawing holds the angle to 15°; ", keyText("mod"), " lets go of snapping. ",
        "Numbers may be typed as sums and with units: 3 + 0.5, 50 cm."),
      element("p", {}, `taut studio ${version}. Everything stays on this machine.`),
    ],
  });
}

/** @param {{name: string, rows: any[]}} group */
function section({ name, rows }) {
  return element("section", {}, element("h3", {}, name), element("dl", {}, ...rows.flatMap((/** @type {any} */ row) => [
    element("dt", {}, row.title, row.also ? element("span", { class: "quiet" }, ` (${row.also})`) : null),
    element("dd", {}, ...row.keys.flatMap((/** @type {string} */ keys, /** @type {number} */ k) =>
      [k ? element("span", { class: "quiet" }, " or ") : "", ...keyText(keys).split(" ").flatMap((part, j) =>
        [j ? " " : "", element("kbd", {}, part)])])),
  ])));
}
