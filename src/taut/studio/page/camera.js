// @ts-check
// The camera: which place of the plane lies in the middle of the board, and how many pixels a metre has there.

/**
 * The place (x, y) in metres in the middle of the board, and the scale in CSS pixels a metre. North is up.
 * @typedef {{readonly x: number, readonly y: number, readonly scale: number}} View2D
 * @typedef {{camera: View2D, width: number, height: number}} Window a camera and the size of its board, CSS pixels
 * @typedef {readonly [number, number]} Point
 * @typedef {readonly [number, number, number, number]} Box xmin, ymin, xmax, ymax in metres
 */

const LEAST_SCALE = 1e-7;
const MOST_SCALE = 1e12;
/** Doubles have about 4.5e15 steps up to a coordinate; closer than this many pixels to them the picture would jump. */
const STEPS = 2 ** 46;

/**
 * Where a place of the plane is on the board, in CSS pixels. The centre is subtracted first, in doubles, so that
 * places far from the origin stay sharp.
 * @param {Window} window
 * @param {Point} place
 * @returns {[number, number]}
 */
export function toScreen({ camera, width, height }, [x, y]) {
  return [(x - camera.x) * camera.scale + width / 2, (camera.y - y) * camera.scale + height / 2];
}

/**
 * Which place of the plane is at a pixel of the board.
 * @param {Window} window
 * @param {Point} pixel
 * @returns {[number, number]}
 */
export function toWorld({ camera, width, height }, [x, y]) {
  return [camera.x + (x - width / 2) / camera.scale, camera.y - (y - height / 2) / camera.scale];
}

/**
 * The camera after the paper was pushed by so many pixels.
 * @param {View2D} camera
 * @param {number} dx
 * @param {number} dy
 * @returns {View2D}
 */
export function panned(camera, dx, dy) {
  return { x: camera.x - dx / camera.scale, y: camera.y + dy / camera.scale, scale: camera.scale };
}

/**
 * The camera after zooming by a factor; the place at the pixel stays there.
 * @param {Window} window
 * @param {Point} pixel
 * @param {number} factor
 * @returns {View2D}
 */
export function zoomedAt(window, pixel, factor) {
  const [x, y] = toWorld(window, pixel);
  const scale = allowed(window.camera.scale * factor, Math.max(Math.abs(x), Math.abs(y)));
  return {
    x: x - (pixel[0] - window.width / 2) / scale,
    y: y + (pixel[1] - window.height / 2) / scale,
    scale,
  };
}

/**
 * The camera that shows a box whole, with a margin in pixels.
 * @param {Box} box
 * @param {number} width
 * @param {number} height
 * @param {number} [margin]
 * @returns {View2D}
 */
export function fitted([xmin, ymin, xmax, ymax], width, height, margin = 48) {
  const across = Math.max(width - 2 * margin, width / 4, 1);
  const up = Math.max(height - 2 * margin, height / 4, 1);
  const scale = Math.min(across / Math.max(xmax - xmin, 1e-300), up / Math.max(ymax - ymin, 1e-300));
  const x = xmin + (xmax - xmin) / 2;
  const y = ymin + (ymax - ymin) / 2;
  return { x, y, scale: allowed(scale, Math.max(Math.abs(x), Math.abs(y))) };
}

/**
 * The box of the plane that a board shows.
 * @param {Window} window
 * @returns {[number, number, number, number]}
 */
export function shownBox({ camera: { x, y, scale }, width, height }) {
  const across = width / 2 / scale;
  const up = height / 2 / scale;
  return [x - across, y - up, x + across, y + up];
}

/**
 * @param {number} scale
 * @param {number} farthest largest coordinate in sight, metres
 */
function allowed(scale, farthest) {
  return Math.min(Math.max(scale, LEAST_SCALE), MOST_SCALE, farthest > 0 ? STEPS / farthest : Infinity);
}

/**
 * The one camera of the page. Boards share it; watchers hear of each change.
 * @param {View2D} [first]
 */
export function createCamera(first = { x: 0, y: 0, scale: 50 }) {
  let current = Object.freeze({ ...first });
  /** @type {Set<(camera: View2D) => void>} */
  const watchers = new Set();

  return {
    /** @returns {View2D} */
    get: () => current,

    /** @param {View2D} next */
    set(next) {
      if (![next.x, next.y, next.scale].every(Number.isFinite)) return;
      if (next.x === current.x && next.y === current.y && next.scale === current.scale) return;
      current = Object.freeze({ x: next.x, y: next.y, scale: next.scale });
      for (const watcher of watchers) watcher(current);
    },

    /**
     * @param {(camera: View2D) => void} watcher
     * @returns {() => void} ends it
     */
    on(watcher) {
      watchers.add(watcher);
      return () => watchers.delete(watcher);
    },
  };
}

/** @typedef {ReturnType<typeof createCamera>} Camera */
