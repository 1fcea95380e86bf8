/** A vehicle, and how fast it changes speed and direction; its values stand in empty fields, from the mission files' schema. */

import { el } from "../dom.js";
import { valueAt, withValue } from "./paths.js";

const FIELDS = {
  acceleration_m_s2: ["Acceleration", "m/s²"],
  corner_acceleration_m_s2: ["Acceleration round corners", "m/s²"],
  jerk_m_s3: ["Jerk", "m/s³"],
  corner_m: ["Corners cut by", "m"],
  climb_m_s: ["Climbs at", "m/s"],
  descend_m_s: ["Descends at", "m/s"],
  top_airspeed_m_s: ["Fastest through the air", "m/s"],
  wind_m_s: ["Wind", "m/s"],
};

/** A fleet or a robot without vehicle and motion, for planners that do not heed them; it keeps its vehicle's speed. */
export function changingSpeedAtOnce(block, schema) {
  if (typeof block !== "object" || block === null) {
    return block;
  }
  const kept = Object.fromEntries(Object.entries(block).filter(([name]) => name !== "vehicle" && !(name in FIELDS)));
  const speed = presetsOf(schema)[block.vehicle]?.speed_m_s;
  return speed === undefined || block.speed_m_s !== undefined ? kept : { ...kept, speed_m_s: speed };
}

function presetsOf(schema) {
  return schema?.$defs?.FleetBlock?.properties?.vehicle?.presets ?? {};
}

export class MotionFields {
  /**
   * @param {import("./fields.js").Fields} fields
   * @param {any} schema of mission files
   */
  constructor(fields, schema) {
    this.fields = fields;
    this.properties = schema?.$defs?.FleetBlock?.properties ?? {};
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

  /** All limits of motion, folded. */
  limits(path, vehicle) {
    const inputs = Object.entries(FIELDS).map(([name, [label, unit]]) =>
      this.fields.number([...path, name], label, { unit, help: this.properties[name]?.description ?? "", placeholder: this.preset(vehicle, name) }),
    );
    return el("details", {}, el("summary", {}, "Motion and wind"), el("div", { class: "fields" }, ...inputs));
  }
}
