// @ts-check
// The page of one plan that needs no server: a file to send. Plays, scrubs, zooms, and shows the timelines.

import { createBoard, still } from "studio/board.js";
import { createCamera } from "studio/camera.js";
import { element } from "studio/dom.js";
import { paintGrid, paintGround, paintScale } from "studio/grid.js";
import { makespanOf, motionsOf } from "studio/motion.js";
import { navigate } from "studio/navigating.js";
import { paintPlan } from "studio/paint_plan.js";
import { paintRobots, paintScene } from "studio/paint_scene.js";
import { createPlayer } from "studio/player.js";
import { deepFreeze } from "studio/scene.js";
import { createStore } from "studio/store.js";
import { createTimebar, SPEEDS } from "studio/timebar.js";
import { createTimelines } from "studio/timelines.js";

const { title, answer, timelines } = JSON.parse(document.getElementById("data")?.textContent ?? "{}");
deepFreeze(answer.scene);
const store = createStore({
  scene: answer.scene,
  revision: 0,
  answer: Object.freeze({ ...answer, revision: 0 }),
  timelines: null,
  planning: { state: "fresh" },
  selection: [],
  hover: null,
  mode: "show",
  show: { grid: true, routes: true, trails: true, labels: true, contact: true, conflicts: true },
  time: Object.freeze({ now: 0, playing: false, speed: speedFor(makespanOf(motionsOf(answer))), loop: true }),
});
if (timelines) store.set({ timelines: Object.freeze({ ...timelines, answer: store.get().answer }) });

const player = createPlayer(store);
const camera = createCamera();
const canvas = /** @type {HTMLCanvasElement} */ (
  element("canvas", { id: "board", tabindex: 0, role: "img", "aria-label": `${title}: map with moving robots` }));
document.title = title;
document.body.append(
  element("header", {}, element("h1", {}, title), element("p", { class: "quiet" }, summary())),
  element("main", {}, canvas),
  element("footer", {}, createTimebar(store, player), createTimelines(store, player)),
);
const board = createBoard(canvas, store, camera,
  [still(["scene", "show"], [paintGround, paintGrid, paintScene]), paintRobots, paintPlan, paintScale]);
const { home } = navigate(canvas, board, camera, () => answer.scene);
requestAnimationFrame(() => {
  home();
  if (!matchMedia("(prefers-reduced-motion: reduce)").matches) player.play();
});

addEventListener("keydown", (event) => {
  if (event.key !== " " || event.target instanceof HTMLButtonElement) return;
  event.preventDefault();
  player.toggle();
});

/** The least speed offered at which the whole plan takes no longer than twenty seconds. */
function speedFor(/** @type {number} */ seconds) {
  return SPEEDS.find((speed) => seconds / speed <= 20) ?? SPEEDS[SPEEDS.length - 1];
}

function summary() {
  const { metrics, plan } = answer;
  const held = answer.certificate?.ok ? "certified" : "not certified";
  return `${plan.robots.length} robots, last arrival ${metrics.makespan.toFixed(2)} s, sum of costs `
    + `${metrics.sum_of_costs.toFixed(2)} s, ${held}. Planned by taut.`;
}
