/** The list of all shapes: choose, name, set periods, type coordinates, add by numbers, delete. */

import { button, el } from "../dom.js";
import { coordinateTable } from "./coordinate_table.js";
import { FORMS, KINDS, isPlaces } from "./drawing.js";
import { keepingFocus } from "./fields.js";
import { pathKey, withValue } from "./paths.js";
import { isEditable, pointsOf, shapesOf } from "./shapes.js";

const MOST_OPEN_ZONES = 60; // beyond, only the chosen zone shows its fields
const MANY = 12; // beyond, the list has a scroll bar of its own, and a field to find shapes in it

export class ShapeList extends EventTarget {
  /**
   * @param {HTMLElement} section
   * @param {import("./fields.js").Fields} fields
   */
  constructor(section, fields) {
    super();
    this.section = section;
    this.fields = fields;
    this.built = "";
    this.chosen = null;
    this.open = new Set();
    this.adding = this.addForm();
    this.list = el("div", { class: "plain shapes" });
    this.cards = new Map(); // closed cards by their keys, which most edits leave as they are
    this.count = el("span", { class: "soft" });
    this.find = el("input", { type: "search", placeholder: "Find by name", "aria-label": "Find shapes", on: { input: () => this.filter() } });
    this.finding = el("div", { class: "row finding", hidden: true }, this.find, this.count);
    section.append(el("h2", {}, "Shapes"), this.finding, this.list, this.adding);
  }

  /** @param {string|null} chosen the key of the chosen shape */
  update(chosen) {
    const { document } = this.fields.store;
    const shapes = shapesOf(document);
    this.chosen = chosen;
    const parts = shapes.map((shape) => [shape.key, shape.geometry.type, pointsOf(shape.geometry).length, ["zone", "obstacle"].includes(shape.kind) ? "" : shape.name]);
    const built = JSON.stringify([chosen, document.coordinates, parts, chosen === null ? 0 : this.coordinatesOf(shapes, chosen)]);
    if (built !== this.built) {
      this.built = built;
      keepingFocus(this.list, () => this.build(shapes));
    } else {
      this.rename(shapes);
    }
  }

  /** Coordinates of the chosen shape, unless somebody types in its table. */
  coordinatesOf(shapes, chosen) {
    const table = this.list.querySelector(".coordinates");
    const shape = shapes.find((other) => other.key === chosen);
    return table !== null && table.contains(document.activeElement) && document.activeElement?.tagName === "INPUT"
      ? pointsOf(shape?.geometry ?? { type: "reference" }).length
      : (shape?.geometry ?? null);
  }

  rename(shapes) {
    for (const shape of shapes) {
      const name = this.list.querySelector(`[data-name-of="${CSS.escape(shape.key)}"]`);
      if (name !== null && name.textContent !== shape.name) {
        name.textContent = shape.name;
      }
    }
  }

  build(shapes) {
    const zones = shapes.filter((shape) => shape.kind === "zone").length;
    const cards = shapes.map((shape) => {
      const chosen = shape.key === this.chosen;
      return chosen || (shape.kind === "zone" && zones <= MOST_OPEN_ZONES) ? this.card(shape, true) : this.closedCard(shape);
    });
    const nothing = el("p", { class: "soft" }, "Nothing is drawn yet. Press Area above the map and click its corners, or open an example under Missions.");
    const many = cards.length > MANY;
    const { scrollTop } = this.list;
    this.list.replaceChildren(...(cards.length === 0 ? [nothing] : cards));
    this.list.classList.toggle("shapes-many", many);
    this.list.scrollTop = scrollTop;
    this.finding.hidden = !many;
    if (!many) {
      this.find.value = "";
    }
    this.filter();
    this.fields.update();
    const chosen = this.list.querySelector("[data-chosen=true]");
    if (many && chosen !== null && chosen.dataset.key !== this.seen) {
      this.list.scrollTop += chosen.getBoundingClientRect().top - this.list.getBoundingClientRect().top;
    }
    this.seen = chosen?.dataset.key ?? null;
  }

  /** A card without fields, the one from before where it says the same. */
  closedCard(shape) {
    const says = JSON.stringify([shape.kind, shape.name, summaryOf(shape)]);
    const before = this.cards.get(shape.key);
    if (before?.says === says) {
      return before.card;
    }
    const card = this.card(shape, false);
    this.cards.set(shape.key, { says, card });
    return card;
  }

  /** Shows the shapes whose names hold what is looked for, and the chosen one. */
  filter() {
    const wanted = this.find.value.trim().toLowerCase();
    const cards = [...this.list.querySelectorAll(".card")];
    for (const card of cards) {
      const name = card.querySelector("[data-name-of]").textContent.toLowerCase();
      card.hidden = wanted !== "" && !name.includes(wanted) && card.dataset.chosen !== "true";
    }
    this.count.textContent = `${cards.filter((card) => !card.hidden).length} of ${cards.length}`;
  }

  card(shape, open) {
    const chosen = shape.key === this.chosen;
    const choose = button(shape.name, () => this.tell("choose", shape.key), { class: "link grow", "data-name-of": shape.key, "aria-pressed": String(chosen), "data-mark": `choose ${shape.key}` });
    const remove = button("Delete", () => this.tell("delete", shape.path), { class: "quiet", "aria-label": `Delete ${shape.name}` });
    const card = el("div", { class: "card", "data-kind": shape.kind, "data-key": shape.key, "data-chosen": String(chosen) });
    card.append(el("div", { class: "row" }, choose, el("span", { class: "soft" }, summaryOf(shape)), remove));
    if (open) {
      card.append(...this.ownFields(shape));
    }
    if (chosen) {
      card.append(this.coordinates(shape));
    }
    return card;
  }

  ownFields(shape) {
    const { fields } = this;
    const { path } = shape;
    if (shape.kind === "zone") {
      const period = fields.number([...path, "period_s"], "Period", { unit: "s", empty: null });
      const demand = fields.choice([...path, "demand"], "Asked", { every_point: "every point is seen", visit: "a robot enters" });
      return [el("div", { class: "fields" }, fields.text([...path, "name"], "Name"), period, demand)];
    }
    if (shape.kind === "charger") {
      const places = fields.number([...path, "places"], "Places", { step: "1", placeholder: "1" });
      const swap = fields.number([...path, "swap_s"], "Swaps batteries in", { unit: "s", placeholder: "it fills them" });
      return [el("div", { class: "fields" }, fields.text([...path, "name"], "Name"), places, swap)];
    }
    if (shape.kind === "obstacle" && isEditable(shape)) {
      return [el("div", { class: "fields" }, this.obstacleName(shape), this.blocks(shape))];
    }
    return [];
  }

  /** What an obstacle blocks, and whether its ground is asked for; one written as a bare ring becomes a block with a ring. */
  blocks(shape) {
    const options = { both: "motion and sight", motion: "motion only", nothing: "motion only; nothing is asked under it", sight: "sight only" };
    const select = el("select", {}, ...Object.entries(options).map(([value, name]) => el("option", { value }, name)));
    select.addEventListener("change", () => {
      const { document } = this.fields.store;
      const before = document.obstacles[shape.path[1]];
      const { asks, ...block } = Array.isArray(before) ? { ring: before } : before;
      this.fields.set(shape.path, { ...block, ...(select.value === "nothing" ? { blocks: "motion", asks: "nothing" } : { blocks: select.value }) });
    });
    const shown = (value) => (this.fields.store.document.obstacles?.[shape.path[1]]?.asks === "nothing" && value === "motion" ? "nothing" : value ?? "both");
    return this.fields.custom([...shape.path, "blocks"], "Blocks", select, (value) => (select.value = shown(value)));
  }

  /** An obstacle's name; one written as a bare ring becomes a block with a ring. */
  obstacleName(shape) {
    const path = [...shape.path, "name"];
    const input = el("input", { type: "text", autocomplete: "off", placeholder: `Obstacle ${shape.path[1] + 1}` });
    input.addEventListener("input", () => {
      const before = this.fields.store.document.obstacles[shape.path[1]];
      const { name, ...block } = Array.isArray(before) ? { ring: before } : before;
      this.fields.store.apply(withValue(this.fields.store.document, shape.path, { ...block, ...(input.value === "" ? {} : { name: input.value }) }), pathKey(path));
    });
    return this.fields.custom(path, "Name", input, (value) => (input.value = typeof value === "string" ? value : ""));
  }

  coordinates(shape) {
    const degrees = this.fields.store.document.coordinates === "wgs84";
    const latest = () => shapesOf(this.fields.store.document).find((other) => other.key === shape.key)?.geometry ?? shape.geometry;
    const table = coordinateTable(shape, degrees, latest, (geometry, merge) => this.tell("geometry", { path: shape.path, geometry, merge }));
    const details = el("details", { open: this.open.has("coordinates") }, el("summary", { "data-mark": "coordinates" }, "Coordinates"), table);
    details.addEventListener("toggle", () => (details.open ? this.open.add("coordinates") : this.open.delete("coordinates")));
    return details;
  }

  addForm() {
    const kind = el("select", { "aria-label": "What to add" }, ...Object.entries(KINDS).map(([value, name]) => el("option", { value }, name)));
    const form = el("select", { "aria-label": "Its form" }, ...Object.entries(FORMS).filter(([value]) => value !== "rectangle").map(([value, name]) => el("option", { value }, name)));
    kind.addEventListener("change", () => (form.hidden = isPlaces(kind.value)));
    const add = button("Add by numbers", () => {
      this.open.add("coordinates");
      this.tell("add", { kind: kind.value, form: isPlaces(kind.value) ? "points" : form.value });
    });
    const row = el("div", { class: "row" }, kind, form, add);
    return el("details", {}, el("summary", {}, "Without a mouse"), el("p", { class: "field-help" }, "Puts a shape into the middle of the map; its coordinates are typed in its table."), row);
  }

  tell(name, detail) {
    this.dispatchEvent(new CustomEvent(name, { detail }));
  }
}

function summaryOf(shape) {
  const { geometry } = shape;
  switch (geometry.type) {
    case "ring":
      return `${geometry.outer.length} corners${geometry.holes.length > 0 ? `, ${geometry.holes.length} holes` : ""}`;
    case "circle":
      return `circle of ${geometry.radius_m} m`;
    case "points":
      return geometry.points.length === 1 ? "1 point" : `${geometry.points.length} points`;
    case "box":
      return "box";
    default:
      return geometry.what;
  }
}
