/** Asks the server what is wrong with the mission, and what is proved of it; the newest question wins. */

import { api, ApiError } from "../api.js";
import { debounced } from "../dom.js";

const WAIT_MS = 350;
const COMPILING_MS = 2000; // the proved bound comes when Rota has compiled itself

/** @typedef {{faults: import("../api.js").Fault[], warnings: string[], ground: any, bound: any, free_m2: any, asked_m2_s: any}} Validity */

export class Validation extends EventTarget {
  /** @param {() => {document: any, mission: string|null, upload?: string}} question */
  constructor(question) {
    super();
    this.question = question;
    this.running = null;
    this.busy = false;
    /** @type {Validity|null} */
    this.latest = null;
    this.later = debounced(() => this.ask());
  }

  /** Another mission: nothing is known of it, and no answer to a question before counts. */
  forget() {
    this.later.cancel();
    this.running?.abort();
    this.running = null;
    this.latest = null;
    this.tell("forgotten");
  }

  /** Asks soon; what was asked before does not count any more. */
  soon(wait_ms = WAIT_MS) {
    this.tell("asking");
    this.later(wait_ms);
  }

  /** Asks nothing yet: what the mission needs is not there; whoever waits for it asks then. */
  wait() {
    this.later.cancel();
    this.running?.abort();
    this.running = null;
    this.tell("asking");
  }

  async ask() {
    this.later.cancel();
    this.tell("asking");
    this.running?.abort();
    const running = new AbortController();
    this.running = running;
    const { document, mission, ...more } = this.question();
    try {
      const body = mission === null ? { document, ...more } : { document, mission };
      const answer = await api.validate(body, running.signal);
      if (running === this.running && document === this.question().document) {
        this.latest = answer;
        this.tell("result", answer);
        if (answer.compiling) {
          this.soon(COMPILING_MS);
        }
      }
    } catch (error) {
      if (running === this.running && document === this.question().document && !(error instanceof DOMException)) {
        this.failed(error);
      }
    }
  }

  failed(error) {
    if (error instanceof ApiError && error.status === 409) {
      return; // a newer question of another page won; ours is asked again with the next edit
    }
    this.tell("failed", error);
  }

  /** Resolves when the newest question is answered, and after so long in any case. */
  settled(within_ms) {
    return new Promise((resolve) => {
      const timer = window.setTimeout(resolve, this.busy ? within_ms : 0);
      for (const end of ["result", "failed"]) {
        this.addEventListener(end, () => resolve(clearTimeout(timer)), { once: true });
      }
    });
  }

  tell(name, detail = null) {
    this.busy = name === "asking";
    this.dispatchEvent(new CustomEvent(name, { detail }));
  }
}
