// @ts-check
// The tools of the board: one table of their states and events, and what feeds it with pointer and keys.

import { toWorld } from "studio/camera.js";
import { addCorner, aimChain, beginChain, chainKey, finishChain } from "studio/tool_chains.js";
import { createDesk } from "studio/tool_desk.js";
import { endNudge, escapeDrag, toolKey, nudge, selectKey } from "studio/tool_keys.js";
import { createMachine } from "studio/tool_machine.js";
import { createNavigation } from "studio/tool_navigation.js";
import {
  beginBox, beginGrip, beginMove, click, clickGrip, doubleClick, drag, drop, giveUp, hover, press, stretchBox,
} from "studio/tool_select.js";
import { beginSpan, endSpan, stretchSpan } from "studio/tool_spans.js";
import { conflictAt } from "studio/paint_plan.js";
import { problemAt } from "studio/paint_problems.js";

/**
 * What tools hear: where the pointer is, in pixels and metres, and which keys are held.
 * @typedef {{pixel: [number, number], point: [number, number], device: "mouse" | "pen" | "touch", shift: boolean,
 *   alt: boolean, control: boolean, key: string, onBoard: boolean, use: () => void}} BoardEvent
 * @typedef {import("studio/tool_desk.js").Desk} Desk
 */

/** The tools, in the order of the strip. */
export const TOOLS = Object.freeze([
  { name: "select", title: "Select and move", key: "v" },
  { name: "pan", title: "Move about", key: "h" },
  { name: "polygon", title: "Polygon", key: "p" },
  { name: "rectangle", title: "Rectangle", key: "r" },
  { name: "circle", title: "Circle", key: "c" },
  { name: "wall", title: "Wall", key: "w" },
  { name: "robot", title: "Robot", key: "b" },
  { name: "measure", title: "Measure", key: "m" },
]);

/**
 * State → event → [action, the states that it may lead to]; a state stays where an action gives none.
 * Events: move, down, up, double (click), key, keyup, retract (a press was none: a second finger came), settle
 * (something else begins). Moving about the map is a table of its own, in tool_navigation.js.
 * @type {import("studio/tool_machine.js").Table}
 */
export const TABLE = Object.freeze({
  "select": {
    move: [hover],
    down: [press, "select.grip", "select.body", "select.void"],
    double: [doubleClick],
    key: [selectKey, "select.nudge"],
  },
  "select.void": { move: [beginBox, "select.box"], up: [click, "select"], retract: [giveUp, "select"] },
  "select.body": {
    move: [beginMove, "select.drag", "select"],
    up: [click, "select"],
    retract: [giveUp, "select"],
  },
  "select.grip": {
    move: [beginGrip, "select.drag", "select"],
    up: [clickGrip, "select"],
    retract: [giveUp, "select"],
  },
  "select.box": {
    move: [stretchBox],
    up: [giveUp, "select"],
    retract: [giveUp, "select"],
    key: [escapeDrag, "select"],
  },
  "select.drag": {
    move: [drag, "select"],
    up: [drop, "select"],
    retract: [giveUp, "select"],
    key: [escapeDrag, "select"],
  },
  "select.nudge": { key: [nudge], keyup: [endNudge, "select"], settle: [endNudge, "select"] },

  "polygon": { move: [aim], up: [beginChain, "polygon.chain"], key: [toolKey] },
  "polygon.chain": {
    move: [aimChain],
    up: [addCorner, "polygon"],
    double: [finishChain, "polygon"],
    key: [chainKey, "polygon"],
  },
  "wall": { move: [aim], up: [beginChain, "wall.chain"], key: [toolKey] },
  "wall.chain": { move: [aimChain], up: [addCorner, "wall"], double: [finishChain, "wall"], key: [chainKey, "wall"] },

  "rectangle": { move: [aim], down: [beginSpan, "rectangle.span"], key: [toolKey] },
  "rectangle.span": spanOf("rectangle"),
  "circle": { move: [aim], down: [beginSpan, "circle.span"], key: [toolKey] },
  "circle.span": spanOf("circle"),
  "robot": { move: [aim], down: [beginSpan, "robot.span"], key: [toolKey] },
  "robot.span": spanOf("robot"),
  "measure": { down: [beginSpan, "measure.span"], key: [toolKey] },
  "measure.span": spanOf("measure"),

  "pan": { key: [toolKey] },
});

/** What a state asks of the user. */
const HINTS = /** @type {Record<string, string>} */ ({
  "polygon": "Click the corners of a polygon · Enter puts one in the middle",
  "polygon.chain": "Click the next corner · Enter or the first corner closes · Backspace takes one back",
  "wall": "Click the corners of a wall · Enter puts one in the middle",
  "wall.chain": "Click the next corner · Enter or a double click ends · Backspace takes one back",
  "rectangle": "Drag a rectangle, or click two corners · Enter puts one in the middle",
  "rectangle.span": "Shift makes a square",
  "circle": "Drag a circle from its centre · Enter puts one in the middle",
  "circle.span": "Click or let go at the rim",
  "robot": "Click the start of a robot, or drag from start to goal · Enter puts one in the middle",
  "robot.span": "Click the goal, or let go there",
  "measure": "Drag along what to measure",
  "measure.span": "Shift keeps steps of 15°",
  "pan": "Drag the map",
});

/**
 * Attach the tools to a board.
 * @param {{canvas: HTMLCanvasElement, board: import("studio/board.js").Board, store: import("studio/store.js").Store,
 *   history: any, camera: import("studio/camera.js").Camera}} parts
 */
export function createTools(parts) {
  const { canvas, board, store, camera } = parts;
  const desk = createDesk(parts);
  const machine = createMachine(TABLE, desk, { name: "select" });
  const navigation = createNavigation({ canvas, camera, store, window: desk.window, pixelOf });
  let pressed = /** @type {number | null} */ (null);
  let last = /** @type {BoardEvent | null} */ (null);

  /** @param {MouseEvent} event @returns {[number, number]} */
  function pixelOf(event) {
    const { left, top } = canvas.getBoundingClientRect();
    return [event.clientX - left, event.clientY - top];
  }

  /**
   * @param {MouseEvent} event
   * @returns {BoardEvent}
   */
  function boardEvent(event) {
    const pixel = pixelOf(event);
    const kind = /** @type {PointerEvent} */ (event).pointerType;
    return {
      pixel,
      point: toWorld(board.window(), pixel),
      device: kind === "touch" || kind === "pen" ? kind : "mouse",
      shift: event.shiftKey,
      alt: event.altKey,
      control: event.ctrlKey || event.metaKey,
      key: "",
      onBoard: true,
      use: () => event.preventDefault(),
    };
  }

  /**
   * @param {string} type
   * @param {BoardEvent} [event]
   */
  function send(type, event) {
    if (!store.get().scene) return;
    const before = machine.state().name;
    machine.send(type, event);
    const { name } = machine.state();
    if (name !== before) {
      desk.say(HINTS[name] ?? "");
      cursor();
    }
  }

  function cursor() {
    const { tool } = store.get();
    if (navigation.busy()) canvas.style.cursor = "grabbing";
    else if (navigation.held() || tool === "pan") canvas.style.cursor = "grab";
    else if (tool !== "select") canvas.style.cursor = "crosshair";
    else if (machine.state().name === "select") canvas.style.cursor = "default";
  }

  const listeners = /** @type {[EventTarget, string, (event: any) => void, boolean?][]} */ ([
    [canvas, "pointerdown", down],
    [canvas, "pointermove", move],
    [canvas, "pointerup", up],
    [canvas, "pointercancel", cancel],
    [canvas, "pointerleave", leave],
    [canvas, "dblclick", (event) => event.button === 0 && send("double", boardEvent(event))],
    [canvas, "contextmenu", (event) => event.preventDefault()],
    // Captured: what the board uses has been used before the keys of the page are looked up.
    [document, "keydown", keydown, true],
    [document, "keyup", keyup, true],
    [window, "blur", () => (send("settle"), navigation.hold(false))],
  ]);

  /** @param {PointerEvent} event */
  function down(event) {
    canvas.focus({ preventScroll: true });
    send("settle");
    const moves = navigation.down(event);
    if (moves === "second" && pressed !== null) {
      pressed = null;
      send("retract");
    }
    if (moves !== "no" || event.button === 0) canvas.setPointerCapture(event.pointerId);
    if (moves === "no" && event.button === 0 && pressed === null) {
      pressed = event.pointerId;
      last = boardEvent(event);
      send("down", last);
    }
    cursor();
  }

  /** @param {PointerEvent} event */
  function move(event) {
    if (navigation.move(event)) return;
    if (pressed !== null && pressed !== event.pointerId) return;
    last = boardEvent(event);
    const { scene, problems, probe = null } = store.get();
    const found = scene ? problemAt(board.window(), problems ?? [], last.pixel) : null;
    const encounter = found === null ? conflictAt(board.window(), store.get(), last.pixel) : null;
    store.set({ pointer: last.point, encounter, ...(found === probe ? {} : { probe: found }) });
    if (!navigation.held()) send("move", last);
  }

  /** @param {PointerEvent} event */
  function up(event) {
    const moved = navigation.up(event);
    if (!moved && pressed === event.pointerId) {
      pressed = null;
      last = boardEvent(event);
      send("up", last);
    }
    cursor();
  }

  /** @param {PointerEvent} event */
  function cancel(event) {
    navigation.up(event);
    if (pressed === event.pointerId) send("retract");
    pressed = null;
  }

  function leave() {
    if (pressed !== null) return;
    const { hover: under, sketch } = store.get();
    const kept = sketch?.kind === "cursor" ? null : sketch;
    if (under || kept !== sketch) store.set({ hover: null, sketch: kept });
    store.set({ pointer: null, probe: null, encounter: null });
  }

  /** @param {KeyboardEvent} event */
  function keydown(event) {
    if (event.target !== canvas && event.target !== document.body) return;
    if (event.key === " ") {
      navigation.hold(true);
      cursor();
    }
    if (modifier(event) || event.ctrlKey || event.metaKey) return;
    if (!event.key.startsWith("Arrow")) send("settle");
    send("key", { ...(last ?? nowhere()), shift: event.shiftKey, alt: event.altKey, key: event.key,
      onBoard: event.target === canvas, use: () => event.preventDefault() });
  }

  /** @param {KeyboardEvent} event */
  function keyup(event) {
    if (event.key === " ") {
      navigation.hold(false);
      cursor();
    }
    if (!modifier(event) && event.key.startsWith("Arrow")) send("keyup");
  }

  /**
   * Shift, Alt and Ctrl change what the pointer means where it is.
   * @param {KeyboardEvent} event
   */
  function modifier(event) {
    if (event.key !== "Shift" && event.key !== "Alt" && event.key !== "Control" && event.key !== "Meta") return false;
    if (last && machine.state().name.includes(".")) {
      last = { ...last, shift: event.shiftKey, alt: event.altKey, control: event.ctrlKey || event.metaKey };
      send("move", last);
    }
    return true;
  }

  /** Leave whatever is under way: the tool is at rest. */
  function reset() {
    send("settle");
    if (machine.state().name === "select.drag") parts.history.abandon();
    pressed = null;
    machine.put(desk.idle());
    desk.say(HINTS[machine.state().name] ?? "");
    desk.point(null, "default");
    cursor();
  }

  for (const [target, type, listener, capture = false] of listeners) target.addEventListener(type, listener, capture);
  canvas.style.touchAction = "none";
  const off = store.on(["tool"], reset);

  return {
    reset,
    state: () => machine.state().name,

    destroy() {
      off();
      navigation.destroy();
      for (const [target, type, listener, capture = false] of listeners) {
        target.removeEventListener(type, listener, capture);
      }
    },
  };
}

/**
 * A tool that has nothing begun shows where its first place would snap to.
 * @param {Desk} desk
 * @param {BoardEvent} event
 */
function aim(desk, event) {
  const { point, guides } = desk.snap(event, {});
  desk.point(null, "crosshair");
  desk.sketch({ kind: "cursor", points: [point], guides, labels: [] });
}

/**
 * Between the two places of a tool that needs two.
 * @param {string} idle
 * @returns {Readonly<Record<string, import("studio/tool_machine.js").Transition>>}
 */
function spanOf(idle) {
  return {
    move: [stretchSpan],
    up: [endSpan, idle],
    retract: [giveUp, idle],
    key: [escapeDrag, idle],
  };
}

/** @returns {BoardEvent} an event before the pointer has been anywhere */
function nowhere() {
  return { pixel: [0, 0], point: [0, 0], device: "mouse", shift: false, alt: false, control: false, key: "",
    onBoard: true, use: () => undefined };
}
