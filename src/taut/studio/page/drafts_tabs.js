// @ts-check
// Which tab this is: a name that outlives loading the page again, and a lock that says that the tab lives.

const KEY = "taut:tab";
const LOCK = "taut:tab:";
/** Milliseconds that a page which is loaded again waits for its former self to let go of the lock. */
const PATIENCE = 1500;

/**
 * Take the name that this tab had before, unless a copy of it lives that has it now, or a new one.
 * @returns {Promise<{tab: string, own: boolean}>} own: it is the name from before
 */
export async function claimTab() {
  const before = remembered();
  if (before && (await held(before))) return { tab: before, own: true };
  const tab = crypto.randomUUID();
  await held(tab);
  try {
    sessionStorage.setItem(KEY, tab);
  } catch {
    // Without a storage of the tab the draft is offered as that of a dead tab when the page is loaded again.
  }
  return { tab, own: false };
}

/** @returns {Promise<Set<string>>} */
export async function livingTabs() {
  const { held: locks = [] } = await navigator.locks.query();
  const names = locks.flatMap(({ name }) => (name?.startsWith(LOCK) ? [name.slice(LOCK.length)] : []));
  return new Set(names);
}

/**
 * Take the lock of a tab for as long as the page lives. Whether it was free in time.
 * @param {string} tab
 * @returns {Promise<boolean>}
 */
function held(tab) {
  return new Promise((resolve) => {
    const keep = () => {
      resolve(true);
      return new Promise(() => {});
    };
    const signal = AbortSignal.timeout(PATIENCE);
    navigator.locks.request(LOCK + tab, { signal }, keep).catch(() => resolve(false));
  });
}

/** @returns {string | null} */
function remembered() {
  try {
    return sessionStorage.getItem(KEY);
  } catch {
    return null;
  }
}
