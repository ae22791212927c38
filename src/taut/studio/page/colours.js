// @ts-check
// The colours of the board, light and dark, and one hue a robot: those of taut's figures.

/**
 * @typedef {{ink: string, quiet: string, outside: string, workspace: string, wall: string, obstacle: string,
 *   obstacleEdge: string, obstacleInk: string, grown: string, graph: string, start: string, goal: string, link: string,
 *   bridge: string, apart: string, grid: string, gridStrong: string, accent: string, onAccent: string,
 *   line: string, highlight: string, bad: string, warn: string, good: string, halo: string, dark: boolean,
 *   robot: (k: number) => string, robotInk: (k: number) => string}} Colours
 */

/** One hue a robot, told apart also by people with protanopia, deuteranopia or tritanopia. */
const HUES = Object.freeze([
  "#e08e00", "#332288", "#c2188b", "#009e73", "#222222", "#3ba3d8", "#5a3215", "#cc79a7", "#5f7a1f", "#0072b2",
]);

/** After the ten hues come the same hues lighter and darker: [towards, share]. */
const STEPS = /** @type {[string, number][]} */ ([["#ffffff", 0], ["#ffffff", 0.38], ["#000000", 0.38]]);

/** Every colour a robot can have on light paper, in order; then again from the first. */
const ROBOT_CYCLE = Object.freeze(
  STEPS.flatMap(([towards, share]) => HUES.map((hue) => mix(hue, towards, share))));

const LIGHT = {
  ink: "#26292e", quiet: "#5c646e", outside: "#e9ebee", workspace: "#ffffff", wall: "#4d555f",
  obstacle: "#7ea6d8", obstacleEdge: "#2f5e9e", obstacleInk: "#12305a", grown: "#dfe9f6", graph: "#a3abb5",
  start: "#d7263d", goal: "#17913f", link: "#64748b", bridge: "#d7263d", apart: "#f4c2c8",
  grid: "rgba(38, 41, 46, 0.045)", gridStrong: "rgba(38, 41, 46, 0.09)", line: "#d5d9de", highlight: "#eaf3fa",
  accent: "#0072b2", onAccent: "#ffffff", bad: "#c4162f", warn: "#9a5b00", good: "#137a35", halo: "#ffffff",
};

const DARK = {
  ink: "#e7eaee", quiet: "#9da7b3", outside: "#101316", workspace: "#1b1f24", wall: "#8d97a3",
  obstacle: "#35577f", obstacleEdge: "#7fabdf", obstacleInk: "#dbe8f8", grown: "#222d3b", graph: "#5f6975",
  start: "#ff6b7a", goal: "#4cc26b", link: "#94a3b8", bridge: "#ff6b7a", apart: "#6b2c36",
  grid: "rgba(231, 234, 238, 0.04)", gridStrong: "rgba(231, 234, 238, 0.08)", line: "#343b43", highlight: "#1d3240",
  accent: "#4db3e6", onAccent: "#0b1a24", bad: "#ff7a86", warn: "#f0b429", good: "#4cc26b", halo: "#14171b",
};

/** Least contrast of a robot's disc with the workspace, and of its name. */
const SEEN = 2.2;
const READ = 4.5;

/** @type {Map<boolean, Colours>} */
const made = new Map();

/**
 * The colours of the board; the same object each time.
 * @param {boolean} dark
 * @returns {Colours}
 */
export function palette(dark) {
  const known = made.get(dark);
  if (known) return known;
  const base = dark ? DARK : LIGHT;
  const discs = dark ? ROBOT_CYCLE.map((hue) => legible(hue, base.workspace, SEEN, "#ffffff")) : ROBOT_CYCLE;
  const inks = discs.map((hue) => legible(hue, base.workspace, READ, dark ? "#ffffff" : "#000000"));
  const colours = Object.freeze({
    ...base,
    dark,
    robot: (/** @type {number} */ k) => discs[k % discs.length],
    robotInk: (/** @type {number} */ k) => inks[k % inks.length],
  });
  made.set(dark, colours);
  return colours;
}

/**
 * The colours of a theme: "light", "dark", or of the system for anything else.
 * @param {unknown} theme
 */
export function coloursOf(theme) {
  return palette(isDark(theme));
}

/**
 * Whether the page is dark: by its theme ("light" or "dark"), else by the system.
 * @param {unknown} theme
 */
export function isDark(theme) {
  return theme === "dark" || (theme !== "light" && matchMedia("(prefers-color-scheme: dark)").matches);
}

/**
 * A colour with a share (0 to 1) of another in it, as #rrggbb.
 * @param {string} colour #rrggbb
 * @param {string} other #rrggbb
 * @param {number} share
 */
export function mix(colour, other, share) {
  const [a, b] = [channels(colour), channels(other)];
  return `#${a.map((value, k) => halfToEven(value + (b[k] - value) * share).toString(16).padStart(2, "0")).join("")}`;
}

/**
 * A #rrggbb colour with an opacity, for canvas styles.
 * @param {string} colour
 * @param {number} opacity 0 to 1
 */
export function faded(colour, opacity) {
  return `rgba(${channels(colour).join(", ")}, ${opacity})`;
}

/**
 * Contrast of two colours as in WCAG 2, 1 to 21.
 * @param {string} a
 * @param {string} b
 */
export function contrast(a, b) {
  const [low, high] = [luminance(a), luminance(b)].sort((x, y) => x - y);
  return (high + 0.05) / (low + 0.05);
}

/**
 * @param {string} colour
 * @param {string} paper
 * @param {number} least
 * @param {string} towards
 */
function legible(colour, paper, least, towards) {
  let shade = colour;
  while (contrast(shade, paper) < least) shade = mix(shade, towards, 0.1);
  return shade;
}

/** @param {string} colour */
function channels(colour) {
  return [1, 3, 5].map((k) => parseInt(colour.slice(k, k + 2), 16));
}

/** @param {string} colour */
function luminance(colour) {
  const [red, green, blue] = channels(colour).map((value) => {
    const share = value / 255;
    return share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
  });
  return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
}

/**
 * The nearest whole number; a half goes to the even one, as in the figures.
 * @param {number} value
 */
function halfToEven(value) {
  const floor = Math.floor(value);
  if (value - floor !== 0.5) return Math.round(value);
  return floor % 2 === 0 ? floor : floor + 1;
}
