// @ts-check
// The board: a canvas that draws layers crisply, once a frame and only when something changed.

import { fitted } from "studio/camera.js";
import { coloursOf } from "studio/colours.js";

/** What pictures of the board are made of; a change of anything else draws nothing. */
const PAINTED = [
  "scene", "selection", "sketch", "hover", "show", "theme", "underlay", "problems", "planning", "answer", "time",
  "timelines", "mode", "steps", "compare", "reach", "tool", "focused", "probe", "encounter",
];

/**
 * What a layer sees. `x` and `y` give the CSS pixels of a place; the context's unit is the CSS pixel, `ratio` device
 * pixels each.
 * @typedef {{state: import("studio/store.js").State, camera: import("studio/camera.js").View2D, width: number,
 *   height: number, ratio: number, colours: import("studio/colours.js").Colours, x: (metres: number) => number,
 *   y: (metres: number) => number}} View
 * @typedef {(context: CanvasRenderingContext2D, view: View) => void} Layer
 */

/**
 * @param {import("studio/store.js").State} state
 * @param {import("studio/camera.js").View2D} camera
 * @param {number} width
 * @param {number} height
 * @param {number} [ratio]
 * @returns {View}
 */
function viewOf(state, camera, width, height, ratio = 1) {
  return {
    state,
    camera,
    width,
    height,
    ratio,
    colours: coloursOf(state.theme),
    x: (metres) => (metres - camera.x) * camera.scale + width / 2,
    y: (metres) => (camera.y - metres) * camera.scale + height / 2,
  };
}

/**
 * Draw layers, lowest first, each from a clean context whose unit is the CSS pixel.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {readonly Layer[]} layers
 */
export function paint(context, view, layers) {
  for (const layer of layers) {
    context.save();
    context.setTransform(view.ratio, 0, 0, view.ratio, 0, 0);
    layer(context, view);
    context.restore();
  }
}

/**
 * The lowest layer, made of several that depend only on the camera and on some keys of the state. While these rest it
 * is a picture that is copied, so that what moves above it (robots, handles) costs no drawing below.
 * @param {readonly string[]} keys
 * @param {readonly Layer[]} layers
 * @returns {Layer}
 */
export function still(keys, layers) {
  /** @type {unknown[]} */
  let seen = [];
  /** @type {HTMLCanvasElement | null} */
  let picture = null;

  return (context, view) => {
    const { camera, width, height, ratio, colours, state } = view;
    const now = [camera, width, height, ratio, colours, ...keys.map((key) => state[key])];
    if (now.length !== seen.length || now.some((value, k) => value !== seen[k])) {
      seen = now;
      picture = null;
      paint(context, view, layers);
      return;
    }
    if (picture) {
      context.setTransform(1, 0, 0, 1, 0, 0);
      context.drawImage(picture, 0, 0);
      return;
    }
    paint(context, view, layers);
    picture = document.createElement("canvas");
    picture.width = context.canvas.width;
    picture.height = context.canvas.height;
    picture.getContext("2d")?.drawImage(context.canvas, 0, 0);
  };
}

/**
 * Draw layers on a canvas whenever the store, the camera, its size or the theme change. `see` gives the state that the
 * layers see, for boards that show something else than the page's own answer.
 * @param {HTMLCanvasElement} canvas
 * @param {import("studio/store.js").Store} store
 * @param {import("studio/camera.js").Camera} camera
 * @param {readonly Layer[]} layers
 * @param {(state: import("studio/store.js").State) => import("studio/store.js").State} [see]
 */
export function createBoard(canvas, store, camera, layers, see = (state) => state) {
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  const size = { width: canvas.clientWidth, height: canvas.clientHeight };
  let asked = 0;

  function draw() {
    if (asked) cancelAnimationFrame(asked);
    asked = 0;
    const ratio = window.devicePixelRatio || 1;
    const [across, up] = [Math.round(size.width * ratio), Math.round(size.height * ratio)];
    if (canvas.width !== across || canvas.height !== up) {
      canvas.width = across;
      canvas.height = up;
    }
    if (across === 0 || up === 0) return; // hidden
    const view = viewOf(see(store.get()), camera.get(), size.width, size.height, ratio);
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = view.colours.outside;
    context.fillRect(0, 0, across, up);
    paint(context, view, layers);
  }

  function invalidate() {
    if (!asked) asked = requestAnimationFrame(draw);
  }

  const resized = new ResizeObserver(() => {
    size.width = canvas.clientWidth;
    size.height = canvas.clientHeight;
    draw(); // at once: a canvas that has changed its size shows a stretched picture until it is drawn
  });
  resized.observe(canvas);
  const system = matchMedia("(prefers-color-scheme: dark)");
  system.addEventListener("change", invalidate);
  window.addEventListener("resize", invalidate); // also the device pixel ratio, when the page is zoomed
  const ends = [
    store.on(PAINTED, invalidate),
    camera.on(invalidate),
    () => resized.disconnect(),
    () => system.removeEventListener("change", invalidate),
    () => window.removeEventListener("resize", invalidate),
  ];
  invalidate();

  return {
    canvas,
    invalidate,
    /** Draw now, not with the next frame. */
    draw,

    /** The camera with the size of this board. */
    window: () => ({ camera: camera.get(), width: size.width, height: size.height }),

    /**
     * Show a box of the plane whole.
     * @param {import("studio/camera.js").Box} box
     */
    fit(box) {
      camera.set(fitted(box, size.width, size.height));
    },

    destroy() {
      if (asked) cancelAnimationFrame(asked);
      for (const end of ends) end();
    },
  };
}

/** @typedef {ReturnType<typeof createBoard>} Board */
