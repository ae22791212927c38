// @ts-check
// The ready scenes to choose from, each with a small picture.

import { element } from "studio/dom.js";
import { boxOfScene, outlineOf, ownRadius, workspaceRing } from "studio/scene.js";

/** @typedef {import("./scene.js").Scene} Scene */
/** @typedef {import("./scene.js").Point} Point */

const WIDTH = 132;
const HEIGHT = 88;

/** @type {Map<string, Scene>} those that were shown before */
const shown = new Map();

/**
 * Let the user choose.
 * @param {readonly {name: string, about: string}[]} scenes
 * @param {{link: any, dialogs: typeof import("./dialogs.js")}} page
 * @returns {Promise<string | null>}
 */
export function chooseReady(scenes, { link, dialogs }) {
  const cards = scenes.map(({ name, about }) => {
    const canvas = /** @type {HTMLCanvasElement} */ (element("canvas", { "aria-hidden": "true" }));
    void picture(canvas, name, link);
    const text = element("span", { class: "ready-text" }, element("strong", {}, name), element("span", {}, about));
    const attributes = { type: "button", class: "ready-card", "data-scene": name, onclick: () => close(name) };
    return element("button", attributes, canvas, text);
  });
  const { done, close } = dialogs.modal({
    title: "Ready scenes",
    body: element("div", { class: "ready-list" }, ...cards),
    wide: true,
  });
  return done;
}

/**
 * @param {HTMLCanvasElement} canvas
 * @param {string} name
 * @param {any} link
 */
async function picture(canvas, name, link) {
  const ratio = window.devicePixelRatio || 1;
  [canvas.width, canvas.height] = [WIDTH * ratio, HEIGHT * ratio];
  [canvas.style.width, canvas.style.height] = [`${WIDTH}px`, `${HEIGHT}px`];
  try {
    const scene = shown.get(name) ?? (await link.ask("ready", { name }, { lane: `ready ${name}` }).promise).scene;
    shown.set(name, scene);
    paint(canvas, scene, ratio);
  } catch {
    // A card without a picture still says what it is.
  }
}

/**
 * @param {HTMLCanvasElement} canvas
 * @param {Scene} scene
 * @param {number} ratio
 */
function paint(canvas, scene, ratio) {
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  const style = getComputedStyle(canvas);
  const colour = (/** @type {string} */ name) => style.getPropertyValue(name);
  const [xmin, ymin, xmax, ymax] = boxOfScene(scene);
  const scale = Math.min((WIDTH - 8) / (xmax - xmin), (HEIGHT - 8) / (ymax - ymin)) * ratio;
  const place = (/** @type {Point} */ [x, y]) => [
    canvas.width / 2 + (x - (xmin + xmax) / 2) * scale,
    canvas.height / 2 - (y - (ymin + ymax) / 2) * scale,
  ];
  const trace = (/** @type {readonly Point[]} */ points) => {
    context.beginPath();
    for (const point of points) context.lineTo(place(point)[0], place(point)[1]);
  };
  const disc = (/** @type {Point} */ at, /** @type {number} */ radius) => {
    context.beginPath();
    context.arc(place(at)[0], place(at)[1], radius, 0, 2 * Math.PI);
    context.fill();
  };
  [context.lineCap, context.lineJoin] = ["round", "round"];
  trace(workspaceRing(scene));
  context.closePath();
  [context.fillStyle, context.strokeStyle, context.lineWidth] = [colour("--paper"), colour("--quiet"), ratio];
  context.fill();
  context.stroke();
  [context.fillStyle, context.strokeStyle] = [colour("--quiet"), colour("--quiet")];
  for (const obstacle of scene.obstacles) {
    if (obstacle.circle) {
      disc(obstacle.circle, ownRadius(obstacle) * scale);
      continue;
    }
    trace(outlineOf(obstacle));
    context.lineWidth = obstacle.line ? Math.max(ratio, 2 * ownRadius(obstacle) * scale) : ratio;
    if (obstacle.line) context.stroke();
    else context.fill();
  }
  context.fillStyle = colour("--accent");
  for (const { start, radius } of scene.robots) disc(start, Math.max(1.5 * ratio, radius * scale));
}
