// @ts-check
// The machine behind the tools: states, the events that each of them hears, and where these may lead.

/**
 * What a state does on an event: an action and the states that it may lead to (staying is always allowed).
 * An action gets the desk (what tools work on), the event and the state, and gives the next state or nothing.
 * @typedef {{name: string} & Record<string, any>} State
 * @typedef {(desk: any, event: any, state: any) => State | void} Action
 * @typedef {readonly [Action, ...string[]]} Transition
 * @typedef {Readonly<Record<string, Readonly<Record<string, Transition>>>>} Table
 */

/**
 * Make a machine. It throws where an action leads to a state that the table does not name: the table is the truth.
 * @param {Table} table
 * @param {any} desk
 * @param {State} first
 */
export function createMachine(table, desk, first) {
  let state = first;

  return {
    state: () => state,

    /** @param {State} next */
    put(next) {
      state = next;
    },

    /**
     * Tell the machine an event; whether its state hears such events.
     * @param {string} type
     * @param {any} [event]
     */
    send(type, event) {
      const transition = table[state.name]?.[type];
      if (!transition) return false;
      const [action, ...targets] = transition;
      const next = action(desk, event, state);
      if (next) {
        if (next.name !== state.name && !targets.includes(next.name)) {
          throw new Error(`${state.name} does not lead to ${next.name} on ${type}`);
        }
        state = next;
      }
      return true;
    },
  };
}
