// @ts-check
// Light and dark: by the system until the user chooses; remembered in this browser.

const KEY = "taut-studio-theme";
const NEXT = /** @type {Record<string, string>} */ ({ system: "light", light: "dark", dark: "system" });

/** @returns {MediaQueryList} */
const darkQuery = () => matchMedia("(prefers-color-scheme: dark)");

/** What the user chose: "system", "light" or "dark". */
export function chosenTheme() {
  try {
    const kept = localStorage.getItem(KEY) ?? "system";
    return kept in NEXT ? kept : "system";
  } catch {
    return "system";
  }
}

/**
 * Keep `theme` ("light" or "dark") of the store and of the document in step with the choice and the system.
 * @param {import("studio/store.js").Store} store
 */
export function followTheme(store) {
  const apply = () => {
    const choice = store.get().themeChoice;
    const theme = choice === "system" ? (darkQuery().matches ? "dark" : "light") : choice;
    document.documentElement.dataset.theme = theme;
    if (store.get().theme !== theme) store.set({ theme });
  };
  darkQuery().addEventListener("change", apply);
  store.on(["themeChoice"], (state) => {
    try {
      localStorage.setItem(KEY, state.themeChoice);
    } catch {
      // A browser without storage still has both themes; the choice lasts as long as the page.
    }
    apply();
  });
  apply();
}

/**
 * Go to the next choice: system, light, dark.
 * @param {import("studio/store.js").Store} store
 * @returns {string} the new choice
 */
export function nextTheme(store) {
  const themeChoice = NEXT[store.get().themeChoice];
  store.set({ themeChoice });
  return themeChoice;
}
