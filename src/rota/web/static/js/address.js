/** The address names mission, tab and plan: a reload comes back to them, and Back goes to the mission or tab before. */

const KEYS = ["mission", "tab", "plan"];

/** @typedef {{mission: string|null, tab: string|null, plan: string|null}} Shown */

export class Address {
  constructor() {
    this.following = 0; // while the page goes where the address says
  }

  /** @returns {Shown} */
  get shown() {
    const parts = new URLSearchParams(window.location.hash.slice(1));
    return /** @type {any} */ (Object.fromEntries(KEYS.map((key) => [key, parts.get(key)])));
  }

  /**
   * Goes where the address says; whatever is shown on the way is no step of its own.
   * @param {(shown: Shown) => Promise<void>} go
   */
  async follow(go) {
    this.following += 1;
    try {
      await go(this.shown);
    } finally {
      this.following -= 1;
    }
  }

  /**
   * Names what is shown now. Another tab or mission is a step that Back undoes; a name or a plan that comes is none.
   * @param {Shown} now
   */
  write(now) {
    const before = this.shown;
    const hash = `#${new URLSearchParams(Object.entries(now).filter(([, value]) => value !== null))}`;
    if (hash === window.location.hash) {
      return;
    }
    const moved = (before.tab !== null && before.tab !== now.tab) || (before.mission !== null && before.mission !== now.mission);
    if (moved && this.following === 0) {
      window.history.pushState(null, "", hash);
    } else {
      window.history.replaceState(null, "", hash);
    }
  }
}
