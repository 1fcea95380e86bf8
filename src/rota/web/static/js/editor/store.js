/**
 * The mission document, one immutable value per edit, with undo and redo.
 *
 * @typedef {any} MissionDocument a mission file as JSON
 */

const MOST_STEPS = 200;
const MERGE_MS = 1500;

export class DocumentStore extends EventTarget {
  /** @param {MissionDocument} document */
  constructor(document) {
    super();
    this.document = document;
    /** @type {MissionDocument[]} */
    this.past = [];
    /** @type {MissionDocument[]} */
    this.future = [];
    this.lastMerge = { name: "", at: 0 };
  }

  get canUndo() {
    return this.past.length > 0;
  }

  get canRedo() {
    return this.future.length > 0;
  }

  /**
   * A new value. Edits of one field in quick succession (the same `merge`) are one step of undo.
   * @param {MissionDocument} next
   * @param {string} merge
   */
  apply(next, merge = "") {
    if (next === this.document) {
      return;
    }
    const now = performance.now();
    const goesOn = merge !== "" && merge === this.lastMerge.name && now - this.lastMerge.at < MERGE_MS;
    if (!goesOn) {
      this.past = [...this.past.slice(-MOST_STEPS + 1), this.document];
    }
    this.lastMerge = { name: merge, at: now };
    this.future = [];
    this.set(next, "edit");
  }

  undo() {
    this.step(this.past, this.future, "undo");
  }

  redo() {
    this.step(this.future, this.past, "redo");
  }

  /** Another mission: nothing to undo. */
  load(document) {
    this.past = [];
    this.future = [];
    this.lastMerge = { name: "", at: 0 };
    this.set(document, "load");
  }

  step(from, to, why) {
    const next = from.pop();
    if (next === undefined) {
      return;
    }
    to.push(this.document);
    this.lastMerge = { name: "", at: 0 };
    this.set(next, why);
  }

  set(document, why) {
    this.document = document;
    this.dispatchEvent(new CustomEvent("change", { detail: why }));
  }
}
