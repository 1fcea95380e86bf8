/** All plans side by side: robots, bound, worst ratio, length, time; one is chosen to be watched. */

import { api } from "../api.js";
import { button, el } from "../dom.js";
import { confirmed, messageOf, notify } from "../notices.js";

const HELP = {
  "At least": "No plan with fewer robots exists; that is proved.",
  "Worst ratio": "The longest wait of any place over its period: 1 or less is met.",
  Length: "Of all loops together.",
  "Found in": "The time that planning took.",
};

export class Plans extends EventTarget {
  /** @param {HTMLElement} section */
  constructor(section) {
    super();
    this.plans = [];
    this.mission = null;
    this.chosen = null;
    this.everywhere = el("input", { type: "checkbox", id: "all-plans" });
    this.everywhere.addEventListener("change", () => this.draw());
    this.fault = el("p", { class: "fault", role: "alert" });
    this.table = el("div", { class: "scroll" });
    this.upload = el("input", { type: "file", accept: ".json", id: "plan-file" });
    this.upload.addEventListener("change", () => {
      const [file] = [...this.upload.files];
      this.upload.value = ""; // so that a file that was mended can be chosen again
      if (file !== undefined) {
        this.add(file);
      }
    });
    const all = el("div", { class: "row" }, this.everywhere, el("label", { for: "all-plans" }, "also those of other missions"));
    const add = el("div", { class: "field" }, el("label", { for: "plan-file" }, "Add a plan file (.rota.json); it is checked"), this.upload);
    section.append(el("h2", {}, "Plans"), all, this.fault, this.table, add);
  }

  /** Lists again; `mission` is the one that is open. */
  async refresh(mission = this.mission) {
    this.mission = mission;
    try {
      this.plans = await api.plans();
      this.fault.textContent = "";
    } catch (error) {
      this.fault.textContent = `Plans cannot be listed: ${messageOf(error)}`;
    }
    this.draw();
    this.dispatchEvent(new Event("listed"));
  }

  /** The plans of the mission that is open, and others if asked for; the newest first. */
  get shown() {
    return this.everywhere.checked ? this.plans : this.plans.filter((plan) => plan.mission !== null && plan.mission === this.mission);
  }

  find(id) {
    return this.plans.find((plan) => plan.id === id) ?? null;
  }

  choose(id) {
    this.chosen = id;
    this.draw();
  }

  draw() {
    const { shown } = this;
    if (shown.length === 0) {
      const others = this.plans.length > 0 ? " There are plans of other missions." : "";
      this.table.replaceChildren(el("p", { class: "soft" }, `No plan of this mission yet.${others}`));
      return;
    }
    const heads = ["Plan", "Robots", "At least", "Worst ratio", "Length", "Found in", ""].map((text) => el("th", { scope: "col", title: HELP[text] }, text));
    const rows = shown.map((plan) => this.row(plan));
    this.table.replaceChildren(el("table", {}, el("thead", {}, el("tr", {}, ...heads)), el("tbody", {}, ...rows)));
  }

  row(plan) {
    const chosen = plan.id === this.chosen;
    const name = this.everywhere.checked || !plan.planner ? plan.name : [plan.planner, plan.effort].filter(Boolean).join(", ");
    const watch = button(name, () => this.dispatchEvent(new CustomEvent("watch", { detail: plan.id })), { class: "link", "aria-pressed": String(chosen), "aria-label": `Watch ${name}, ${plan.robots} robots` });
    const verdict = el("span", { class: `state state-${plan.verdict === "met" ? "met" : "failed"}` }, plan.verdict ?? "?");
    const cells = [
      String(plan.robots),
      plan.bound === null ? "–" : String(plan.bound),
      typeof plan.worst_ratio === "number" ? plan.worst_ratio.toFixed(3) : "never seen",
      typeof plan.length_m === "number" ? lengthText(plan.length_m) : "–",
      typeof plan.plan_s === "number" ? `${plan.plan_s.toFixed(1)} s` : "–",
    ].map((text) => el("td", {}, text));
    const label = `${name}, ${plan.robots} robots`;
    const actions = el("td", {}, button("✕", () => this.remove(plan), { class: "quiet", "aria-label": `Delete ${label}`, title: "Delete" }));
    const first = el("td", {}, watch, " ", verdict, plan.partial ? el("span", { class: "state" }, "so far") : null);
    return el("tr", { "data-chosen": String(chosen) }, first, ...cells, actions);
  }

  async remove(plan) {
    if (!(await confirmed(`Delete the plan with ${plan.robots} robots? It cannot be brought back; planning with seed and effort as before gives it again.`, "Delete"))) {
      return;
    }
    // what is being loaded of it would come to nothing
    this.dispatchEvent(new CustomEvent("deleting", { detail: plan.id }));
    try {
      await api.deletePlan(plan.id);
      this.dispatchEvent(new CustomEvent("deleted", { detail: plan.id }));
      await this.refresh();
    } catch (error) {
      this.fault.textContent = `The plan could not be deleted: ${messageOf(error)}`;
    }
  }

  /** A plan file of somebody else. */
  async add(file) {
    this.fault.textContent = "Checking the plan…";
    try {
      const plan = await api.uploadPlan(file);
      this.fault.textContent = "";
      this.everywhere.checked = this.everywhere.checked || plan.mission !== this.mission;
      await this.refresh();
      notify(`${file.name}: ${plan.robots} robots, ${plan.verdict}.`);
    } catch (error) {
      this.fault.textContent = `${file.name}: ${messageOf(error)}`;
    }
  }
}

function lengthText(metres) {
  return metres >= 1000 ? `${(metres / 1000).toFixed(2)} km` : `${metres.toFixed(0)} m`;
}
