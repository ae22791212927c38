// @ts-check
// Says to screen readers what the eye sees happen: plans, errors, selections, steps undone.

let last = "";
let at = 0;
/** @type {Map<string, string[]>} sentences about to be said, by region */
const waiting = new Map();

/**
 * Say a sentence. The same sentence within a second is said once; an urgent one interrupts.
 * @param {string} text
 * @param {{urgent?: boolean}} [options]
 */
export function announce(text, { urgent = false } = {}) {
  const now = performance.now();
  if (text === last && now - at < 1000) return;
  last = text;
  at = now;
  const id = urgent ? "say-now" : "say";
  const region = document.getElementById(id);
  if (!region) return;
  const before = waiting.get(id);
  if (before) {
    before.push(text);
    return;
  }
  waiting.set(id, [text]);
  region.textContent = "";
  // A region that is emptied and filled in one task is not heard as a change.
  setTimeout(() => {
    region.textContent = (waiting.get(id) ?? []).join(" ");
    waiting.delete(id);
  }, 30);
}
