/**
 * Keeps the mission on the server: saves soon after each edit, one request at a time, and says whether all is saved.
 *
 * @typedef {"new"|"saved"|"unsaved"|"saving"|"failed"} SavedState
 */

import { api, ApiError, connection } from "../api.js";
import { debounced } from "../dom.js";

const WAIT_MS = 600;

export class Keeper extends EventTarget {
  /** @param {import("./store.js").DocumentStore} store */
  constructor(store) {
    super();
    this.store = store;
    /** @type {string|null} */
    this.id = null;
    this.source = {}; // what a mission that is not yet on the server comes with: {upload}, or {example, as: its document}
    this.saved = null; // the document as the server has it
    /** @type {SavedState} */
    this.state = "new";
    this.problem = null;
    this.running = null;
    this.later = debounced(() => this.flush().catch(() => undefined));
    store.addEventListener("change", (event) => this.edited(/** @type {CustomEvent} */ (event).detail));
    connection.addEventListener("back", () => this.state === "failed" && this.later(WAIT_MS));
    window.addEventListener("beforeunload", (event) => {
      if (this.state !== "saved" && this.state !== "new") {
        event.preventDefault();
      }
    });
  }

  /** A mission of the server. */
  opened(id, document) {
    [this.id, this.saved, this.source] = [id, document, {}];
    this.later.cancel();
    this.set("saved");
  }

  /** A mission that the server has not kept yet. */
  fresh(source = {}) {
    [this.id, this.saved, this.source] = [null, null, source];
    this.later.cancel();
    this.set("new");
  }

  edited(why) {
    if (why === "load") {
      return;
    }
    this.set(this.store.document === this.saved ? "saved" : "unsaved");
    this.later(WAIT_MS);
  }

  /** Saves now what is not saved; resolves to the mission's id when it is. Rejects with what the server said. */
  async flush() {
    this.later.cancel();
    while (this.running !== null) {
      await this.running.catch(() => undefined);
    }
    if (this.id !== null && this.store.document === this.saved) {
      return this.id;
    }
    this.running = this.send();
    try {
      await this.running;
    } finally {
      this.running = null;
    }
    return this.store.document === this.saved ? this.id : this.flush();
  }

  async send() {
    const { document } = this.store;
    const before = this.id;
    this.set("saving");
    try {
      if (before === null) {
        this.saved = await this.create(document);
      } else {
        await api.saveMission(before, document);
        this.saved = document;
      }
      this.set(this.store.document === this.saved ? "saved" : "unsaved");
      if (before === null) {
        this.dispatchEvent(new Event("named"));
      }
    } catch (error) {
      if (error instanceof ApiError && error.status === 404 && before !== null) {
        this.id = null; // deleted elsewhere: it becomes a mission of its own again
      }
      this.problem = error;
      this.set("failed");
      throw error;
    }
  }

  /** Makes the mission on the server; resolves to the document that it has then. An example is kept as it is first. */
  async create(document) {
    const { example, as, ...others } = this.source;
    const { id } = await api.createMission(example === undefined ? { document, ...others } : { example });
    [this.id, this.source] = [id, {}];
    return example === undefined ? document : as;
  }

  /** @param {SavedState} state */
  set(state) {
    this.state = state;
    if (state !== "failed") {
      this.problem = null;
    }
    this.dispatchEvent(new Event("state"));
  }
}

const WORDS = { new: "nothing to save yet", saved: "✓ saved", unsaved: "● not saved yet", saving: "● saving…", failed: "✗ NOT SAVED" };

/** Shows the state in words and by colour. */
export function showSaved(keeper, sign, messageOf) {
  const show = () => {
    sign.dataset.state = keeper.state;
    const why = keeper.problem === null ? "" : `: ${messageOf(keeper.problem)}`;
    sign.textContent = `${WORDS[keeper.state]}${why}`;
  };
  keeper.addEventListener("state", show);
  show();
}
