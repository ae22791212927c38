// @ts-check
// Live planning and checking: after each change the newest scene is planned, and the last good plan stays until then.

import { announce } from "studio/announce.js";
import { toast } from "studio/dialogs.js";
import { newestOnly } from "studio/planner_lane.js";
import { improveSettings, liveSettings } from "studio/planner_settings.js";

const STALE_AFTER = 200; // milliseconds: a plan that is older than that is drawn as stale
const SLOW = 300; // milliseconds: in drags, scenes that take longer are planned when the pointer rests, and now and then
const REST = 150;
const CHECK_PACE = 120; // milliseconds between checks during a drag: the processor is for the plans then
const KEPT_LATENCIES = 2000;
/** How planning stands where there is nothing to tell. */
const NONE = { state: "idle", progress: null, wrong: null, seconds: null };

/**
 * @typedef {{revision: number, scene: any, settings: Record<string, any>, sent: Record<string, any>, improved: boolean,
 *   at: number, moved: number | null}} Request settings: those of the page; sent: those of them that were planned with
 */

/**
 * Keep `planning`, `answer` and `problems` of the store in step with its scene and settings.
 * @param {{store: import("studio/store.js").Store, link: import("studio/link.js").Link,
 *   history: {dragging: () => boolean}}} page
 */
export function createPlanner({ store, link, history }) {
  /** @type {Map<number, Request>} */
  const requests = new Map();
  /** @type {number[]} */
  const latencies = [];
  let improving = false;
  /** Milliseconds that the last live plans took: one hiccup does not make a scene a slow one. @type {number[]} */
  let took = [];
  let landed = 0; // when the newest plan came
  let answered = 0; // the number of the newest ask with a result
  let moved = /** @type {number | null} */ (null);
  let restTimer = 0;
  let staleTimer = 0;
  let checkTimer = 0;

  const tell = (/** @type {Record<string, any>} */ patch) =>
    store.set({ planning: Object.freeze({ ...store.get().planning, ...patch }) });

  const plans = newestOnly({
    start() {
      const { scene, revision, settings } = store.get();
      const improved = improving;
      const sent = improved ? improveSettings(settings) : liveSettings(settings);
      const asked = link.ask("plan", { scene, settings: sent },
        { lane: "plan", progress: (said) => requests.has(asked.id) && tell({ progress: said }) });
      requests.set(asked.id, { revision, scene, settings, sent, improved, at: performance.now(), moved });
      moved = null;
      tell({ id: asked.id, running: true, improving: improved, progress: null, began: performance.now() });
      return asked;
    },
    done(ok, asked) {
      const request = land(asked);
      if (!request) return;
      // What the worker took, not the round trip: that may have waited until the kernels were warm.
      const worked = Object.values(ok.phases).reduce((sum, part) => sum + 1000 * part, 0);
      if (!request.improved) took = [...took, worked].slice(-3);
      show(request, ok, (performance.now() - request.at) / 1000);
    },
    failed(error, asked) {
      const request = land(asked);
      if (!request) return undefined;
      if (request.improved && store.get().answer?.revision === request.revision) return unimproved(error);
      clearTimeout(staleTimer);
      const wrong = error.said ?? { message: error.message };
      tell({ state: "failed", wrong, revision: request.revision, progress: null });
      if (isNewest(request) && !history.dragging()) announce(`No plan. ${wrong.message}`);
      return undefined;
    },
    ended() {
      improving = false;
      const { revision, answer, settings } = store.get();
      const same = answer?.revision === revision && answer.settings === settings;
      tell({ running: false, improving: false, progress: null, state: same ? "fresh" : answer ? "stale" : "idle" });
    },
  });

  const checks = newestOnly({
    start: () => link.ask("check", { scene: store.get().scene }, { lane: "check" }),
    done: (ok) => store.set({ problems: ok.problems, notes: ok.notes }),
    failed: () => {},
  });

  /** @param {{id: number}} asked */
  function land(asked) {
    const request = asked.id > answered ? requests.get(asked.id) : undefined;
    if (request) answered = asked.id;
    for (const id of [...requests.keys()]) if (id <= asked.id) requests.delete(id);
    if (request?.improved) improving = false;
    landed = performance.now();
    tell({ running: plans.running(), improving });
    return request;
  }

  /** @param {Request} request */
  const isNewest = ({ revision, settings }) => store.get().revision === revision && store.get().settings === settings;

  /** @param {Request} request @param {any} ok @param {number} seconds */
  function show(request, ok, seconds) {
    clearTimeout(staleTimer);
    const { scene, revision, settings, sent, improved } = request;
    const newest = isNewest(request);
    store.set({
      answer: Object.freeze({ ...ok, scene, revision, settings, sent, improved }),
      planning: Object.freeze({ ...store.get().planning, state: newest ? "fresh" : "planning", wrong: null, revision,
        seconds, progress: null }),
    });
    if (!newest) ageing();
    if (newest && !history.dragging()) announce(spoken(ok, improved));
    if (request.moved !== null) painted(request.moved);
  }

  /** @param {Error} error of an improvement; the live plan still holds */
  function unimproved(error) {
    tell({ state: "fresh", progress: null });
    toast(`Not improved. ${error.message}`, { kind: "bad" });
  }

  /** Measure, when the frame with this plan is on the screen, how long ago the pointer moved. */
  function painted(/** @type {number} */ start) {
    requestAnimationFrame(() => {
      const channel = new MessageChannel();
      channel.port1.onmessage = () => {
        const end = performance.now();
        performance.measure("drag-to-plan", { start, end });
        latencies.push(end - start);
        if (latencies.length > KEPT_LATENCIES) latencies.shift();
      };
      channel.port2.postMessage(null);
    });
  }

  function ageing() {
    clearTimeout(staleTimer);
    staleTimer = setTimeout(() => {
      if (store.get().planning.state === "planning") tell({ state: "stale" });
    }, STALE_AFTER);
  }

  function changed() {
    const { scene, planning, answer, revision, settings } = store.get();
    if (!scene) return;
    if (answer?.opened && answer.revision === revision && answer.settings === settings) return;
    improving = false;
    clearTimeout(restTimer);
    if (scene.robots.length === 0) return empty();
    if (planning.state === "fresh" || planning.state === "idle") {
      tell({ state: "planning" });
      ageing();
    }
    const slow = history.dragging() && middle(took) > SLOW;
    if (slow) restTimer = setTimeout(plans.want, REST);
    // A hand that keeps moving sees a plan now and then; half of the time is left to other work.
    const due = !plans.running() && performance.now() - landed > Math.max(REST, middle(took));
    if (!slow || due) plans.want();
  }

  /** Another document: plans of the one before, shown or on their way, say nothing about it. */
  function forget() {
    const { revision } = store.get();
    for (const [id, request] of requests) if (request.revision < revision) requests.delete(id);
    took = [];
    const planning = Object.freeze({ ...store.get().planning, ...NONE });
    store.set({ answer: null, timelines: null, problems: [], notes: [], planning });
  }

  function check() {
    if (!store.get().scene) return;
    if (!history.dragging()) {
      clearTimeout(checkTimer);
      checkTimer = 0;
      checks.want();
    } else checkTimer ||= setTimeout(() => {
      checkTimer = 0;
      checks.want();
    }, CHECK_PACE);
  }

  function empty() {
    plans.cancel();
    requests.clear();
    clearTimeout(staleTimer);
    store.set({ answer: null, planning: Object.freeze({ ...NONE, running: false }) });
  }

  // The pointer's own time is when the mouse moved, not when the page came to hear of it.
  const movedAt = (/** @type {Event} */ { type, timeStamp }) => {
    if (type !== "pointermove") moved = null;
    else if (history.dragging()) moved = timeStamp;
  };
  for (const type of ["pointermove", "pointerdown", "keydown"]) window.addEventListener(type, movedAt, true);

  const ends = [
    store.on(["revision", "settings"], changed),
    store.on(["opened"], forget),
    store.on(["revision"], check),
    link.on("hello", () => {
      if (!store.get().scene) return;
      checks.want();
      if (store.get().planning.state !== "fresh") changed();
    }),
  ];

  return {
    latencies,

    /** Run the chosen method with its budget; the live plan stays until a better one is there. */
    improve() {
      if (!store.get().scene?.robots.length) return;
      clearTimeout(restTimer);
      improving = true;
      plans.want();
    },

    /** Stop what is under way: an improvement keeps the best plan that it found. */
    stop() {
      if (!plans.running()) return;
      announce("Planning stopped.");
      if (improving) plans.finish();
      else plans.cancel();
    },

    /**
     * Show a plan that came from a file, until something changes.
     * @param {any} plan
     * @param {any} scene
     */
    showPlan(plan, scene) {
      plans.cancel();
      requests.clear();
      const { revision, settings } = store.get();
      const answer = { plan, certificate: plan.certificate ?? null, metrics: plan.metrics ?? null, conflicts: [],
        detours: {}, shortest: {}, notes: [], phases: {}, history: [] };
      store.set({
        answer: Object.freeze({ ...answer, scene, revision, settings, improved: false, opened: true }),
        planning: Object.freeze({ ...NONE, state: "fresh", running: false, revision }),
      });
    },

    destroy() {
      plans.cancel();
      checks.cancel();
      for (const end of ends) end();
      for (const type of ["pointermove", "pointerdown", "keydown"]) window.removeEventListener(type, movedAt, true);
    },
  };
}

/** @typedef {ReturnType<typeof createPlanner>} Planner */

/** @param {number[]} values the middle one, 0 of none */
const middle = (values) => [...values].sort((a, b) => a - b)[values.length >> 1] ?? 0;

/** @param {any} ok @param {boolean} improved */
function spoken({ metrics, certificate }, improved) {
  const proved = certificate?.ok ? "certified" : "not certified";
  const cost = metrics ? `, sum of costs ${metrics.sum_of_costs.toFixed(2)} seconds` : "";
  return `${improved ? "Improved plan" : "Plan"} ready${cost}, ${proved}.`;
}
