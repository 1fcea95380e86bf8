/**
 * Keeps the mission on the server: saves soon after each edit, one request at a time, and says whether all is saved.
 *
 * A save names the revision that it was made from; what was changed elsewhere since is never overwritten unasked.
 *
 * @typedef {"new"|"saved"|"unsaved"|"saving"|"failed"|"conflict"} SavedState
 */

import { api, ApiError, connection } from "../api.js";
import { byId, debounced } from "../dom.js";

const WAIT_MS = 600;
const AGAIN_MS = 4000; // after a server that could not save; each time twice as long
const MOST_AGAIN_MS = 60000;

export class Keeper extends EventTarget {
  /** @param {import("./store.js").DocumentStore} store */
  constructor(store) {
    super();
    this.store = store;
    /** @type {string|null} */
    this.id = null;
    this.revision = null; // of what is saved, as the server counts them
    this.opening = 0; // counts the missions that were opened: an answer for one before is dropped
    this.again_ms = AGAIN_MS;
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
  opened(id, document, revision) {
    this.begin(id, document, revision, {});
    this.set("saved");
  }

  /** A mission that the server has not kept yet. */
  fresh(source = {}) {
    this.begin(null, null, null, source);
    this.set("new");
  }

  begin(id, document, revision, source) {
    [this.id, this.saved, this.revision, this.source] = [id, document, revision, source];
    this.opening += 1;
    this.later.cancel();
  }

  edited(why) {
    if (why === "load" || this.state === "conflict") {
      return; // a conflict waits for its answer
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

  /** Saves over what was changed elsewhere. */
  async keepMine() {
    const { opening } = this;
    const { revision } = await api.mission(this.id);
    if (opening === this.opening) {
      this.revision = revision;
      await this.flush();
    }
  }

  async send() {
    const { document } = this.store;
    const { id: before, opening } = this;
    this.set("saving");
    try {
      const kept = before === null ? await this.create(document) : { ...(await api.saveMission(before, document, this.revision)), saved: document };
      if (opening !== this.opening) {
        return;
      }
      [this.id, this.revision, this.saved, this.source] = [kept.id, kept.revision, kept.saved, {}];
      this.again_ms = AGAIN_MS;
      this.set(this.store.document === this.saved ? "saved" : "unsaved");
      if (before === null) {
        this.dispatchEvent(new Event("named"));
      }
    } catch (error) {
      if (opening === this.opening) {
        this.failed(error, before);
      }
      throw error;
    }
  }

  /** Says why it is not saved, and tries again where the server could not; what it refuses waits for an edit. */
  failed(error, before) {
    const status = error instanceof ApiError ? error.status : null;
    if (status === 404 && before !== null) {
      [this.id, this.revision] = [null, null]; // deleted elsewhere: it becomes a mission of its own again
    }
    this.problem = error;
    this.set(status === 409 && before !== null ? "conflict" : "failed");
    if (status === 429 || status >= 500) {
      this.later(this.again_ms);
      this.again_ms = Math.min(2 * this.again_ms, MOST_AGAIN_MS);
    }
  }

  /** Makes the mission on the server; `saved`: the document that it has then. An example is kept as it is first. */
  async create(document) {
    const { example, as, ...others } = this.source;
    const made = await api.createMission(example === undefined ? { document, ...others } : { example });
    return { ...made, saved: example === undefined ? document : as };
  }

  /** @param {SavedState} state */
  set(state) {
    this.state = state;
    if (state !== "failed" && state !== "conflict") {
      this.problem = null;
    }
    this.dispatchEvent(new Event("state"));
  }
}

const WORDS = { new: "nothing to save yet", saved: "✓ saved", unsaved: "● not saved yet", saving: "● saving…", failed: "✗ NOT SAVED", conflict: "✗ NOT SAVED" };

/** Shows the state in words and by colour. */
export function showSaved(keeper, sign, messageOf) {
  const show = () => {
    byId("conflict").hidden = keeper.state !== "conflict";
    sign.dataset.state = keeper.state;
    const again = keeper.state === "failed" && keeper.problem?.status >= 429 ? "; it is tried again" : "";
    const why = keeper.problem === null ? "" : keeper.state === "conflict" ? ": changed elsewhere" : `: ${messageOf(keeper.problem)}${again}`;
    sign.textContent = `${WORDS[keeper.state]}${why}`;
  };
  keeper.addEventListener("state", show);
  show();
}
