// @ts-check
// Questions, forms and short messages over the page.

import { announce } from "studio/announce.js";
import { element } from "studio/dom.js";
import { icon } from "studio/icons.js";
import { createField } from "studio/panel_fields.js";

/**
 * @typedef {{label: string, value?: any, kind?: "primary" | "danger" | "plain"}} Button
 * @typedef {import("studio/panel_fields.js").FieldSpec} FieldSpec
 */

let serial = 0;

/**
 * Open a modal dialog around a body. It resolves with the value of the button pressed, or null for Escape or the
 * cross; `close(value)` ends it from outside, and `check` may refuse a button by returning false.
 * @param {{title: string, body: Node | Node[], buttons?: Button[], wide?: boolean, check?: (value: any) => boolean,
 *   role?: string}} spec
 * @returns {{done: Promise<any>, close: (value?: any) => void, node: HTMLDialogElement}}
 */
export function modal({ title, body, buttons = [], wide = false, check = () => true, role = "dialog" }) {
  const before = document.activeElement;
  const label = `dialog-${++serial}`;
  /** @type {(value: any) => void} */
  let settle = () => {};
  const done = new Promise((resolve) => {
    settle = resolve;
  });
  const close = (/** @type {any} */ value = null) => {
    if (!node.open) return;
    node.close();
    node.remove();
    if (before instanceof HTMLElement && before.isConnected) before.focus();
    settle(value);
  };
  const press = (/** @type {any} */ value) => check(value) && close(value);
  const primary = buttons.find(({ kind }) => kind === "primary");
  const foot = buttons.map(({ label: text, value = text, kind = "plain" }) =>
    element("button", { type: kind === "primary" ? "submit" : "button", class: `button ${kind}`,
      onclick: (/** @type {Event} */ event) => (event.preventDefault(), press(value)) }, text));
  const submit = (/** @type {Event} */ event) => {
    event.preventDefault();
    if (primary) press(primary.value ?? primary.label);
  };
  const form = element("form", { method: "dialog", onsubmit: submit },
  element("div", { class: "dialog-head" },
    element("h2", { id: label }, title),
    element("button", { type: "button", class: "button ghost square", "aria-label": "Close",
      onclick: () => close() }, icon("close", 16))),
  element("div", { class: "dialog-body" }, ...[body].flat()),
  buttons.length ? element("div", { class: "dialog-foot" }, ...foot) : null);
  const node = /** @type {HTMLDialogElement} */ (
    element("dialog", { class: wide ? "wide" : "", "aria-labelledby": label, role }, form));
  node.addEventListener("cancel", (event) => (event.preventDefault(), close()));
  node.addEventListener("mousedown", (event) => event.target === node && close());
  // Keys of the studio mean nothing while a question is open; nor do those with which browsers save and open pages.
  node.addEventListener("keydown", (event) => {
    event.stopPropagation();
    if ((event.ctrlKey || event.metaKey) && /^[soe]$/i.test(event.key)) event.preventDefault();
  });
  document.body.append(node);
  node.showModal();
  const first = node.querySelector("[autofocus], .dialog-body input, .dialog-body select") ?? foot.at(-1);
  if (first instanceof HTMLElement) first.focus();
  if (first instanceof HTMLInputElement) first.select();
  return { done, close, node };
}

/**
 * Ask one question; resolves with the value of the button pressed, null for Escape.
 * @param {{title: string, text?: string, buttons?: Button[]}} spec
 * @returns {Promise<any>}
 */
export function ask({ title, text = "", buttons = [{ label: "OK", value: true, kind: "primary" }] }) {
  return modal({ title, body: element("p", {}, text), buttons, role: "alertdialog" }).done;
}

/**
 * Ask for values; resolves with the button pressed and {name: value}, null for Escape or a button of value null.
 * A field that is wrong says why and keeps the form open.
 * @param {{title: string, text?: string, fields: FieldSpec[], submit?: string, buttons?: Button[],
 *   wide?: boolean}} spec
 * @returns {Promise<{button: any, values: Record<string, any>} | null>}
 */
export async function form({ title, text = "", fields, submit = "OK", buttons, wide = false }) {
  const made = fields.map((field) => ({ name: field.name, field: createField(field) }));
  const check = (/** @type {any} */ value) => {
    if (value === null) return true;
    const bad = made.filter(({ field }) => !field.check());
    bad[0]?.field.focus();
    return bad.length === 0;
  };
  const foot = buttons ?? [{ label: "Cancel", value: null }, { label: submit, value: submit, kind: "primary" }];
  const body = [...(text ? [element("p", {}, text)] : []), ...made.map(({ field }) => field.node)];
  const pressed = await modal({ title, body, buttons: foot, check, wide }).done;
  if (pressed === null) return null;
  return { button: pressed, values: Object.fromEntries(made.map(({ name, field }) => [name, field.value()])) };
}

/**
 * Show a short message that goes by itself, said to screen readers too; bad news stays until it is closed.
 * @param {string} text
 * @param {{kind?: "note" | "good" | "bad", action?: {label: string, run: () => void}, seconds?: number}} [options]
 * @returns {() => void} closes it
 */
export function toast(text, { kind = "note", action, seconds = kind === "bad" ? 0 : 5 } = {}) {
  const region = document.getElementById("toasts") ?? document.body;
  const close = () => node.remove();
  const node = element("div", { class: `toast ${kind}` },
    kind === "note" ? null : icon(kind === "good" ? "check" : "warn", 16),
    element("span", {}, text),
    action ? element("button", { type: "button", class: "button ghost",
      onclick: () => (close(), action.run()) }, action.label) : null,
    element("button", { type: "button", class: "button ghost square", "aria-label": "Close message",
      onclick: close }, icon("close", 14)));
  const same = [...region.children].find((other) => other.querySelector("span")?.textContent === text);
  same?.remove();
  region.append(node);
  while (region.children.length > 4) region.firstElementChild?.remove();
  announce(text, { urgent: kind === "bad" });
  if (seconds > 0) setTimeout(close, seconds * 1000);
  return close;
}

/**
 * Make a button that opens a menu; items are {label, run, keys?, icon?, checked?, off?} or null for a line.
 * @param {{label: string, content: Node[], items: () => (MenuItem | null)[], id?: string, class?: string}} spec
 * @returns {HTMLElement}
 *
 * @typedef {{label: string, run: () => void, keys?: string, icon?: string, checked?: boolean, off?: boolean,
 *   id?: string}} MenuItem
 */
export function menuButton({ label, content, items, id, class: look = "button ghost" }) {
  /** @type {HTMLElement | null} */
  let open = null;
  const close = (/** @type {boolean} */ focus) => {
    open?.remove();
    open = null;
    button.setAttribute("aria-expanded", "false");
    document.removeEventListener("pointerdown", outside, true);
    if (focus) button.focus();
  };
  const outside = (/** @type {Event} */ event) => {
    const target = /** @type {Node} */ (event.target);
    if (!open?.contains(target) && !button.contains(target)) close(false);
  };
  const show = () => {
    const menu = element("div", { class: "menu", role: "menu", "aria-label": label, onkeydown: walk },
      ...items().map((item) => item === null ? element("hr", {}) : menuItem(item, () => close(true))));
    const box = button.getBoundingClientRect();
    document.body.append(menu);
    menu.style.top = `${box.bottom + 4}px`;
    menu.style.left = `${Math.max(8, Math.min(box.left, innerWidth - menu.offsetWidth - 8))}px`;
    open = menu;
    button.setAttribute("aria-expanded", "true");
    document.addEventListener("pointerdown", outside, true);
    rows(menu)[0]?.focus();
  };
  const walk = (/** @type {KeyboardEvent} */ event) => {
    event.stopPropagation();
    const all = rows(/** @type {HTMLElement} */ (open));
    const here = all.indexOf(/** @type {HTMLElement} */ (document.activeElement));
    const to = { ArrowDown: here + 1, ArrowUp: here - 1 + all.length, Home: 0, End: all.length - 1 }[event.key];
    if (to !== undefined) all[to % all.length]?.focus();
    else if (event.key === "Escape") close(true);
    else if (event.key === "Tab") return close(false);
    else return undefined;
    return event.preventDefault();
  };
  const button = element("button", { type: "button", class: look, id, "aria-haspopup": "menu", "aria-expanded": "false",
    "aria-label": label, title: label, onclick: () => (open ? close(true) : show()) }, ...content);
  return button;
}

/** @param {HTMLElement} menu @returns {HTMLElement[]} */
const rows = (menu) => /** @type {HTMLElement[]} */ ([...menu.querySelectorAll("button:not([disabled])")]);

/** @param {MenuItem} item @param {() => void} close */
function menuItem({ label, run, keys, icon: name, checked, off = false, id }, close) {
  const mark = checked === undefined ? name : checked ? "check" : null;
  return element("button", { type: "button", id, disabled: off, tabindex: -1,
    role: checked === undefined ? "menuitem" : "menuitemcheckbox",
    "aria-checked": checked === undefined ? null : String(checked), onclick: () => (close(), run()) },
  element("span", { class: "menu-mark" }, mark ? icon(mark, 16) : null),
  element("span", { class: "menu-label" }, label),
  keys ? element("kbd", {}, keys) : null);
}
