// @ts-check
// The keys of the studio: one table that keystrokes are looked up in and the help sheet is written from.

/**
 * A key of the table. `keys` are written as "mod+shift+z" (mod is Ctrl, on Apple's machines ⌘); `run` gets what the
 * page is made of. Keys without `run` belong to the board, which hears them itself; they stand here to be told.
 * @typedef {{keys: string[], title: string, group: string, run?: (page: any) => void, also?: string}} Key
 */

const APPLE = /Mac|iP(hone|ad)/.test(navigator.platform);
const SYMBOLS = /** @type {Record<string, string>} */ ({
  mod: APPLE ? "⌘" : "Ctrl", shift: "Shift", alt: APPLE ? "⌥" : "Alt", arrows: "← ↑ ↓ →", escape: "Esc",
  delete: "Del", enter: "Enter", space: "Space", tab: "Tab", backspace: "⌫", home: "Home", end: "End", f2: "F2",
  arrowleft: "←", arrowright: "→", drag: "drag", "double-click": "double click",
});

/** @type {Key[]} */
export const KEYS = [
  { group: "Document", keys: ["mod+z"], title: "Undo", run: ({ commands }) => commands.undo() },
  { group: "Document", keys: ["mod+shift+z", "mod+y"], title: "Redo", run: ({ commands }) => commands.redo() },
  { group: "Document", keys: ["mod+s"], title: "Save", run: ({ files }) => files.save() },
  { group: "Document", keys: ["mod+o"], title: "Open", run: ({ files }) => files.open() },
  { group: "Document", keys: ["mod+e"], title: "Export", run: ({ commands }) => commands.out() },
  { group: "Edit", keys: ["mod+a"], title: "Select everything", run: ({ commands }) => commands.selectAll() },
  { group: "Edit", keys: ["mod+d"], title: "Duplicate", run: ({ commands }) => commands.duplicate() },
  { group: "Edit", keys: ["delete", "backspace"], title: "Delete",
    also: "⌫ while drawing: take back the last corner", run: ({ commands }) => commands.remove() },
  { group: "Edit", keys: ["alt+drag"], title: "Drag a copy" },
  { group: "Edit", keys: ["double-click"], title: "New corner on a side of what is selected" },
  { group: "Edit", keys: ["f2"], title: "Rename", run: ({ commands }) => commands.rename() },
  { group: "Edit", keys: ["arrows"], title: "Move what is selected by a grid step" },
  { group: "Edit", keys: ["shift+arrows"], title: "… by ten steps" },
  { group: "Edit", keys: ["tab"], title: "Next object" },
  { group: "Edit", keys: ["enter"], title: "Type numbers; close a polygon or wall" },
  { group: "Edit", keys: ["escape"], title: "Leave a drag, a drawing, the selection" },
  { group: "View", keys: ["0"], title: "Show everything", run: ({ commands }) => commands.fit() },
  { group: "View", keys: ["shift+0"], title: "Show the selection", run: ({ commands }) => commands.fitSelection() },
  { group: "View", keys: ["+", "="], title: "Zoom in", run: ({ commands }) => commands.zoom(1.25) },
  { group: "View", keys: ["-"], title: "Zoom out", run: ({ commands }) => commands.zoom(0.8) },
  { group: "View", keys: ["1"], title: "Mode: edit", run: ({ commands }) => commands.mode("edit") },
  { group: "View", keys: ["2"], title: "Mode: steps", run: ({ commands }) => commands.mode("steps") },
  { group: "View", keys: ["3"], title: "Mode: compare", run: ({ commands }) => commands.mode("compare") },
  { group: "View", keys: ["g"], title: "Grid: snap on or off", run: ({ commands }) => commands.toggleSnap("grid") },
  { group: "Time", keys: ["space"], title: "Play, pause", also: "held on the board: pan",
    run: ({ player }) => player.toggle() },
  { group: "Time", keys: ["["], title: "A tenth of a second back", run: ({ commands }) => commands.nudgeTime(-0.1) },
  { group: "Time", keys: ["]"], title: "A tenth of a second on", run: ({ commands }) => commands.nudgeTime(0.1) },
  { group: "Time", keys: ["home"], title: "To the beginning", run: ({ player }) => player.seek(0) },
  { group: "Time", keys: ["end"], title: "To the end", run: ({ player }) => player.seek(player.until()) },
  { group: "Time", keys: [","], title: "Steps: one back", run: ({ commands }) => commands.step(-1) },
  { group: "Time", keys: ["."], title: "Steps: one on", run: ({ commands }) => commands.step(1) },
  { group: "Plan", keys: ["i"], title: "Improve the plan", run: ({ planner }) => planner.improve() },
  { group: "Plan", keys: ["shift+i"], title: "Stop planning", run: ({ planner }) => planner.stop() },
  { group: "Plan", keys: ["?"], title: "This sheet", run: ({ commands }) => commands.help() },
];

/**
 * A key in words: "mod+shift+z" → "Ctrl Shift Z".
 * @param {string} keys
 */
export const keyText = (keys) => (keys === "+" ? ["+"] : keys.split("+"))
  .map((part) => SYMBOLS[part] ?? part.toUpperCase()).join(" ");

/**
 * What was pressed, in the words of the table.
 * @param {KeyboardEvent} event
 */
export function pressed(event) {
  const key = event.key === " " ? "space" : event.key.toLowerCase();
  const mod = APPLE ? event.metaKey : event.ctrlKey;
  const digit = event.shiftKey ? /^Digit(\d)$/.exec(event.code)?.[1] : undefined;
  const name = digit ?? key;
  // Shift is part of a sign such as ? or +; for letters, digits and names it counts by itself.
  const sign = name.length === 1 && !/[a-z0-9]/.test(name);
  return `${mod ? "mod+" : ""}${event.altKey ? "alt+" : ""}${event.shiftKey && !sign ? "shift+" : ""}${name}`;
}

/**
 * Listen to the keys of the table, and to those of the tools. Fields, dialogs and menus keep their own keys.
 * @param {{page: any, tools: readonly {name: string, title: string, key?: string}[],
 *   choose: (tool: string) => void}} spec
 * @returns {() => void} ends it
 */
export function listenToKeys({ page, tools, choose }) {
  const table = new Map(KEYS.flatMap((key) => (key.run ? key.keys.map((each) => [each, key.run]) : [])));
  for (const { name, key } of tools) if (key) table.set(key.toLowerCase(), () => choose(name));
  let [held, panned] = [false, false];

  // Browsers guess whether to show the focus of what a script gave it; the board should show it to the keyboard only.
  const by = (/** @type {Event} */ { type }) => {
    document.documentElement.dataset.by = type === "keydown" ? "keys" : "pointer";
  };
  const down = (/** @type {KeyboardEvent} */ event) => {
    if (event.defaultPrevented || keepsKeys(event)) return;
    const what = pressed(event);
    if (what === "space") {
      // The board pans while it is held: it plays when it is let go without that.
      if (!event.repeat) [held, panned] = [true, false];
      return event.preventDefault();
    }
    const run = table.get(what);
    if (!run) return undefined;
    event.preventDefault();
    // What is being typed belongs to what is saved.
    if (event.target instanceof HTMLInputElement) event.target.blur();
    return run(page);
  };
  const up = (/** @type {KeyboardEvent} */ event) => {
    if (event.key !== " ") return;
    if (held && !panned && !event.defaultPrevented) table.get("space")?.(page);
    held = false;
  };
  const drag = (/** @type {PointerEvent} */ event) => {
    panned ||= event.buttons > 0;
  };
  for (const type of ["keydown", "pointerdown"]) document.addEventListener(type, by, true);
  document.addEventListener("keydown", down);
  document.addEventListener("keyup", up);
  document.addEventListener("pointermove", drag, true);
  return () => {
    for (const type of ["keydown", "pointerdown"]) document.removeEventListener(type, by, true);
    document.removeEventListener("keydown", down);
    document.removeEventListener("keyup", up);
    document.removeEventListener("pointermove", drag, true);
  };
}

/**
 * Whether what has the focus uses the key itself: text in a field, Space on a button, arrows in a list.
 * @param {KeyboardEvent} event
 */
function keepsKeys(event) {
  const target = /** @type {HTMLElement} */ (event.target);
  if (!(target instanceof HTMLElement)) return false;
  if (target.closest("dialog, .menu")) return true;
  const command = event.ctrlKey || event.metaKey;
  if (target.matches("textarea, select, input:not([type=checkbox], [type=range], [type=radio])")) {
    return !(command && /^[soe]$/i.test(event.key));
  }
  if (command) return false;
  return target.matches("button, summary, a, input, [role=option], [role=tab]") &&
    (/^( |Enter|Arrow.*|Home|End)$/.test(event.key));
}
