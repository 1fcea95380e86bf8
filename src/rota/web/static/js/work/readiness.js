/** Whether the mission can be planned: what hinders it is told beside the button, which then does nothing else. */

import { el } from "../dom.js";
import { countOf, faultList } from "../editor/verdict.js";

const PATIENCE_MS = 4000; // a mission whose checking takes longer is judged by the server when planning begins

export class Readiness {
  /**
   * @param {HTMLElement} button that plans
   * @param {import("../editor/editor.js").Editor} editor
   */
  constructor(button, editor) {
    this.button = button;
    this.editor = editor;
    this.box = el("div", { class: "verdict-fault", role: "alert", id: "hindrance", hidden: true });
    button.before(this.box);
    editor.validation.addEventListener("asking", () => this.show());
    editor.validation.addEventListener("result", () => this.show());
    this.show();
  }

  get faults() {
    const { isEmpty, validation } = this.editor;
    const known = validation.busy ? [] : (validation.latest?.faults ?? []);
    return isEmpty ? [{ path: ["area"], message: "nothing is drawn yet" }] : known;
  }

  show() {
    const { faults } = this;
    this.box.hidden = faults.length === 0;
    this.box.replaceChildren(...(faults.length === 0 ? [] : [countOf(faults), faultList(faults, this.editor)]));
    this.button.setAttribute("aria-disabled", String(faults.length > 0));
  }

  /** Resolves to whether planning may begin; the check of an edit a moment ago is waited for. */
  async mayPlan() {
    await this.editor.validation.settled(PATIENCE_MS);
    this.show();
    if (this.faults.length > 0) {
      this.box.scrollIntoView({ block: "center" });
    }
    return this.faults.length === 0;
  }
}
