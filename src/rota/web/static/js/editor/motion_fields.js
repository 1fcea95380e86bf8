/** A vehicle, and how fast it changes speed and direction; its values stand in empty fields, from the mission files' schema. */

import { el } from "../dom.js";
import { valueAt, withValue } from "./paths.js";
import { numberField, numbersOf, plain } from "./schema_fields.js";

const OF_PRESETS = ["capacity_wh", "moving_w", "standing_w"];

/** How a fleet's battery is given: by a preset's name, by its watts, or in seconds, if at all. */
export function batteryForm({ battery }) {
  return battery === undefined || battery === null ? "" : (battery.preset ?? "watts");
}

/** A fleet or a robot without vehicle and motion, for planners that do not heed them; it keeps its vehicle's speed. */
export function changingSpeedAtOnce(block, schema) {
  if (typeof block !== "object" || block === null) {
    return block;
  }
  const isMotion = (name) => propertiesOf(schema)[name]?.group === "motion";
  const kept = Object.fromEntries(Object.entries(block).filter(([name]) => !isMotion(name)));
  const speed = presetsOf(schema)[block.vehicle]?.speed_m_s;
  return speed === undefined || block.speed_m_s !== undefined ? kept : { ...kept, speed_m_s: speed };
}

function propertiesOf(schema) {
  return schema?.properties?.fleet?.properties ?? {};
}

function presetsOf(schema) {
  return propertiesOf(schema).vehicle?.presets ?? {};
}

export class MotionFields {
  /**
   * @param {import("./fields.js").Fields} fields
   * @param {any} schema of mission files
   */
  constructor(fields, schema) {
    this.fields = fields;
    this.properties = propertiesOf(schema);
    this.presets = presetsOf(schema);
    this.speeds = new Map(); // those that vehicles took the place of
  }

  /** What the vehicle of a fleet or a robot has for a field, as a placeholder. */
  preset(vehicle, name, otherwise = "") {
    const value = this.presets[vehicle]?.[name];
    return value === undefined ? otherwise : `${value}, as ${vehicle}`;
  }

  /** The vehicle; one that has a speed takes the place of the speed that was given. */
  vehicle(path, none) {
    const options = { "": none, ...Object.fromEntries(Object.keys(this.presets).map((name) => [name, name])) };
    const select = el("select", {}, ...Object.entries(options).map(([value, name]) => el("option", { value }, name)));
    select.addEventListener("change", () => this.choose(path, select.value));
    const show = (value) => (select.value = value in options ? value : "");
    return this.fields.custom([...path, "vehicle"], "Vehicle", select, show, { help: "Its speeds and accelerations hold where none are given." });
  }

  choose(path, vehicle) {
    const { store } = this.fields;
    const [key, place] = [path.join("/"), [...path, "speed_m_s"]];
    const speed = valueAt(store.document, place);
    let next = withValue(store.document, [...path, "vehicle"], vehicle === "" ? undefined : vehicle);
    if (this.presets[vehicle]?.speed_m_s !== undefined) {
      this.speeds.set(key, speed ?? this.speeds.get(key));
      next = withValue(next, place, undefined);
    } else if (speed === undefined) {
      next = withValue(next, place, this.speeds.get(key));
    }
    store.apply(next);
  }

  /** The numbers of a fleet that are wanted, by name and what the schema says of them. */
  numbers(path, vehicle, isWanted) {
    const wanted = numbersOf(this.properties).filter(([name, about]) => isWanted(name, about));
    return wanted.map(([name, about]) => numberField(this.fields, path, name, about, this.preset(vehicle, name)));
  }

  /** The numbers of a kind that belong to no group: its own ones, then those in place of its fleet's. */
  numbersOfKinds(path, vehicle) {
    const wanted = numbersOf(this.properties.kinds.items.properties).filter(([, about]) => about.group === undefined);
    const own = wanted.filter(([name]) => !(name in this.properties));
    const others = wanted.filter(([name]) => name in this.properties);
    return [
      ...own.map(([name, about]) => numberField(this.fields, path, name, about)),
      ...others.map(([name, about]) => numberField(this.fields, path, name, { ...about, description: "" }, this.preset(vehicle, name, "as the fleet"))),
    ];
  }

  /** A battery by a preset, by its watts or by the seconds that it lasts, folded. */
  battery(path, block) {
    const presets = plain(plain(this.properties.battery).properties.preset).enum;
    const options = { "": "in seconds, or none", watts: "by its watts", ...Object.fromEntries(presets.map((name) => [name, name])) };
    const select = el("select", {}, ...Object.entries(options).map(([value, name]) => el("option", { value }, name)));
    select.addEventListener("change", () => this.chooseBattery(path, select.value));
    const { battery } = block;
    const given = this.fields.custom([...path, "battery", "preset"], "Given", select, () => (select.value = batteryForm(block)));
    const isHad = (name) => battery?.preset !== undefined && OF_PRESETS.includes(name);
    const inputs =
      batteryForm(block) === ""
        ? this.numbers(path, undefined, (name, about) => about.group === "battery")
        : numbersOf(plain(this.properties.battery).properties)
            .filter(([name]) => !isHad(name))
            .map(([name, about]) => numberField(this.fields, [...path, "battery"], name, about));
    return el("details", {}, el("summary", {}, "Battery"), el("div", { class: "fields" }, given, ...inputs));
  }

  /** What is told in another way is dropped; a take-off, a reserve and what charges stay between a preset and watts. */
  chooseBattery(path, form) {
    const { store } = this.fields;
    const { battery, ...others } = valueAt(store.document, path) ?? {};
    const kept = Object.fromEntries(Object.entries(others).filter(([name]) => form === "" || this.properties[name]?.group !== "battery"));
    const { preset, capacity_wh, moving_w, standing_w, ...either } = battery ?? {};
    const told = { "": {}, watts: { battery: either } }[form] ?? { battery: { preset: form, ...either } };
    store.apply(withValue(store.document, path, { ...kept, ...told }));
  }

  /** All limits of motion, folded. */
  limits(path, vehicle) {
    const inputs = this.numbers(path, vehicle, (name, about) => about.group === "motion");
    return el("details", {}, el("summary", {}, "Motion and wind"), el("div", { class: "fields" }, ...inputs));
  }
}
