// @ts-check
// Files handed to the browser's downloads.

/** Milliseconds that the browser has to take a file. */
const TAKEN = 60_000;

/**
 * Give the browser a file to keep.
 * @param {{name: string, type: string, text?: string, base64?: string}} file
 */
export function download({ name, type, text, base64 }) {
  const content = text ?? Uint8Array.from(atob(base64 ?? ""), (letter) => letter.charCodeAt(0));
  const address = URL.createObjectURL(new Blob([content], { type }));
  const anchor = document.createElement("a");
  [anchor.href, anchor.download] = [address, name];
  anchor.click();
  setTimeout(() => URL.revokeObjectURL(address), TAKEN);
}
