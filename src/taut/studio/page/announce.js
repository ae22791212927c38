// @ts-check
// Says to screen readers what the eye sees happen: plans, errors, selections, steps undone.

let last = "";
let at = 0;

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
  const region = document.getElementById(urgent ? "say-now" : "say");
  if (!region) return;
  region.textContent = "";
  // A region that is emptied and filled in one task is not heard as a change.
  setTimeout(() => {
    region.textContent = text;
  }, 30);
}
