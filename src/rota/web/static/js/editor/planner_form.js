/** The planner and its settings; the fields are made of the schema of mission files. */

import { el } from "../dom.js";
import { keepingFocus } from "./fields.js";
import { changingSpeedAtOnce } from "./motion_fields.js";
import { withValue } from "./paths.js";
import { plain, worded } from "./schema_fields.js";

const FIRST_SETTINGS = ["effort", "task", "controller", "method"]; // shown before the rest is unfolded

export class PlannerForm {
  /**
   * @param {HTMLElement} section where planner and settings stand
   * @param {import("./fields.js").Fields} fields
   * @param {string[]} planners
   * @param {any} schema of mission files
   */
  constructor(section, fields, planners, schema) {
    this.section = section;
    this.fields = fields;
    this.planners = planners;
    this.schema = schema;
    this.kept = {}; // the settings of planners that are not chosen
    this.built = "";
  }

  get planner() {
    return this.fields.store.document.planner ?? this.planners[0];
  }

  update() {
    if (this.planner !== this.built) {
      this.built = this.planner;
      keepingFocus(this.section, () => this.build());
    }
  }

  build() {
    const properties = Object.entries(settingsOf(this.schema, this.planner));
    const isFirst = ([name]) => FIRST_SETTINGS.includes(name);
    const fieldsOf = (entries) => entries.map(([name, about]) => this.setting([this.planner, name], name, about));
    const rest = properties.filter((entry) => !isFirst(entry));
    const more = el("details", {}, el("summary", {}, "More settings"), el("div", { class: "fields" }, ...fieldsOf(rest)));
    const first = el("div", { class: "fields" }, this.choice(), ...fieldsOf(properties.filter(isFirst)));
    this.section.replaceChildren(...[el("h2", {}, "Planner"), first, rest.length > 0 ? more : null].filter((part) => part !== null));
    this.fields.update();
  }

  choice() {
    const select = el("select", {}, ...this.planners.map((value) => el("option", { value }, value)));
    select.addEventListener("change", () => this.choose(select.value));
    return this.fields.custom(["planner"], "Planner", select, (value) => (select.value = value ?? this.planners[0]));
  }

  /** Another planner; its settings are as they were when it was chosen last. */
  choose(planner) {
    const { document } = this.fields.store;
    this.kept[this.planner] = document[this.planner];
    const without = withValue(this.fleetFor(planner), [this.planner], undefined);
    this.fields.store.apply(withValue(withValue(without, ["planner"], planner), [planner], this.kept[planner]));
  }

  /** The document with a fleet that a planner takes: only patrol heeds motion. */
  fleetFor(planner) {
    const { document } = this.fields.store;
    if (planner === "patrol" || typeof document.fleet !== "object") {
      return document;
    }
    const free = (block) => changingSpeedAtOnce(block, this.schema);
    const { robots } = document.fleet;
    const fleet = { ...free(document.fleet), ...(Array.isArray(robots) ? { robots: robots.map(free) } : {}) };
    return withValue(document, ["fleet"], fleet);
  }

  setting(path, name, about) {
    const kind = plain(about);
    const [label, unit] = worded(name);
    const help = (about.description ?? kind.description ?? "").replaceAll("``", ""); // docstrings mark names so
    const unset = kind.default === undefined || kind.default === null ? "" : String(kind.default);
    if (kind.properties !== undefined) {
      const inner = Object.entries(kind.properties).map(([key, inside]) => this.setting([...path, key], key, inside));
      return el("details", {}, el("summary", {}, `${label} (${name})`), help === "" ? null : el("p", { class: "field-help" }, help), ...inner);
    }
    if (Array.isArray(kind.enum)) {
      const options = Object.fromEntries(kind.enum.map((value) => [value, value === kind.default ? `${value} (usual)` : value]));
      return this.fields.choice(path, label, options, { help, other: unset });
    }
    if (kind.type === "boolean") {
      return this.yesOrNo(path, label, help, kind.default === true);
    }
    if (kind.type === "number" || kind.type === "integer") {
      return this.fields.number(path, label, { unit, help, placeholder: unset, step: kind.type === "integer" ? "1" : "any" });
    }
    return kind.type === "array" ? this.numbers(path, label, unit, help, kind.default) : this.fields.text(path, label, { help, placeholder: unset });
  }

  yesOrNo(path, label, help, usual) {
    const select = el("select", {}, el("option", { value: "true" }, "yes"), el("option", { value: "false" }, "no"));
    select.addEventListener("change", () => this.fields.set(path, select.value === "true"));
    return this.fields.custom(path, label, select, (value) => (select.value = String(value ?? usual)), { help });
  }

  /** Several numbers in one field, with commas between. */
  numbers(path, label, unit, help, usual) {
    const input = el("input", { type: "text", autocomplete: "off", placeholder: Array.isArray(usual) ? usual.join(", ") : "" });
    input.addEventListener("input", () => {
      const texts = input.value.split(",").map((text) => text.trim()).filter((text) => text !== "");
      // what is no number goes to the server as text: its fault is shown here
      const values = texts.map((text) => (Number.isFinite(Number(text)) ? Number(text) : text));
      this.fields.set(path, values.length === 0 ? undefined : values);
    });
    const show = (value) => (input.value = Array.isArray(value) ? value.join(", ") : "");
    return this.fields.custom(path, label, input, show, { unit, help: `${help}${help === "" ? "" : ". "}Numbers with commas between.` });
  }
}

/** The settings of a planner in the schema: their names and what they may be. */
export function settingsOf(schema, planner) {
  return plain(schema.properties?.[planner] ?? {}).properties ?? {};
}
