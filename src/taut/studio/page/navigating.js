// @ts-check
// Looking around on a board that has no tools: drag to pan, wheel to zoom, double-click to see all.

import { fitted, panned, zoomedAt } from "studio/camera.js";
import { boxOfScene } from "studio/scene.js";

/** Factor of a zoom a wheel pixel, logarithmic, and of a press of + or −. */
const WHEEL = 1 / 400;
const PRESS = 1.25;

/**
 * @param {HTMLCanvasElement} canvas
 * @param {import("studio/board.js").Board} board
 * @param {import("studio/camera.js").Camera} camera
 * @param {() => any} scene
 */
export function navigate(canvas, board, camera, scene) {
  const home = () => {
    const { width, height } = board.window();
    camera.set(fitted(boxOfScene(scene()), width, height));
  };
  /**
   * @param {[number, number]} pixel
   * @param {number} factor
   */
  const zoom = (pixel, factor) => camera.set(zoomedAt(board.window(), pixel, factor));

  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom([event.offsetX, event.offsetY], Math.exp(-event.deltaY * WHEEL));
  }, { passive: false });
  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    if (event.buttons & 1) camera.set(panned(camera.get(), event.movementX, event.movementY));
  });
  canvas.addEventListener("dblclick", home);
  canvas.addEventListener("keydown", ({ key }) => {
    const { width, height } = board.window();
    if (key === "+" || key === "=") zoom([width / 2, height / 2], PRESS);
    else if (key === "-") zoom([width / 2, height / 2], 1 / PRESS);
    else if (key === "0") home();
  });
  return { home };
}
