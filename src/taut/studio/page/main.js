// @ts-check
// Puts the studio together: the state, the link, the board, the bars and panels.

import { announce } from "studio/announce.js";
import { showBanner } from "studio/banner.js";
import { createBoard, still } from "studio/board.js";
import { createCamera } from "studio/camera.js";
import { createCommands } from "studio/commands.js";
import { createComparison } from "studio/comparing.js";
import * as dialogs from "studio/dialogs.js";
import { createDrafts } from "studio/drafts.js";
import { createFiles } from "studio/files.js";
import { paintGrid, paintGround, paintScale } from "studio/grid.js";
import { createHistory } from "studio/history.js";
import { listenToKeys } from "studio/keys.js";
import { createLink } from "studio/link.js";
import { paintOverlay } from "studio/paint_overlay.js";
import { paintPlan } from "studio/paint_plan.js";
import { paintRobots, paintScene } from "studio/paint_scene.js";
import { paintSteps } from "studio/paint_steps.js";
import { paintWhy } from "studio/paint_why.js";
import { createPanels } from "studio/panels.js";
import { createPlanner } from "studio/planner.js";
import { createPlayer, endOf } from "studio/player.js";
import { createStatus } from "studio/status.js";
import { keepSteady } from "studio/steady.js";
import { createStepper } from "studio/stepper.js";
import { createStore } from "studio/store.js";
import { chosenTheme, followTheme } from "studio/theme.js";
import { createTimebar } from "studio/timebar.js";
import { createTimelines } from "studio/timelines.js";
import { keepTimelines } from "studio/timelines_asking.js";
import { TOOLS, createTools } from "studio/tools.js";
import { createToolstrip, createZoom } from "studio/toolstrip.js";
import { createTopbar } from "studio/topbar.js";
import { paintUnderlay } from "studio/underlay.js";
import { attachUnderlay } from "studio/underlay_tools.js";
import { createWelcome } from "studio/welcome.js";

const store = createStore({
  scene: null,
  revision: 0,
  opened: 0,
  selection: Object.freeze([]),
  tool: "select",
  snap: Object.freeze({ grid: true, step: null, vertex: true, edge: true, angle: true }),
  settings: Object.freeze({}),
  file: null,
  history: Object.freeze({ undo: null, redo: null }),
  server: Object.freeze({ state: "connecting", message: "" }),
  planning: Object.freeze({ state: "idle", running: false, progress: null, wrong: null }),
  answer: null,
  problems: [],
  time: Object.freeze({ now: 0, playing: false, speed: 1, loop: false }),
  timelines: null,
  mode: "edit",
  steps: Object.freeze({ of: "mrppa", robot: null, list: null, index: 0 }),
  compare: null,
  compared: null,
  show: Object.freeze({}),
  reach: null,
  theme: "light",
  themeChoice: chosenTheme(),
  underlay: null,
  hover: null,
  sketch: null,
  pointer: null,
  said: "",
  tab: "properties",
  folded: false,
});
followTheme(store);

const link = createLink();
const camera = createCamera();
const history = createHistory(store);
const planner = createPlanner({ store, link, history });
const player = createPlayer(store, () => {
  const { mode, compared, answer } = store.get();
  return mode === "compare" ? (compared?.until ?? 0) : endOf(answer);
});
const drafts = createDrafts({ store, history, dialogs });
const files = createFiles({ store, history, link, dialogs, drafts, showPlan: planner.showPlan });

const canvas = /** @type {HTMLCanvasElement} */ (part("board"));
const layers = [
  still(["scene", "show", "underlay"], [paintGround, paintUnderlay, paintGrid, paintScene]),
  paintWhy,
  paintSteps,
  /** @type {import("studio/board.js").Layer} */
  (context, view) => {
    if (view.state.mode !== "steps") paintPlan(context, view);
  },
  paintRobots,
];
const board = createBoard(canvas, store, camera, [...layers, paintOverlay, paintScale]);
const commands = createCommands({ store, history, board, camera, link, player });
const page = { store, history, link, camera, board, planner, player, files, drafts, commands, dialogs };

attachUnderlay({ canvas, camera, store, history, dialogs });
createTools({ canvas, board, store, history, camera });
part("top").append(...createTopbar(page));
part("tools").append(...createToolstrip(page, TOOLS));
part("overlay").append(createZoom(page));
part("panel").append(...createPanels(page, createStepper(store, link)));
part("view").append(createComparison(store, link, layers));
part("time").append(createTimebar(store, player), createTimelines(store, player));
createStatus(part("status"), store);
createWelcome(part("empty"), page);
keepTimelines(store, link);
showBanner(part("banner"), page);
listenToKeys({ page, tools: TOOLS, choose: commands.tool });
files.acceptDrops(part("app"));

store.on(["mode"], ({ mode }) => {
  document.body.dataset.mode = mode;
  part("view").hidden = mode !== "compare";
});
store.on(["planning"], ({ planning: { running, state, improving } }) =>
  part("stage").classList.toggle("busy", running && (improving || state === "stale")));
document.querySelector(".skip")?.addEventListener("click", () => {
  store.set({ tab: "objects", mode: "edit" });
  part("objects").focus();
});
store.on(["said"], ({ said }) => said && announce(said));
part("view").hidden = true;

keepSteady(canvas, camera, board, commands.refit);

store.on(["opened"], commands.fit);

link.on("state", (state) => store.set({ server: Object.freeze({ state, message: "" }) }));
link.on("down", ({ refused, reason }) => store.set({ server: Object.freeze({ state: "gone", refused, message: reason }) }));
link.on("hello", (hello) => {
  store.set({ server: Object.freeze({ state: "warming", message: "" }), hello });
  files.begin(hello);
});

/** For tests and the console. */
Object.assign(window, { studio: { ...page, latencies: planner.latencies } });

/** @param {string} id @returns {HTMLElement} */
function part(id) {
  return /** @type {HTMLElement} */ (document.getElementById(id));
}
