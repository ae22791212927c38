// @ts-check
// Looking around on a board that has no tools: the gestures of the main board, + and −, and double-click to see all.

import { fitted, zoomedAt } from "studio/camera.js";
import { boxOfScene } from "studio/scene.js";
import { createStore } from "studio/store.js";
import { createNavigation } from "studio/tool_navigation.js";

/** Factor of a zoom by key. */
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
  const navigation = createNavigation({
    canvas,
    camera,
    window: board.window,
    store: createStore({ tool: "pan" }), // every press is for moving about
    pixelOf: ({ offsetX, offsetY }) => [offsetX, offsetY],
  });
  canvas.style.touchAction = "none";
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    navigation.down(event);
  });
  canvas.addEventListener("pointermove", (event) => navigation.move(event));
  canvas.addEventListener("pointerup", (event) => navigation.up(event));
  canvas.addEventListener("pointercancel", (event) => navigation.up(event));
  canvas.addEventListener("dblclick", home);
  canvas.addEventListener("keydown", ({ key }) => {
    const { width, height } = board.window();
    if (key === "+" || key === "=") camera.set(zoomedAt(board.window(), [width / 2, height / 2], PRESS));
    else if (key === "-") camera.set(zoomedAt(board.window(), [width / 2, height / 2], 1 / PRESS));
    else if (key === "0") home();
  });
  return { home };
}
