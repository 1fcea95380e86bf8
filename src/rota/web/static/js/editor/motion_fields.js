/** A vehicle, and how fast it changes speed and direction; its values stand in empty fields, from the mission files' schema. */

import { el } from "../dom.js";
import { valueAt, withValue } from "./paths.js";
import { numberField, numbersOf } from "./schema_fields.js";

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

  /** All limits of motion, folded. */
  limits(path, vehicle) {
    const inputs = this.numbers(path, vehicle, (name, about) => about.group === "motion");
    return el("details", {}, el("summary", {}, "Motion and wind"), el("div", { class: "fields" }, ...inputs));
  }
}
