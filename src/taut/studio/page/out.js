// @ts-check
// What leaves the studio: files, pictures, animations, a page to send, the command line and the Python snippet.

import { announce } from "studio/announce.js";
import { modal, toast } from "studio/dialogs.js";
import { element } from "studio/dom.js";
import { download } from "studio/download.js";
import { icon } from "studio/icons.js";
import { Stopped, Wrong } from "studio/link.js";
import { liveSettings } from "studio/planner_settings.js";
import { contactOf } from "studio/timelines_asking.js";

/** Forms of export: [form, name, what it is, whether it needs a plan]. */
const FORMS = /** @type {[string, string, string, boolean][]} */ ([
  ["scene-yaml", "Scene, YAML", "the map and the robots, to read and to edit", false],
  ["scene-json", "Scene, JSON", "the same for programs", false],
  ["plan", "Plan", "motions with certificate, for taut verify and simulate", true],
  ["png", "Picture, PNG", "for documents and messages", true],
  ["svg", "Picture, SVG", "sharp at any size, for papers", true],
  ["gif", "Animation, GIF", "moves everywhere", true],
  ["mp4", "Animation, MP4", "smaller and finer; needs ffmpeg on this machine", true],
  ["html", "Page, HTML", "one file that plays in any browser, to send to a colleague", true],
]);

/**
 * Open the dialog of exports.
 * @param {import("studio/store.js").Store} store
 * @param {import("studio/link.js").Link} link
 */
export function openOut(store, link) {
  const { answer, revision } = store.get();
  const fresh = Boolean(answer) && answer.revision === revision;
  /** @type {import("studio/link.js").Asked | null} */
  let running = null;
  const words = element("p", { class: "quiet", role: "status" },
    fresh ? "" : "There is no plan of the scene as it is: only the scene can be written.");
  const command = snippet("Command line", "command");
  const python = snippet("Python", "python");
  const dialog = modal({
    title: "Export",
    wide: true,
    body: [
      element("div", { class: "forms" }, ...FORMS.map(([form, name, about, needsPlan]) =>
        element("button", { type: "button", class: "form-choice", "data-form": form, disabled: needsPlan && !fresh,
          onclick: () => write(form, name) },
        icon("out"), element("span", {}, element("b", {}, name), element("span", { class: "quiet" }, about))))),
      words,
      command.node,
      python.node,
    ],
  });
  dialog.done.then(() => running?.cancel());
  showSnippets();

  async function showSnippets() {
    const name = sourceOf(store.get());
    const settings = fresh && answer.sent ? repeating(answer) : liveSettings(store.get().settings);
    const found = await link.ask("snippet", { settings, name }).promise.catch(() => null);
    if (found) {
      command.show(found.command);
      python.show(found.python);
    }
  }

  /**
   * @param {string} form
   * @param {string} name
   */
  async function write(form, name) {
    running?.cancel();
    const { scene } = store.get();
    words.textContent = `${name}: being made…`;
    const options = form === "html" ? { conflicts: answer.conflicts, ...contactOf(store.get()) } : {};
    const asked = link.ask("export", { scene, plan: fresh ? answer.plan : null, form, options },
      { lane: "out", progress: ({ text }) => (words.textContent = `${name}: ${text}`) });
    running = asked;
    try {
      const made = await asked.promise;
      download(made);
      words.textContent = `${made.name} is in your downloads.`;
      announce(words.textContent);
    } catch (error) {
      if (error instanceof Stopped && error.reason !== "lost") return;
      words.textContent = error instanceof Wrong ? error.message : "The server did not answer; try again.";
    } finally {
      if (running === asked) running = null;
    }
  }
}

/**
 * The settings that make a plan again: time makes no two plans the same, the rounds that were done in it do.
 * @param {any} answer
 * @returns {import("studio/planner_settings.js").Settings}
 */
function repeating({ sent, plan }) {
  const { seconds, ...others } = sent;
  const rounds = plan.planner?.rounds;
  return seconds && rounds > 0 ? { ...others, rounds } : sent;
}

/**
 * What a command reads to plan this scene: its file, or the name of the ready scene that it still is.
 * @param {Record<string, any>} state
 * @returns {string}
 */
function sourceOf({ file, hello }) {
  const name = file?.path ?? file?.name ?? "scene.yaml";
  const stem = name.replace(/\.ya?ml$/, "");
  const ready = !file?.path && !file?.dirty && hello?.ready?.some((/** @type {any} */ one) => one.name === stem);
  return ready ? stem : name;
}

/**
 * A text with a button that copies it.
 * @param {string} label
 * @param {string} id
 */
function snippet(label, id) {
  const text = element("pre", { id: `snippet-${id}`, tabindex: 0, "aria-label": label });
  const copy = element("button", { type: "button", class: "button", onclick: async () => {
    await navigator.clipboard.writeText(text.textContent ?? "");
    toast(`${label} copied`, { kind: "good" });
  } }, "Copy");
  return {
    node: element("section", { class: "snippet" }, element("div", { class: "row" }, element("h3", {}, label), copy), text),
    /** @param {string} words */
    show: (words) => (text.textContent = words),
  };
}
