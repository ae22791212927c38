// @ts-check
// The motions of a plan: where every robot is at a time, which way it looks, and when it moves and waits.

/**
 * One robot's motion: straight legs between stamps, rest after the last. `arrival` is the first instant after which it
 * is at its goal for good; one that `leaves` is gone from then on.
 * @typedef {{name: string, radius: number, times: Float64Array, xs: Float64Array, ys: Float64Array,
 *   arrival: number, leaves: boolean, startTime: number}} Motion
 * @typedef {{x: number, y: number, heading: number, moving: boolean, present: boolean, leg: number}} Pose
 * @typedef {{begin: number, end: number, moves: boolean}} Stretch
 */

/** @type {WeakMap<object, Motion[]>} */
const made = new WeakMap();

/**
 * Motions of an answer ({scene, plan}), in the order of the scene's robots; the same list for the same answer.
 * @param {any} answer
 * @returns {Motion[]}
 */
export function motionsOf(answer) {
  const known = made.get(answer);
  if (known) return known;
  const robots = new Map(answer.scene.robots.map((/** @type {any} */ robot) => [robot.name, robot]));
  const motions = answer.plan.robots.map((/** @type {any} */ planned) =>
    motionOf(planned, robots.get(planned.name), answer.scene.at_goal));
  made.set(answer, motions);
  return motions;
}

/**
 * @param {{name: string, stamps: number[][]}} planned
 * @param {any} robot
 * @param {string | undefined} atGoal
 * @returns {Motion}
 */
function motionOf({ name, stamps }, robot, atGoal) {
  const [times, xs, ys] = [0, 1, 2].map((column) => Float64Array.from(stamps, (stamp) => stamp[column]));
  let last = stamps.length - 1;
  while (last > 0 && xs[last - 1] === xs[last] && ys[last - 1] === ys[last]) last -= 1;
  return {
    name,
    radius: robot?.radius ?? 0,
    times,
    xs,
    ys,
    arrival: times[last],
    leaves: (robot?.at_goal ?? atGoal ?? "stay") === "leave",
    startTime: robot?.start_time ?? 0,
  };
}

/**
 * Last arrival of all, seconds.
 * @param {Motion[]} motions
 */
export function makespanOf(motions) {
  return motions.reduce((latest, motion) => Math.max(latest, motion.arrival), 0);
}

/**
 * Where a robot is at a time. It looks along the leg it is on, while it rests along the one before, and before its
 * first move along that.
 * @param {Motion} motion
 * @param {number} time
 * @returns {Pose}
 */
export function poseAt(motion, time) {
  const { times, xs, ys } = motion;
  const last = times.length - 1;
  const leg = legAt(times, time);
  const present = !(motion.leaves && time >= motion.arrival);
  if (leg >= last) return { x: xs[last], y: ys[last], heading: headingOn(motion, last), moving: false, present, leg };
  const share = Math.min(Math.max((time - times[leg]) / (times[leg + 1] - times[leg]), 0), 1);
  const dx = xs[leg + 1] - xs[leg];
  const dy = ys[leg + 1] - ys[leg];
  return {
    x: xs[leg] + share * dx,
    y: ys[leg] + share * dy,
    heading: headingOn(motion, leg),
    moving: dx !== 0 || dy !== 0,
    present,
    leg,
  };
}

/**
 * Number of the leg that holds a time: the last stamp at or before it.
 * @param {Float64Array} times
 * @param {number} time
 */
function legAt(times, time) {
  let low = 0;
  let high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle - 1;
  }
  return low;
}

/**
 * @param {Motion} motion
 * @param {number} leg
 */
function headingOn({ xs, ys }, leg) {
  const last = xs.length - 1;
  for (let k = Math.min(leg, last - 1); k >= 0; k -= 1) {
    if (xs[k] !== xs[k + 1] || ys[k] !== ys[k + 1]) return Math.atan2(ys[k + 1] - ys[k], xs[k + 1] - xs[k]);
  }
  for (let k = leg; k < last; k += 1) {
    if (xs[k] !== xs[k + 1] || ys[k] !== ys[k + 1]) return Math.atan2(ys[k + 1] - ys[k], xs[k + 1] - xs[k]);
  }
  return 0;
}

/**
 * When a robot moves and when it waits, up to its arrival; neighbouring stretches of one kind are one.
 * @param {Motion} motion
 * @returns {Stretch[]}
 */
export function stretchesOf({ times, xs, ys, arrival }) {
  /** @type {Stretch[]} */
  const found = [];
  for (let k = 0; k + 1 < times.length && times[k] < arrival; k += 1) {
    const moves = xs[k] !== xs[k + 1] || ys[k] !== ys[k + 1];
    const before = found.at(-1);
    if (before && before.moves === moves) before.end = times[k + 1];
    else found.push({ begin: times[k], end: times[k + 1], moves });
  }
  return found;
}
