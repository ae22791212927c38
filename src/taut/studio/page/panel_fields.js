// @ts-check
// Labelled fields of panels and dialogs. A wrong entry stays as typed, says why, and changes nothing.

import { element } from "studio/dom.js";
import { readNumber, writeNumber } from "studio/panel_numbers.js";

/**
 * @typedef {{name: string, label: string, type: "number" | "text" | "select" | "checkbox" | "range" | "area",
 *   value?: any, unit?: string, min?: number, max?: number, above?: number, step?: number, whole?: boolean,
 *   optional?: boolean, placeholder?: string, options?: {value: any, label: string, about?: string}[], help?: string,
 *   digits?: number, check?: (value: any) => string | null, hideLabel?: boolean, autofocus?: boolean}} FieldSpec
 * @typedef {{node: HTMLElement, input: HTMLInputElement, value: () => any, check: () => boolean,
 *   focus: () => void, edited: () => boolean,
 *   show: (value: any, options?: {placeholder?: string}) => void}} Field
 */

let serial = 0;

/**
 * Make a field. `commit` is called with each new value that holds, when the user is done with it (Enter, leaving,
 * choosing, arrow keys); it may return a sentence that says why not.
 * @param {FieldSpec} spec
 * @param {(value: any) => string | null | void} [commit]
 * @returns {Field}
 */
export function createField(spec, commit = () => null) {
  const id = `field-${++serial}`;
  if (spec.type === "checkbox") return checkbox(spec, id, commit);
  const input = /** @type {HTMLInputElement} */ (control(spec, id));
  const unit = spec.unit === "deg" ? "°" : spec.unit;
  const wrong = element("p", { class: "field-wrong", id: `${id}-wrong`, hidden: true });
  let shown = spec.value;

  const say = (/** @type {string | null | void} */ text) => {
    wrong.textContent = text ?? "";
    wrong.hidden = !text;
    input.setAttribute("aria-invalid", String(Boolean(text)));
    return !text;
  };
  const show = (/** @type {any} */ value, { placeholder = spec.placeholder ?? "" } = {}) => {
    shown = value;
    input.value = written(spec, value);
    input.placeholder = placeholder;
    say(null);
  };
  const finish = () => {
    if (spec.type !== "select" && input.value === written(spec, shown)) return say(null);
    const got = read(spec, input.value);
    if ("wrong" in got) return say(got.wrong);
    if (got.value === shown) return (show(shown), true);
    const refused = commit(got.value);
    if (!refused) shown = got.value;
    if (!refused && document.activeElement !== input) input.value = written(spec, shown);
    return say(refused);
  };
  input.addEventListener("change", finish);
  if (spec.type === "range") input.addEventListener("input", finish);
  input.addEventListener("keydown", (event) => {
    // In a dialog Enter and Escape are the dialog's: they answer and leave it.
    if (input.closest("dialog") && !event.key.startsWith("Arrow")) return;
    if (event.key === "Escape") (show(shown), input.blur());
    else if (event.key === "Enter" && spec.type !== "area") finish() && input.select?.();
    else if (spec.type === "number" && stepped(event, input, spec)) finish();
    else return;
    event.preventDefault();
  });
  const node = element("div", { class: `field field-${spec.type}`, "data-field": spec.name },
    element("label", { for: id, class: spec.hideLabel ? "unseen" : "" }, spec.label),
    element("div", { class: "control" }, input, unit ? element("span", { class: "unit" }, unit) : null),
    wrong, spec.help ? element("p", { class: "field-help", id: `${id}-help` }, spec.help) : null);
  input.setAttribute("aria-describedby", `${id}-wrong${spec.help ? ` ${id}-help` : ""}`);
  show(spec.value);
  return {
    node, input, show, focus: () => input.focus(),
    // What somebody is typing is not written over.
    edited: () => document.activeElement === input && spec.type !== "select" && input.value !== written(spec, shown),
    value: () => {
      const got = read(spec, input.value);
      return "value" in got ? got.value : shown;
    },
    check: () => {
      const got = read(spec, input.value);
      return say("wrong" in got ? got.wrong : null);
    },
  };
}

/** @param {FieldSpec} spec @param {string} id @param {(value: any) => any} commit @returns {Field} */
function checkbox(spec, id, commit) {
  const input = /** @type {HTMLInputElement} */ (element("input", { id, type: "checkbox" }));
  input.checked = Boolean(spec.value);
  input.addEventListener("change", () => {
    if (commit(input.checked)) input.checked = !input.checked;
  });
  const node = element("div", { class: "field field-checkbox", "data-field": spec.name },
    element("label", { for: id }, input, spec.label),
    spec.help ? element("p", { class: "field-help" }, spec.help) : null);
  const show = (/** @type {any} */ value) => {
    input.checked = Boolean(value);
  };
  return {
    node, input, show, focus: () => input.focus(), edited: () => false, value: () => input.checked, check: () => true,
  };
}

/** @param {FieldSpec} spec @param {string} id @returns {HTMLElement} */
function control({ type, options = [], min, max, step, autofocus = false }, id) {
  if (type === "select") {
    return element("select", { id, autofocus },
      ...options.map(({ value, label, about }, k) => element("option", { value: k, title: about ?? null }, label)));
  }
  if (type === "area") return element("textarea", { id, rows: 4, autofocus });
  if (type === "range") return element("input", { id, type: "range", min, max, step: step ?? "any" });
  return element("input", { id, type: "text", inputmode: type === "number" ? "decimal" : null, autocomplete: "off",
    spellcheck: "false", autofocus });
}

/** @param {FieldSpec} spec @param {any} value */
function written({ type, digits, options = [] }, value) {
  if (type === "select") return String(options.findIndex((option) => option.value === value));
  if (value === null || value === undefined) return "";
  return type === "number" ? writeNumber(value, digits) : String(value);
}

/** @param {FieldSpec} spec @param {string} text @returns {{value: any} | {wrong: string}} */
function read(spec, text) {
  if (spec.type === "select") return { value: spec.options?.[Number(text)]?.value };
  if (spec.type === "range") return { value: Number(text) };
  if (spec.type !== "number") {
    const value = spec.type === "area" ? text : text.trim();
    const wrong = spec.check?.(value);
    return wrong ? { wrong } : { value };
  }
  if (spec.optional && text.trim() === "") return { value: null };
  const got = readNumber(text, spec.unit);
  if ("wrong" in got) return got;
  const wrong = outside(spec, got.value) ?? spec.check?.(got.value);
  return wrong ? { wrong } : got;
}

/** @param {FieldSpec} spec @param {number} value @returns {string | null} */
function outside({ min, max, above, whole, unit = "" }, value) {
  const u = unit ? (unit === "deg" ? "°" : ` ${unit}`) : "";
  if (whole && !Number.isInteger(value)) return "Type a whole number.";
  if (above !== undefined && !(value > above)) return `Must be more than ${writeNumber(above)}${u}.`;
  if (min !== undefined && value < min) return `Must be at least ${writeNumber(min)}${u}.`;
  if (max !== undefined && value > max) return `Must be at most ${writeNumber(max)}${u}.`;
  return null;
}

/**
 * Arrow keys step a number: by its step, ten times with Shift, a tenth with Alt. Whether the key did.
 * @param {KeyboardEvent} event @param {HTMLInputElement} input @param {FieldSpec} spec
 */
function stepped(event, input, spec) {
  const way = { ArrowUp: 1, ArrowDown: -1 }[event.key];
  const got = readNumber(input.value, spec.unit);
  if (!way || !("value" in got)) return false;
  const step = spec.whole ? 1 : (spec.step ?? 0.1) * (event.altKey ? 0.1 : 1);
  const to = got.value + way * step * (event.shiftKey ? 10 : 1);
  const held = Math.max(spec.min ?? -Infinity, Math.min(spec.max ?? Infinity, to));
  input.value = writeNumber(Number(held.toPrecision(12)));
  return true;
}
