/** The robots: how many, how fast, what they see, how they turn, and what vehicles they are. */

import { button, el } from "../dom.js";
import { keepingFocus } from "./fields.js";
import { MotionFields, batteryForm } from "./motion_fields.js";
import { listAt } from "./shapes.js";
import { withValue } from "./paths.js";

const COUNTS = { fewest: "as few as possible", number: "a number", list: "a list, one by one", kinds: "the cheapest of several kinds" };
const SENSORS = { disc: "disc", square: "square" };
const FIRST_NUMBER = 3;
const FIRST_KINDS = [
  { name: "kind-1", cost: 1 },
  { name: "kind-2", cost: 2 },
];

export class FleetForm {
  /**
   * @param {HTMLElement} section
   * @param {import("./fields.js").Fields} fields
   * @param {any} schema of mission files
   */
  constructor(section, fields, schema) {
    this.section = section;
    this.fields = fields;
    this.motion = new MotionFields(fields, schema);
    this.built = "";
    this.kinds = FIRST_KINDS; // those that were there before robots were counted otherwise
    fields.store.addEventListener("change", ({ detail }) => {
      this.kinds = detail === "load" ? FIRST_KINDS : this.kinds;
    });
  }

  get fleet() {
    return this.fields.store.document.fleet ?? {};
  }

  update() {
    const { document } = this.fields.store;
    const listed = this.lists().map((key) => listAt(document, ["fleet", key]).map((one) => [one?.sensor?.shape ?? "", one?.vehicle ?? "", batteryForm(one)]));
    const { sensor, vehicle } = this.fleet;
    const built = JSON.stringify([countOf(this.fleet), sensor?.shape ?? "disc", vehicle ?? "", listed, document.planner, batteryForm(this.fleet)]);
    if (built !== this.built) {
      this.built = built;
      keepingFocus(this.section, () => this.build());
    }
  }

  /** Which of a fleet's lists are shown. */
  lists() {
    return { list: ["robots"], kinds: ["kinds"] }[countOf(this.fleet)] ?? [];
  }

  build() {
    const { fields, motion } = this;
    const { vehicle } = this.fleet;
    const heeded = (fields.store.document.planner ?? "patrol") === "patrol" || vehicle !== undefined; // others refuse vehicles
    const main = el(
      "div",
      { class: "fields" },
      this.count(),
      heeded ? motion.vehicle(["fleet"], "none: changes speed at once") : null,
      countOf(this.fleet) === "number" ? fields.number(["fleet", "robots"], "Number of robots", { step: "1" }) : null,
      ...motion.numbers(["fleet"], vehicle, (name) => name === "speed_m_s"),
      ...this.sensor(["fleet", "sensor"], this.fleet.sensor, true),
    );
    const more = el(
      "details",
      {},
      el("summary", {}, "Body, turning, altitude"),
      el(
        "div",
        { class: "fields" },
        ...motion.numbers(["fleet"], vehicle, (name, about) => name !== "speed_m_s" && about.group === undefined),
      ),
    );
    const lists = this.lists().map((key) => this.list(key));
    const limits = heeded ? motion.limits(["fleet"], vehicle) : null;
    const battery = this.battery(["fleet"], this.fleet);
    this.section.replaceChildren(...[el("h2", {}, "Fleet"), main, more, limits, battery, ...lists].filter((part) => part !== null));
    fields.update();
  }

  /** The battery of the fleet, of a robot or of a kind; null where the planner heeds none. */
  battery(path, block) {
    return this.fields.store.document.planner === "bounce" ? null : this.motion.battery(path, block);
  }

  count() {
    const select = el("select", {}, ...Object.entries(COUNTS).map(([value, name]) => el("option", { value }, name)));
    select.addEventListener("change", () => this.setCount(select.value));
    const show = () => (select.value = countOf(this.fleet));
    // as a custom field of its own path only for faults; the number has the same path
    return this.fields.custom(["fleet", "robots"], "Robots", select, show);
  }

  setCount(form) {
    const { robots: before, kinds, ...others } = this.fleet;
    this.kinds = kinds ?? this.kinds;
    const count = Array.isArray(before) ? before.length : typeof before === "number" ? before : FIRST_NUMBER;
    const list = Array.from({ length: Math.min(count, 100) }, (_, k) => ({ name: `robot-${k + 1}` }));
    const value = { fewest: "fewest", number: count, list: Array.isArray(before) ? before : list }[form];
    const fleet = form === "kinds" ? { ...others, kinds: this.kinds } : { robots: value, ...others };
    this.fields.store.apply(withValue(this.fields.store.document, ["fleet"], fleet));
  }

  /** A sensor's shape and its size; the size's key goes with the shape. */
  sensor(path, sensor, needed) {
    const options = needed ? SENSORS : { "": "as the fleet", ...SENSORS };
    const select = el("select", {}, ...Object.entries(options).map(([value, name]) => el("option", { value }, name)));
    select.addEventListener("change", () => this.fields.set(path, sensorLike(select.value, sensor)));
    const shape = this.fields.custom([...path, "shape"], "Sensor", select, (value) => (select.value = value in options ? value : Object.keys(options)[0]));
    if (sensor === undefined && !needed) {
      return [shape];
    }
    const size = sensor?.shape === "square" ? ["side_m", "Sensor's side"] : ["radius_m", "Sensor's radius"];
    return [shape, this.fields.number([...path, size[0]], size[1], { unit: "m" })];
  }

  /** The cards of all robots, or of all kinds of them. */
  list(key) {
    const { store } = this.fields;
    const path = ["fleet", key];
    const all = listAt(store.document, path);
    const one = key.slice(0, -1);
    const apply = (changed) => store.apply(withValue(store.document, path, changed));
    const cards = all.map((each, k) => {
      const parts = key === "kinds" ? this.kind(each, [...path, k]) : this.robot(each, [...path, k]);
      const remove = button("Delete", () => apply(listAt(store.document, path).filter((_, j) => j !== k)), {
        "aria-label": `Delete ${one} ${k + 1}`,
        class: "quiet",
      });
      return el("div", { class: "card" }, el("div", { class: "fields" }, ...parts), this.battery([...path, k], each), el("div", {}, remove));
    });
    const usual = key === "kinds" ? { cost: 1 } : {};
    const add = button(`Add a ${one}`, () => apply([...listAt(store.document, path), { name: freeName(all, one), ...usual }]));
    return el("details", { open: all.length <= 12 }, el("summary", {}, `${all.length} ${key}`), el("div", { class: "plain" }, ...cards, add));
  }

  /** The fields of a kind: its name, its numbers as the schema has them, and what it sees. */
  kind(kind, path) {
    return [
      this.fields.text([...path, "name"], "Name"),
      this.motion.vehicle(path, "as the fleet"),
      ...this.motion.numbersOfKinds(path, kind?.vehicle),
      ...this.sensor([...path, "sensor"], kind?.sensor ?? undefined, false),
    ];
  }

  robot(robot, path) {
    const { fields } = this;
    const speed = this.fleet.speed_m_s;
    const asFleet = `as the fleet${speed ? `, ${speed}` : ""}`;
    const parts = [
      fields.text([...path, "name"], "Name"),
      this.fleet.vehicle !== undefined || robot?.vehicle !== undefined ? this.motion.vehicle(path, "as the fleet") : null,
      fields.number([...path, "speed_m_s"], "Speed", { unit: "m/s", placeholder: this.motion.preset(robot?.vehicle, "speed_m_s", asFleet) }),
      ...this.sensor([...path, "sensor"], robot?.sensor ?? undefined, false),
      fields.number([...path, "body_radius_m"], "Body radius", { unit: "m", placeholder: "as the fleet" }),
    ];
    if (this.fields.store.document.planner === "swarm") {
      parts.push(fields.number([...path, "joins_s"], "Joins at", { unit: "s", placeholder: "0" }), fields.number([...path, "leaves_s"], "Leaves at", { unit: "s", placeholder: "never" }));
    }
    return parts;
  }
}

function countOf({ robots, kinds }) {
  if (Array.isArray(kinds) && kinds.length > 0) {
    return "kinds";
  }
  return Array.isArray(robots) ? "list" : robots === undefined || robots === "fewest" ? "fewest" : "number";
}

function sensorLike(shape, before) {
  if (shape === "") {
    return undefined;
  }
  const reach = before?.radius_m ?? (before?.side_m ?? 30) / 2;
  return shape === "disc" ? { shape, radius_m: reach } : { shape, side_m: 2 * reach };
}

/** A name that none of them has: robot-1, kind-2. */
function freeName(all, one) {
  const taken = new Set(all.map((each) => each?.name));
  let number = 1;
  while (taken.has(`${one}-${number}`)) {
    number += 1;
  }
  return `${one}-${number}`;
}
