/** The robots: how many, how fast, what they see, how they turn, and what vehicles they are. */

import { button, el } from "../dom.js";
import { keepingFocus } from "./fields.js";
import { MotionFields } from "./motion_fields.js";
import { listAt } from "./shapes.js";
import { withValue } from "./paths.js";

const COUNTS = { fewest: "as few as possible", number: "a number", list: "a list, one by one" };
const SENSORS = { disc: "disc", square: "square" };
const FIRST_NUMBER = 3;

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
  }

  get fleet() {
    return this.fields.store.document.fleet ?? {};
  }

  update() {
    const { document } = this.fields.store;
    const robots = listAt(document, ["fleet", "robots"]);
    const kinds = robots.map((robot) => [robot?.sensor?.shape ?? "", robot?.vehicle ?? ""]);
    const { sensor, vehicle } = this.fleet;
    const built = JSON.stringify([countOf(this.fleet.robots), sensor?.shape ?? "disc", vehicle ?? "", kinds, document.planner]);
    if (built !== this.built) {
      this.built = built;
      keepingFocus(this.section, () => this.build(robots));
    }
  }

  build(robots) {
    const { fields, motion } = this;
    const { vehicle } = this.fleet;
    const heeded = (fields.store.document.planner ?? "patrol") === "patrol" || vehicle !== undefined; // others refuse vehicles
    const main = el(
      "div",
      { class: "fields" },
      this.count(),
      heeded ? motion.vehicle(["fleet"], "none: changes speed at once") : null,
      countOf(this.fleet.robots) === "number" ? fields.number(["fleet", "robots"], "Number of robots", { step: "1" }) : null,
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
    const list = countOf(this.fleet.robots) === "list" ? this.robotList(robots) : null;
    const limits = heeded ? motion.limits(["fleet"], vehicle) : null;
    this.section.replaceChildren(...[el("h2", {}, "Fleet"), main, more, limits, list].filter((part) => part !== null));
    fields.update();
  }

  count() {
    const select = el("select", {}, ...Object.entries(COUNTS).map(([value, name]) => el("option", { value }, name)));
    select.addEventListener("change", () => this.setCount(select.value));
    const show = (value) => (select.value = countOf(value));
    // as a custom field of its own path only for faults; the number has the same path
    return this.fields.custom(["fleet", "robots"], "Robots", select, show);
  }

  setCount(kind) {
    const before = this.fleet.robots;
    const count = Array.isArray(before) ? before.length : typeof before === "number" ? before : FIRST_NUMBER;
    const list = Array.from({ length: Math.min(count, 100) }, (_, k) => ({ name: `robot-${k + 1}` }));
    const value = { fewest: "fewest", number: count, list: Array.isArray(before) ? before : list }[kind];
    this.fields.store.apply(withValue(this.fields.store.document, ["fleet", "robots"], value));
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

  robotList(robots) {
    const cards = robots.map((robot, k) => this.robot(robot, k));
    const add = button("Add a robot", () => this.setRobots([...robots, { name: freeName(robots) }]));
    return el("details", { open: robots.length <= 12 }, el("summary", {}, `${robots.length} robots`), el("div", { class: "plain" }, ...cards, add));
  }

  robot(robot, k) {
    const { fields } = this;
    const path = ["fleet", "robots", k];
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
    const remove = button("Delete", () => this.setRobots(listAt(fields.store.document, ["fleet", "robots"]).filter((_, j) => j !== k)), {
      "aria-label": `Delete robot ${k + 1}`,
      class: "quiet",
    });
    return el("div", { class: "card" }, el("div", { class: "fields" }, ...parts), el("div", {}, remove));
  }

  setRobots(robots) {
    this.fields.store.apply(withValue(this.fields.store.document, ["fleet", "robots"], robots));
  }
}

function countOf(robots) {
  return Array.isArray(robots) ? "list" : robots === undefined || robots === "fewest" ? "fewest" : "number";
}

function sensorLike(shape, before) {
  if (shape === "") {
    return undefined;
  }
  const reach = before?.radius_m ?? (before?.side_m ?? 30) / 2;
  return shape === "disc" ? { shape, radius_m: reach } : { shape, side_m: 2 * reach };
}

function freeName(robots) {
  const taken = new Set(robots.map((robot) => robot?.name));
  let number = 1;
  while (taken.has(`robot-${number}`)) {
    number += 1;
  }
  return `robot-${number}`;
}
