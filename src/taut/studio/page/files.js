// @ts-check
// Scenes from files, ready ones and random ones, and back into files; nothing unsaved goes without a question.

import { deepFreeze, emptyScene } from "studio/scene.js";
import { download } from "studio/download.js";
import { chooseReady } from "studio/files_ready.js";
import { layUnder } from "studio/underlay_panel.js";

/** @typedef {import("./scene.js").Scene} Scene */

const KINDS = [
  { value: "open", label: "Open floor with obstacles" },
  { value: "warehouse", label: "Warehouse with shelves" },
];
/** Of a message to the server, with room for what stands round the text. */
const MOST_BYTES = 2 ** 24 - 4096;
const ACCEPTED = ".yaml,.yml,.json,.geojson,.map,image/*";

/**
 * Make what the file menu does.
 * @param {{store: import("./store.js").Store, history: import("./history.js").History, link: any,
 *   dialogs: typeof import("./dialogs.js"), drafts: import("./drafts.js").Drafts,
 *   showPlan: (plan: any, scene: Scene) => void}} page
 */
export function createFiles({ store, history, link, dialogs, drafts, showPlan }) {
  let begun = false;
  /** @type {{robots: number, obstacles: number, seed: number, kind: string}} */
  let thrown = { robots: 10, obstacles: 20, seed: 1, kind: "open" };

  /**
   * Show another document in place of this one.
   * @param {{scene: Scene, plan?: any, certificate?: any, metrics?: any}} opened
   * @param {{name: string, path: string | null, format: string, stamp?: string}} file
   */
  const show = ({ scene, plan, certificate, metrics }, file) => {
    store.set({ answer: null, timelines: null });
    history.replaceAll({ scene: deepFreeze(scene), file });
    if (plan) showPlan({ ...plan, certificate, metrics }, store.get().scene);
  };

  /** Whether the document may go: it is saved, or the user says so. */
  const mayGo = async () => {
    const { file, underlay } = store.get();
    if (!file?.dirty && !underlay) return true;
    const answer = await dialogs.ask({
      title: file?.dirty ? `Save changes to ${file.name}?` : "Let the picture go?",
      text: file?.dirty ? "They are lost if you do not." : "The picture under the scene is not part of its file.",
      buttons: [
        { label: "Cancel", value: null },
        { label: "Do not save", value: "drop", kind: "danger" },
        ...(file?.dirty ? [{ label: "Save", value: "save", kind: /** @type {const} */ ("primary") }] : []),
      ],
    });
    if (answer === "save") return save();
    return answer === "drop";
  };

  /**
   * Ask the server and show what it gives; what is wrong is said.
   * @param {string} kind
   * @param {any} fields
   * @param {string} name
   */
  const openBy = async (kind, fields, name) => {
    try {
      const opened = await link.ask(kind, fields, { lane: "open" }).promise;
      const isScene = kind === "open" && !opened.plan && /\.(ya?ml|json)$/i.test(name);
      const known = isScene ? name : `${opened.scene.name || stemOf(name)}.yaml`;
      show(opened, { name: known, path: null, format: /\.json$/i.test(known) ? "json" : "yaml" });
      return true;
    } catch (error) {
      return told(error, `${name} cannot be opened`, name);
    }
  };

  /**
   * Say why something failed, unless something newer took its place. Always false.
   * @param {any} error
   * @param {string} what
   * @param {string} [name] of the file, which messages may begin with
   */
  const told = (error, what, name = "") => {
    if (error?.name === "Stopped" && error.reason !== "lost") return false;
    const line = error?.said?.line;
    const begins = line ? `${name}:${line}: ` : `${name}: `;
    const text = error?.name === "Stopped" ? "the server did not answer" : String(error?.message ?? error);
    const why = text.startsWith(begins) ? text.slice(begins.length) : text;
    dialogs.toast(`${what}: ${line ? `line ${line}: ` : ""}${why}`, { kind: "bad" });
    return false;
  };

  /** @param {File} file */
  const openFile = async (file) => {
    if (file.type.startsWith("image/")) return void (await layUnder(file, { store, history, dialogs }));
    const text = file.size > MOST_BYTES ? null : await file.text();
    const size = text === null ? file.size : bytesInMessage(text);
    if (text === null || size > MOST_BYTES) dialogs.toast(tooLarge(file.name, size), { kind: "bad" });
    else if (await mayGo()) await openBy("open", { text, name: file.name }, file.name);
  };

  /**
   * Save to the file that was named at the start, or as a download. Whether it is saved.
   * @param {{overwrite_changed?: boolean, drop_comments?: boolean}} [insist]
   * @returns {Promise<boolean>}
   */
  const save = async (insist = {}) => {
    history.abandon();
    const { scene, file } = store.get();
    if (file?.path && !link.isUp()) {
      dialogs.toast(`The server is gone: ${file.name} is not saved. Your work is kept in this browser.`, {
        kind: "bad",
        action: { label: "Download a copy", run: () => saveAs("json") },
      });
      return false;
    }
    if (!file?.path) return saveAs(file?.format === "json" ? "json" : "yaml");
    try {
      const fields = { scene, stamp: file.stamp, ...insist };
      const { saved, stamp } = await link.ask("save", fields, { lane: "save" }).promise;
      if (store.get().file?.path === file.path) {
        // Else another document was opened meanwhile, about which this says nothing.
        store.set({ file: { ...store.get().file, stamp } });
        history.markSaved(scene);
        drafts.flush();
      }
      dialogs.toast(`Saved ${nameOf(saved)}`, { kind: "good", seconds: 2 });
      return true;
    } catch (error) {
      return insisted(error, insist);
    }
  };

  /**
   * What the user says to a file that was changed by others, or whose comments would go.
   * @param {any} error
   * @param {any} insist
   * @returns {Promise<boolean>}
   */
  const insisted = async (error, insist) => {
    const { name = "the file" } = store.get().file ?? {};
    if (error?.kind === "changed") {
      const answer = await dialogs.ask({
        title: `${name} was changed meanwhile`,
        text: `${sentence(error.message)} Saving puts your scene in its place.`,
        buttons: [
          { label: "Cancel", value: null },
          { label: "Download mine instead", value: "download" },
          { label: "Overwrite", value: "overwrite", kind: "danger" },
        ],
      });
      if (answer === "download") return saveAs(store.get().file.format);
      return answer === "overwrite" ? save({ ...insist, overwrite_changed: true }) : false;
    }
    if (error?.kind === "comments") {
      const answer = await dialogs.ask({
        title: `Comments in ${name} would go`,
        text: sentence(error.message),
        buttons: [
          { label: "Cancel", value: null },
          { label: "Download a copy instead", value: "download" },
          { label: "Save without comments", value: "drop", kind: "danger" },
        ],
      });
      if (answer === "download") return saveAs(store.get().file.format);
      return answer === "drop" ? save({ ...insist, drop_comments: true }) : false;
    }
    return told(error, `${name} is not saved; your work is kept in this browser`);
  };

  /**
   * Download the scene; without the server only as JSON, which needs nobody. Whether the browser took it.
   * @param {"yaml" | "json"} format
   * @returns {Promise<boolean>}
   */
  const saveAs = async (format) => {
    history.abandon();
    const { scene, file } = store.get();
    try {
      const up = link.isUp();
      const text = up
        ? (await link.ask("text", { scene, format }, { lane: "save" }).promise).text
        : `${JSON.stringify(scene, null, 1)}\n`;
      const name = `${stemOf(file?.name || scene.name || "scene")}.${up ? format : "json"}`;
      download({ name, type: "text/plain;charset=utf-8", text });
      // What was named at the start is not saved by a download; anything else now is in a file of the user's.
      if (!file?.path) history.markSaved(scene);
      return true;
    } catch (error) {
      return told(error, "The scene cannot be written");
    }
  };

  /** @param {typeof thrown} asked */
  const throwScene = async (asked) => {
    thrown = asked;
    const { kind, robots, obstacles, seed } = asked;
    const fields = kind === "warehouse" ? { kind, robots, seed } : asked;
    if (!(await openBy("random", fields, `A random scene of seed ${seed}`))) return;
    const things = kind === "open" ? `${robots} robots, ${obstacles} obstacles` : `${robots} robots`;
    dialogs.toast(`Random scene of seed ${seed}: ${things}`, {
      seconds: 12,
      action: { label: `Again, seed ${seed + 1}`, run: () => throwAgain() },
    });
  };

  const throwAgain = async () => {
    if (await mayGo()) await throwScene({ ...thrown, seed: thrown.seed + 1 });
  };

  return {
    /**
     * Take what the server says first: at the first time its scene or this browser's draft is opened, later (the server
     * was started again) the page keeps its work.
     * @param {any} hello
     */
    async begin(hello) {
      if (begun) return;
      begun = true;
      const { file, source, scene } = hello;
      const named = source ? `${stemOf(nameOf(source))}.yaml` : "untitled.yaml";
      const about = file
        ? { name: file.name, path: file.path, format: file.text_format, stamp: file.stamp }
        : { name: named, path: null, format: "yaml" };
      show({ ...hello, scene: scene ?? emptyScene() }, about);
      for (const note of hello.notes ?? []) dialogs.toast(sentence(note));
      await drafts.start(hello);
    },

    /** A new empty scene. */
    async fresh() {
      if (await mayGo()) show({ scene: emptyScene() }, { name: "untitled.yaml", path: null, format: "yaml" });
    },

    /** Choose a file to open. */
    open() {
      const input = document.createElement("input");
      [input.type, input.accept] = ["file", ACCEPTED];
      input.addEventListener("change", () => input.files?.[0] && openFile(input.files[0]));
      input.click();
    },

    openFile,
    save: () => save(),
    saveAs,

    /** Choose one of the ready scenes. */
    async ready() {
      const name = await chooseReady(store.get().hello?.ready ?? [], { link, dialogs });
      if (name && (await mayGo())) await openBy("ready", { name }, `${name}.yaml`);
    },

    /** Throw a random scene. */
    async random() {
      const answer = await dialogs.form({
        title: "Random scene",
        text: "The same numbers always give the same scene.",
        fields: [
          { name: "kind", label: "Kind", type: "select", value: thrown.kind, options: KINDS },
          { name: "robots", label: "Robots", type: "number", whole: true, min: 0, max: 1000, value: thrown.robots },
          { name: "obstacles", label: "Obstacles (open floor)", type: "number", whole: true, min: 0, max: 5000,
            value: thrown.obstacles },
          { name: "seed", label: "Seed", type: "number", whole: true, min: 0, max: Number.MAX_SAFE_INTEGER,
            value: thrown.seed },
        ],
        submit: "Make scene",
      });
      if (answer && (await mayGo())) await throwScene(/** @type {any} */ (answer.values));
    },

    /**
     * Open files that are dropped on a part of the page.
     * @param {HTMLElement} node
     * @returns {() => void} stops it
     */
    acceptDrops(node) {
      const over = (/** @type {DragEvent} */ event) => {
        if (!event.dataTransfer?.types.includes("Files")) return;
        event.preventDefault();
        node.classList.add("dropping");
      };
      const leave = () => node.classList.remove("dropping");
      const drop = (/** @type {DragEvent} */ event) => {
        event.preventDefault();
        leave();
        const [file] = event.dataTransfer?.files ?? [];
        if (file) void openFile(file);
      };
      const listeners = /** @type {const} */ ([["dragover", over], ["dragleave", leave], ["drop", drop]]);
      for (const [name, run] of listeners) node.addEventListener(name, /** @type {any} */ (run));
      return () => listeners.forEach(([name, run]) => node.removeEventListener(name, /** @type {any} */ (run)));
    },
  };
}

/** @typedef {ReturnType<typeof createFiles>} Files */

/** @param {string} path */
function nameOf(path) {
  return path.split(/[\\/]/).at(-1) ?? path;
}

/** @param {string} text */
function bytesInMessage(text) {
  return new Blob([JSON.stringify(text)]).size;
}

/**
 * @param {string} name
 * @param {number} bytes
 */
function tooLarge(name, bytes) {
  const [has, most] = [Math.ceil(bytes / 1e6), Math.floor(MOST_BYTES / 1e6)];
  return `${name} is too large: it takes ${has} MB, the studio opens up to ${most} MB.`;
}

/** @param {string} name of a file */
function stemOf(name) {
  return name.replace(/\.[a-z]+$/i, "");
}

/** @param {string} text */
function sentence(text) {
  return /[.!?]$/.test(text) ? text : `${text}.`;
}
