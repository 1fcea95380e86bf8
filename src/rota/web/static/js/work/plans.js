/** All plans side by side: robots, bound, worst ratio, length, time; one is chosen to be watched. */

import { api } from "../api.js";
import { button, el } from "../dom.js";
import { confirmed, messageOf, notify } from "../notices.js";
import { changeText, changesText, isStale, verdictBadge } from "./stale.js";

const HELP = {
  Least: "No plan with fewer robots exists; that is proved.",
  Ratio: "The longest wait of any place over its period: 1 or less is met.",
  Length: "Of all loops together.",
  Time: "The time that planning took.",
};

export class Plans extends EventTarget {
  /** @param {HTMLElement} section */
  constructor(section) {
    super();
    this.plans = [];
    this.mission = null;
    this.chosen = null;
    this.soFar = null; // the best plan of a job that runs
    this.isPlanning = false; // whether a job of the mission waits or runs
    this.unsure = false; // whether the mission has edits that no list knows of yet
    this.asked = 0;
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
    if (mission !== this.mission) {
      this.mission = mission;
      this.draw();
    }
    this.asked += 1;
    const number = this.asked;
    try {
      const plans = await api.plans();
      if (number !== this.asked) {
        return; // asked again since
      }
      this.plans = plans;
      this.unsure = false;
      this.fault.textContent = "";
    } catch (error) {
      this.fault.textContent = `Plans cannot be listed: ${messageOf(error)}`;
    }
    this.draw();
    this.dispatchEvent(new Event("listed"));
  }

  /** Of plans of a mission that is being changed nobody knows yet whether they hold. */
  doubt() {
    if (!this.unsure && this.shown.length > 0) {
      this.unsure = true;
      this.draw();
      this.dispatchEvent(new Event("listed"));
    }
  }

  /** The plan that is shown when none was chosen: the newest that holds and is met, or the newest; none that takes over. */
  get best() {
    const isOwn = (plan) => plan.mission !== null && plan.mission === this.mission && !plan.change;
    const own = this.plans.filter(isOwn);
    return own.find((plan) => !isStale(plan) && plan.verdict === "met") ?? own[0] ?? null;
  }

  /** The best plan so far of a job of this mission, null for none; and whether such a job waits or runs. */
  showPlanning(isPlanning, soFar) {
    if (isPlanning !== this.isPlanning || soFar !== this.soFar) {
      [this.isPlanning, this.soFar] = [isPlanning, soFar];
      this.draw();
    }
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
    const { shown, soFar } = this;
    if (shown.length === 0 && soFar === null) {
      const others = this.plans.length > 0 ? " There are plans of other missions." : "";
      const words = this.isPlanning ? "The first plan stands here as soon as it is found." : `No plan of this mission yet.${others}`;
      this.table.replaceChildren(el("p", { class: "soft" }, words));
      return;
    }
    const heads = ["Plan", "Robots", "Least", "Ratio", "Length", "Time"].map((text) => el("th", { scope: "col", title: HELP[text] }, text));
    const rows = [...(soFar === null ? [] : [soFar]), ...shown].flatMap((plan) => this.rows(plan));
    this.table.replaceChildren(el("table", {}, el("thead", {}, el("tr", {}, ...heads, el("td"))), el("tbody", {}, ...rows)));
  }

  /** A plan's row, and below it, where it is stale, why. */
  rows(plan) {
    const isSoFar = plan === this.soFar;
    const chosen = plan.id === this.chosen || (isSoFar && this.chosen === null);
    const kind = this.everywhere.checked || !plan.planner ? [plan.name] : [plan.planner, plan.effort];
    const name = [...kind, changeText(plan)].filter(Boolean).join(", ");
    const watch = button(name, () => this.dispatchEvent(new CustomEvent("watch", { detail: isSoFar ? null : plan.id })), { class: "link", "aria-pressed": String(chosen), "aria-label": `Watch ${name}, ${plan.robots} robots` });
    const verdict = verdictBadge(plan, this.unsure && plan.mission === this.mission);
    const cells = [
      String(plan.robots),
      plan.bound === null ? "–" : String(plan.bound),
      ratioText(plan),
      plan.length_m > 0 ? lengthText(plan.length_m) : "–",
      typeof plan.plan_s === "number" ? `${plan.plan_s.toFixed(1)} s` : "–",
    ].map((text) => el("td", {}, text));
    const label = `${name}, ${plan.robots} robots`;
    const actions = el("td", {}, isSoFar ? null : button("✕", () => this.remove(plan), { class: "quiet", "aria-label": `Delete ${label}`, title: "Delete" }));
    const short = plan.partial ? el("span", { class: "state", title: isSoFar ? "" : "The search was cut short, or the demand is not met" }, "so far") : null;
    const first = el("td", {}, watch, " ", verdict, " ", short);
    const row = el("tr", { "data-chosen": String(chosen) }, first, ...cells, actions);
    const why = () => el("tr", { class: "why", "data-chosen": String(chosen) }, el("td", { colspan: cells.length + 2 }, changesText(plan)));
    return isStale(plan) && !this.unsure ? [row, why()] : [row];
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
      this.fault.textContent = `${file.name}: ${messageOf(error, { ofFile: true })}`;
    }
  }
}

/** Robots that stand still keep nobody waiting, and swarms have no periods. */
function ratioText(plan) {
  if (plan.worst_ratio === 0) {
    return "–";
  }
  return typeof plan.worst_ratio === "number" ? plan.worst_ratio.toFixed(3) : "never seen";
}

function lengthText(metres) {
  return metres >= 1000 ? `${(metres / 1000).toFixed(2)} km` : `${metres.toFixed(0)} m`;
}
