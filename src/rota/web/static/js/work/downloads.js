/** What can be taken away: the plan file, a picture, a page of its own, and every format of robots. */

import { api } from "../api.js";
import { button, el, saveBlob } from "../dom.js";
import { messageOf } from "../notices.js";
import { isStale, robotsText, staleNote } from "./stale.js";

const OWN = [
  { file: "plan.rota.json", name: "Plan file", what: "all of the plan; rota check, draw and export read it" },
  { file: "picture.png", name: "Picture", what: "ground, zones and routes as PNG" },
  { file: "page.html", name: "Page", what: "one file with the player; opens from disk without a network" },
];

export class Downloads {
  /**
   * @param {HTMLElement} section
   * @param {any[]} formats as the server lists them
   */
  constructor(section, formats) {
    this.formats = formats;
    this.plan = null;
    this.title = el("p", {});
    this.note = el("div", {});
    this.fault = el("p", { class: "fault", role: "alert" });
    this.origin = el("input", { type: "text", id: "origin", placeholder: "54.36, 13.08", autocomplete: "off" });
    this.start = el("input", { type: "datetime-local", step: "1", id: "start-time" });
    this.body = el("div", { class: "plain" });
    section.append(el("h2", {}, "Take away"), this.title, this.note, this.fault, this.body);
  }

  /** Shows what can be taken of a plan, null for none; `unsure`: its mission has edits that are not saved yet. */
  show(plan, { unsure = false, isPlanning = false } = {}) {
    const isAnother = plan?.id !== this.plan?.id;
    this.plan = plan;
    this.fault.textContent = "";
    if (plan === null) {
      this.title.textContent = isPlanning ? "Planning goes on: the first plan can be taken as soon as it is found." : "There is no plan yet: make one in step 2.";
      this.body.replaceChildren();
      return;
    }
    const which = plan.partial ? "the best plan so far of" : "the plan";
    const goesOn = plan.partial ? " A longer search may find a better one." : "";
    const verdict = unsure || isStale(plan) ? "" : `, ${plan.verdict}`;
    const note = staleNote(plan, unsure);
    const names = note === null || unsure ? [] : [el("p", { class: "soft" }, "Names of files say so: -stale. The plan file says what has changed.")];
    this.title.replaceChildren(`Of ${which} ${plan.name}: ${robotsText(plan)}${verdict}.${goesOn}`);
    this.note.replaceChildren(...(note === null ? [] : [note, ...names]));
    if (!isAnother && this.body.childElementCount > 0) {
      return; // what was typed stays
    }
    const field = (label, input, help) => el("div", { class: "field" }, el("label", { for: input.id }, label), input, el("span", { class: "field-help" }, help));
    const asked = el(
      "div",
      { class: "fields" },
      field("Origin: latitude, longitude (°)", this.origin, "Where the plan's (0, 0) lies; only for missions without a place on the globe."),
      field("Start time (your clock)", this.start, "For formats with a clock; empty: theirs."),
    );
    const own = OWN.map((entry) => this.row(entry.name, entry.what, () => api.planFile(plan.id, entry.file), entry.file));
    const formats = this.formats.map((format) => this.row(format.name, format.what, () => this.exportOf(format), format.name));
    const list = (rows) => el("ul", { class: "plain" }, ...rows);
    this.body.replaceChildren(list(own), el("h3", {}, "For robots, maps and tools"), asked, list(formats));
  }

  row(name, what, address, mark) {
    const fault = el("p", { class: "fault", role: "alert" });
    const take = button(name, () => this.take(take, address(), fault), { "data-download": mark });
    return el("li", {}, el("div", { class: "row" }, take, el("span", { class: "soft grow" }, what)), fault);
  }

  exportOf(format) {
    const origin = this.origin.value.replaceAll(" ", "");
    const query = {
      origin: format.takes_origin === false ? "" : origin,
      start_time: this.start.value === "" || format.has_clock === false ? "" : new Date(this.start.value).toISOString(),
    };
    return api.planFile(this.plan.id, `export/${encodeURIComponent(format.name)}`, query);
  }

  async take(from, address, fault) {
    fault.textContent = "";
    from.disabled = true;
    from.setAttribute("aria-busy", "true");
    try {
      const { blob, name } = await api.download(address);
      saveBlob(blob, name);
    } catch (error) {
      fault.textContent = messageOf(error);
    } finally {
      from.disabled = false;
      from.removeAttribute("aria-busy");
      from.focus();
    }
  }
}
