// @ts-check
// The plan on the board: routes, what has been driven, robots at their places now, links of contact, conflicts.

import { toScreen } from "studio/camera.js";
import { motionsOf, poseAt } from "studio/motion.js";

/** Robots are shown at least so large, pixels. */
const LEAST = 4;
/** More conflicts than these have smaller marks. */
const MANY = 25;
/** Pixels from a conflict's mark within which it is meant. */
const MARK_REACH = 8;

/**
 * Layer of the board.
 * @param {CanvasRenderingContext2D} context
 * @param {any} view
 */
export function paintPlan(context, view) {
  const { state } = view;
  const { answer, show = {}, time } = state;
  if (!answer) return;
  const motions = motionsOf(answer);
  const now = time?.now ?? 0;
  const poses = motions.map((motion) => poseAt(motion, now));
  const chosen = chosenNames(state);
  const stale = state.planning?.state === "stale" || state.planning?.state === "failed";
  context.save();
  context.lineJoin = "round";
  context.lineCap = "round";
  if (show.routes !== false) motions.forEach((motion, k) => paintRoute(context, view, motion, k, stale, chosen));
  if (show.trails !== false && now > 0) {
    motions.forEach((motion, k) => paintTrail(context, view, motion, poses[k], k, chosen));
  }
  if (show.contact !== false) paintLinks(context, view, poses, now);
  if (show.conflicts !== false) paintConflicts(context, view, answer.conflicts ?? [], now);
  if (now > 0) motions.forEach((motion, k) => paintRobot(context, view, motion, poses[k], k, chosen));
  context.restore();
}

/** @param {Record<string, any>} state */
function chosenNames({ selection, hover }) {
  const names = new Set();
  for (const ref of selection ?? []) if (ref.kind !== "obstacle") names.add(ref.name);
  if (hover?.kind === "robot") names.add(hover.name);
  return names;
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {any} view
 * @param {import("studio/motion.js").Motion} motion
 * @param {number} index
 * @param {boolean} stale
 * @param {Set<string>} chosen
 */
function paintRoute(context, view, motion, index, stale, chosen) {
  context.beginPath();
  for (let k = 0; k < motion.xs.length; k += 1) to(context, view, motion.xs[k], motion.ys[k], k === 0);
  context.strokeStyle = view.colours.robot(index);
  context.globalAlpha = faded(motion.name, chosen, stale ? 0.3 : 0.55);
  context.lineWidth = chosen.has(motion.name) ? 3 : 1.5;
  context.setLineDash(stale ? [5, 5] : []);
  context.stroke();
  context.setLineDash([]);
  context.globalAlpha = 1;
}

/**
 * Where one robot is chosen the others step back.
 * @param {string} name
 * @param {Set<string>} chosen
 * @param {number} usual
 */
function faded(name, chosen, usual) {
  if (chosen.size === 0) return usual;
  return chosen.has(name) ? Math.max(usual, 0.9) : usual * 0.5;
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {any} view
 * @param {import("studio/motion.js").Motion} motion
 * @param {import("studio/motion.js").Pose} pose
 * @param {number} index
 * @param {Set<string>} chosen
 */
function paintTrail(context, view, motion, pose, index, chosen) {
  context.beginPath();
  for (let k = 0; k <= pose.leg; k += 1) to(context, view, motion.xs[k], motion.ys[k], k === 0);
  to(context, view, pose.x, pose.y, false);
  context.strokeStyle = view.colours.robot(index);
  context.globalAlpha = faded(motion.name, chosen, 0.9);
  context.lineWidth = chosen.has(motion.name) ? 4 : 3;
  context.stroke();
  context.globalAlpha = 1;
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {any} view
 * @param {number} x
 * @param {number} y
 * @param {boolean} first
 */
function to(context, view, x, y, first) {
  if (first) context.moveTo(view.x(x), view.y(y));
  else context.lineTo(view.x(x), view.y(y));
}

/**
 * A disc with a notch that tells where it looks; one that waits has a ring.
 * @param {CanvasRenderingContext2D} context
 * @param {any} view
 * @param {import("studio/motion.js").Motion} motion
 * @param {import("studio/motion.js").Pose} pose
 * @param {number} index
 * @param {Set<string>} chosen
 */
function paintRobot(context, view, motion, pose, index, chosen) {
  if (!pose.present) return;
  const { camera, width, height, colours, state } = view;
  const [px, py] = [view.x(pose.x), view.y(pose.y)];
  const radius = Math.max(motion.radius * camera.scale, LEAST);
  if (px < -radius || py < -radius || px > width + radius || py > height + radius) return;
  context.beginPath();
  context.arc(px, py, radius, 0, 2 * Math.PI);
  context.fillStyle = colours.robot(index);
  context.fill();
  context.lineWidth = chosen.has(motion.name) ? 2.5 : 1;
  context.strokeStyle = chosen.has(motion.name) ? colours.accent : colours.workspace;
  context.stroke();
  context.beginPath();
  context.moveTo(px + 0.25 * radius * Math.cos(pose.heading), py - 0.25 * radius * Math.sin(pose.heading));
  context.lineTo(px + 0.85 * radius * Math.cos(pose.heading), py - 0.85 * radius * Math.sin(pose.heading));
  context.lineWidth = Math.max(1.5, radius / 6);
  context.strokeStyle = colours.workspace;
  context.stroke();
  const waits = !pose.moving && state.time.now < motion.arrival;
  if (!waits) return;
  context.beginPath();
  context.arc(px, py, radius + 3, 0, 2 * Math.PI);
  context.setLineDash([3, 3]);
  context.lineWidth = 1.5;
  context.strokeStyle = colours.quiet;
  context.stroke();
  context.setLineDash([]);
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {any} view
 * @param {import("studio/motion.js").Pose[]} poses
 * @param {number} now
 */
function paintLinks(context, view, poses, now) {
  const { timelines, answer } = view.state;
  if (!timelines || timelines.answer !== answer || timelines.reach === null) return;
  context.beginPath();
  for (const { pair: [i, j], begin, end } of timelines.links) {
    if (now < begin || (end !== null && now > end)) continue;
    to(context, view, poses[i].x, poses[i].y, true);
    to(context, view, poses[j].x, poses[j].y, false);
  }
  context.strokeStyle = view.colours.link;
  context.globalAlpha = 0.9;
  context.lineWidth = 1.75;
  context.stroke();
  context.globalAlpha = 1;
}

/**
 * The conflict whose mark is at a pixel, or null: that of the mark on top, and none where marks are not shown.
 * @param {import("studio/camera.js").Window} window
 * @param {Record<string, any>} state
 * @param {readonly [number, number]} pixel
 */
export function conflictAt(window, { answer, show, mode, sketch }, pixel) {
  if (!answer || mode !== "edit" || sketch || show?.conflicts === false) return null;
  return answer.conflicts.findLast((/** @type {any} */ { place }) => {
    const [x, y] = toScreen(window, place);
    return Math.hypot(pixel[0] - x, pixel[1] - y) <= MARK_REACH;
  }) ?? null;
}

/**
 * Marks where a robot would have met another: a square that it waited for, a diamond that it went round; those of the
 * present second are full.
 * @param {CanvasRenderingContext2D} context
 * @param {any} view
 * @param {any[]} conflicts
 * @param {number} now
 */
function paintConflicts(context, view, conflicts, now) {
  const { colours, state } = view;
  const half = conflicts.length > MANY ? 3 : 5;
  for (const conflict of conflicts) {
    const [px, py] = [view.x(conflict.place[0]), view.y(conflict.place[1])];
    const listed = state.hover?.kind === "conflict" && state.hover.conflict === conflict;
    const hovered = listed || conflict === state.encounter;
    const present = Math.abs(conflict.time - now) < 0.5 && now > 0;
    context.save();
    context.translate(px, py);
    if (conflict.resolution !== "wait") context.rotate(Math.PI / 4);
    context.fillStyle = present || hovered ? colours.bad : colours.workspace;
    context.strokeStyle = colours.bad;
    context.lineWidth = hovered ? 3 : 1.5;
    context.fillRect(-half, -half, 2 * half, 2 * half);
    context.strokeRect(-half, -half, 2 * half, 2 * half);
    context.restore();
  }
}
