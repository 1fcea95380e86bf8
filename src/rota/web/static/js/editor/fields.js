/**
 * Form fields that show a document's values and change them, each with its label, unit and faults.
 *
 * @typedef {(string|number)[]} Path
 */

import { el, freshId } from "../dom.js";
import { pathKey, startsWith, valueAt, withValue } from "./paths.js";

export class Fields {
  /** @param {import("./store.js").DocumentStore} store */
  constructor(store) {
    this.store = store;
    /** @type {{path: Path, input: any, show: (value: any) => void, fault: HTMLElement}[]} */
    this.bound = [];
    this.faults = [];
  }

  /** Shows the document's values and faults; a field in which somebody types keeps its text. */
  update() {
    this.bound = this.bound.filter((field) => field.input.isConnected);
    for (const field of this.bound) {
      if (field.input !== document.activeElement || field.input.tagName === "SELECT" || field.input.type === "checkbox") {
        field.show(valueAt(this.store.document, field.path));
      }
    }
    this.showFaults(this.faults);
  }

  /** Shows every value, also under the cursor: after undo, or when another mission is loaded. */
  refresh() {
    for (const field of this.bound) {
      field.show(valueAt(this.store.document, field.path));
    }
  }

  /** Shows each fault at the field that it is about, and returns those that have none. */
  showFaults(faults) {
    this.faults = faults;
    const texts = new Map();
    const homeless = [];
    for (const fault of faults) {
      const field = this.fieldFor(fault.path);
      if (field === null) {
        homeless.push(fault);
      } else {
        texts.set(field, [...(texts.get(field) ?? []), fault.message]);
      }
    }
    for (const field of this.bound) {
      const told = texts.get(field) ?? [];
      field.fault.textContent = told.join(" ");
      field.input.setAttribute("aria-invalid", String(told.length > 0));
    }
    return homeless;
  }

  /** The field at a path, else the nearest one around it; null where none is about it. */
  fieldFor(path) {
    const around = this.bound.filter((field) => field.path.length > 0 && startsWith(path, field.path));
    around.sort((a, b) => b.path.length - a.path.length);
    const within = path.length === 0 ? null : this.bound.find((field) => startsWith(field.path, path));
    return around[0] ?? within ?? null;
  }

  /** Moves to the field of a path, and unfolds what it is in; false where none is shown. */
  focus(path) {
    const field = this.fieldFor(path);
    const folded = "details:not([open])";
    for (let part = field?.input.closest(folded); part; part = part.parentElement.closest(folded)) {
      part.open = true;
    }
    field?.input.focus();
    field?.input.scrollIntoView({ block: "center" });
    return field !== null;
  }

  set(path, value) {
    this.store.apply(withValue(this.store.document, path, value), pathKey(path));
  }

  bind(path, input, show) {
    const fault = el("p", { class: "fault", id: freshId("fault") });
    input.setAttribute("aria-describedby", fault.id);
    input.dataset.path = pathKey(path);
    this.bound.push({ path, input, show, fault });
    show(valueAt(this.store.document, path));
    return fault;
  }

  field(label, input, fault, { unit = "", help = "" } = {}) {
    const id = freshId("field");
    input.id = id;
    const named = unit === "" ? label : `${label} (${unit})`;
    const parts = [el("label", { for: id }, named), input, help === "" ? null : el("span", { class: "field-help" }, help), fault];
    return el("div", { class: "field" }, ...parts);
  }

  /** A number; an empty field takes the key away, or gives `empty`. */
  number(path, label, { unit = "", help = "", step = "any", empty = undefined, placeholder = "" } = {}) {
    const input = el("input", { type: "number", step, inputmode: "decimal", placeholder });
    input.addEventListener("input", () => this.set(path, input.value === "" ? empty : Number(input.value)));
    const fault = this.bind(path, input, (value) => {
      input.value = typeof value === "number" ? String(value) : "";
    });
    return this.field(label, input, fault, { unit, help });
  }

  text(path, label, { help = "", placeholder = "" } = {}) {
    const input = el("input", { type: "text", autocomplete: "off", placeholder });
    input.addEventListener("input", () => this.set(path, input.value === "" ? undefined : input.value));
    const fault = this.bind(path, input, (value) => {
      input.value = typeof value === "string" ? value : "";
    });
    return this.field(label, input, fault, { help });
  }

  /** One of several; the value "" takes the key away. */
  choice(path, label, options, { help = "", other = undefined } = {}) {
    const choices = Object.entries(options).map(([value, name]) => el("option", { value }, name));
    const input = el("select", {}, ...choices);
    input.addEventListener("change", () => this.set(path, input.value === "" ? undefined : input.value));
    const fault = this.bind(path, input, (value) => {
      input.value = typeof value === "string" && value in options ? value : (other ?? Object.keys(options)[0]);
    });
    return this.field(label, input, fault, { help });
  }

  /** A field of the caller's own making. */
  custom(path, label, input, show, options = {}) {
    return this.field(label, input, this.bind(path, input, show), options);
  }
}

/**
 * Rebuilds a part of the page: the focus goes back where it was, by the path of the field or the name of the button, and
 * what was unfolded stays unfolded, by its summary and, where several have the same, whose it is (`data-of`).
 */
export function keepingFocus(section, rebuild) {
  const active = /** @type {HTMLElement|null} */ (document.activeElement);
  const mark = active !== null && section.contains(active) ? (active.dataset.path ?? active.dataset.mark) : undefined;
  const nameOf = (summary) => summary.textContent + (summary.dataset.of ?? "");
  const unfolded = [...section.querySelectorAll("details[open] > summary")].map(nameOf);
  rebuild();
  for (const summary of section.querySelectorAll("details > summary")) {
    summary.parentElement.open ||= unfolded.includes(nameOf(summary));
  }
  if (mark !== undefined) {
    const again = [...section.querySelectorAll("[data-path], [data-mark]")];
    again.find((element) => (element.dataset.path ?? element.dataset.mark) === mark)?.focus();
  }
}
