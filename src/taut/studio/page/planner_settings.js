// @ts-check
// Which settings go with which: what live planning runs, what Improve runs, and what a comparison runs.

/** @typedef {Record<string, any>} Settings */

/** Methods that go on until a budget ends them; live planning takes the quick one in their place. */
const LONG = ["repair", "optimal"];

/** Seconds that Improve and comparisons take where the user set neither rounds nor seconds. */
export const IMPROVE_SECONDS = 10;

/**
 * Whether a setting means anything with the method chosen.
 * @param {Settings} settings
 * @param {string} name
 */
export function applies({ method = null }, name) {
  const rules = /** @type {Record<string, boolean>} */ ({
    order: method !== "search",
    roadmap: method !== "mrppa",
    objective: method === "repair" || method === "optimal",
    within: method === "optimal",
    contact: method !== "optimal",
  });
  return rules[name] ?? true;
}

/**
 * What live planning asks for: quick, whatever the budgets.
 * @param {Settings} settings
 * @returns {Settings}
 */
export function liveSettings(settings) {
  const method = LONG.includes(settings.method) ? null : settings.method;
  return meant({ ...settings, method, rounds: null, seconds: null });
}

/**
 * What Improve asks for: the method with its budget; quick methods are followed by repair.
 * @param {Settings} settings
 * @returns {Settings}
 */
export function improveSettings(settings) {
  const method = settings.method === "prioritized" ? "repair" : settings.method;
  const budget = settings.rounds || settings.seconds ? {} : { seconds: IMPROVE_SECONDS };
  return meant({ ...settings, ...budget, method });
}

/**
 * What a side of the comparison asks for: the method as chosen, and an end for those that need one.
 * @param {Settings} settings
 * @returns {Settings}
 */
export function comparedSettings(settings) {
  const endless = LONG.includes(settings.method) && !settings.rounds && !settings.seconds;
  return meant(endless ? { ...settings, seconds: IMPROVE_SECONDS } : settings);
}

/**
 * The settings without those that mean nothing here or have no value.
 * @param {Settings} settings
 * @returns {Settings}
 */
function meant(settings) {
  return Object.fromEntries(Object.entries(settings).filter(
    ([name, value]) => value !== null && value !== undefined && applies(settings, name)));
}
