// @ts-check
// The link to the server: asks and answers over one WebSocket, and coming back when it is gone.

/** What the server found wrong with what was asked; `message` is one sentence. */
export class Wrong extends Error {
  /** @param {Record<string, any>} said */
  constructor(said) {
    super(said.message);
    this.name = "Wrong";
    this.said = said;
    this.kind = said.kind ?? null;
  }
}

/** An ask that ended without an answer: "newer", "cancelled" or "lost". */
export class Stopped extends Error {
  /** @param {string} reason */
  constructor(reason) {
    super(`stopped: ${reason}`);
    this.name = "Stopped";
    this.reason = reason;
  }
}

const FIRST_PAUSE = 250; // milliseconds before the first try to come back; each next one is twice as long
const LONGEST_PAUSE = 4000;
/** Bytes that one message may have. */
const LONGEST = 16 << 20;

/**
 * @typedef {{promise: Promise<any>, cancel: () => void, finish: () => void, id: number}} Asked what was asked;
 *   cancelled it ends as Stopped, finished with the best there is so far
 * @typedef {{lane?: string, progress?: (said: any) => void}} AskOptions
 * @typedef {{id: number, kind: string, frame: string, progress: (said: any) => void, resolve: (ok: any) => void,
 *   reject: (error: Error) => void, sent: boolean}} Pending
 */

/** The address of the link of this page, with the token that its own address has. */
function linkAddress() {
  const token = new URLSearchParams(location.search).get("token") ?? "";
  return `ws://${location.host}/link?token=${encodeURIComponent(token)}`;
}

/**
 * Open the link. Events: "hello" (what the server says first), "state" (of its workers), "up", "down" ({refused, reason}).
 * What is asked while the link is down waits for it; what was under way when it broke ends with Stopped("lost").
 * @param {string} [url]
 */
export function createLink(url = linkAddress()) {
  /** @type {Map<number, Pending>} */
  const pending = new Map();
  /** @type {Record<string, Set<(said: any) => void>>} */
  const listeners = {};
  /** @type {WebSocket | null} */
  let socket = null;
  let up = false;
  let ended = false;
  let pause = FIRST_PAUSE;
  let nextId = 1;
  let timer = 0;

  /** @param {string} event @param {any} [said] */
  const emit = (event, said) => {
    for (const listener of listeners[event] ?? []) listener(said);
  };

  /** @param {Pending} ask */
  const send = (ask) => {
    ask.sent = true;
    socket?.send(ask.frame);
  };

  /** @param {any} message */
  const receive = (message) => {
    if (message.hello) return greeted(message.hello);
    if (message.state) return emit("state", message.state);
    const ask = pending.get(message.id);
    if (!ask) return undefined;
    if (message.progress) return ask.progress(message.progress);
    pending.delete(ask.id);
    if ("ok" in message) return ask.resolve(message.ok);
    return ask.reject(message.wrong ? new Wrong(message.wrong) : new Stopped(message.stopped ?? "lost"));
  };

  const lost = () => {
    for (const ask of [...pending.values()].filter(({ sent }) => sent)) {
      pending.delete(ask.id);
      ask.reject(new Stopped("lost"));
    }
  };

  /** A link that is only opened to say why it is closed never comes here. @param {any} hello */
  const greeted = (hello) => {
    up = true;
    pause = FIRST_PAUSE;
    emit("up");
    for (const ask of pending.values()) send(ask);
    emit("hello", hello);
  };

  const connect = () => {
    socket = new WebSocket(url);
    socket.onmessage = ({ data }) => receive(JSON.parse(data));
    socket.onclose = async ({ reason }) => {
      up = false;
      lost();
      if (ended) return;
      emit("down", { refused: await refused(), reason });
      timer = setTimeout(connect, pause);
      pause = Math.min(2 * pause, LONGEST_PAUSE);
    };
  };

  connect();
  return {
    /**
     * Ask the server. Newer asks in the same lane stop older ones.
     * @param {string} kind
     * @param {Record<string, any>} [fields]
     * @param {AskOptions} [options]
     * @returns {Asked}
     */
    ask(kind, fields = {}, { lane, progress = () => {} } = {}) {
      const id = nextId++;
      const frame = JSON.stringify({ id, ask: kind, ...(lane ? { lane } : {}), ...fields });
      if (frame.length > LONGEST / 3 && new TextEncoder().encode(frame).length > LONGEST) {
        const message = "This is larger than 16 MB, more than the studio sends; take fewer corners or a smaller plan.";
        return { promise: Promise.reject(new Wrong({ message, kind: "size" })), cancel() {}, finish() {}, id };
      }
      const promise = new Promise((resolve, reject) => {
        const ask = { id, kind, frame, progress, resolve, reject, sent: false };
        pending.set(id, ask);
        if (up) send(ask);
      });
      const end = (/** @type {"cancel" | "finish"} */ how) => {
        const ask = pending.get(id);
        if (!ask) return;
        if (up && ask.sent) socket?.send(JSON.stringify({ [how]: id }));
        else {
          pending.delete(id);
          ask.reject(new Stopped("cancelled"));
        }
      };
      return { promise, cancel: () => end("cancel"), finish: () => end("finish"), id };
    },

    /**
     * Listen to an event; returns a function that ends it.
     * @param {string} event
     * @param {(said: any) => void} listener
     */
    on(event, listener) {
      (listeners[event] ??= new Set()).add(listener);
      return () => listeners[event].delete(listener);
    },

    isUp: () => up,

    /** Try now rather than when the pause is over. */
    retry() {
      if (up || ended) return;
      clearTimeout(timer);
      connect();
    },

    close() {
      ended = true;
      clearTimeout(timer);
      socket?.close();
    },
  };
}

/** @typedef {ReturnType<typeof createLink>} Link */

/** Whether a server is there but does not know this page's token: it was started anew. */
async function refused() {
  try {
    return (await fetch(location.href, { method: "HEAD", cache: "no-store" })).status === 403;
  } catch {
    return false;
  }
}
