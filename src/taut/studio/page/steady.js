// @ts-check
// Keeps the map where it is on the screen when the board gets another size or place.

import { panned } from "studio/camera.js";

/**
 * Pan the camera against every change of the canvas in the page, except where `refit` shows the map anew.
 * @param {HTMLCanvasElement} canvas
 * @param {import("studio/camera.js").Camera} camera
 * @param {import("studio/board.js").Board} board
 * @param {() => boolean} refit
 */
export function keepSteady(canvas, camera, board, refit) {
  /** @type {[number, number] | null} */
  let before = null;

  new ResizeObserver(() => {
    const { left, top, width, height } = canvas.getBoundingClientRect();
    if (width === 0 || height === 0) return; // hidden: it comes back to where it was
    const middle = /** @type {[number, number]} */ ([left + width / 2, top + height / 2]);
    // The camera looks at the middle of the board: what lay there lies now beside it.
    if (!refit() && before) camera.set(panned(camera.get(), before[0] - middle[0], before[1] - middle[1]));
    before = middle;
    board.draw(); // in this frame, so that nothing is seen to jump
  }).observe(canvas);
}
