/** A vehicle, and how fast it changes speed and direction; its values stand in empty fields, from the mission files' schema. */

import { el } from "../dom.js";
import { pathKey, valueAt, withValue } from "./paths.js";
import { numberField, numbersOf, plain } from "./schema_fields.js";

const OF_PRESETS = ["capacity_wh", "moving_w", "standing_w"];

/** How the battery of a fleet, a kind or a robot is given: by a preset's name, by its watts, or in seconds, if at all. */
export function batteryForm(block) {
  const battery = block?.battery ?? null;
  return battery === null ? "" : (battery.preset ?? "watts");
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

  /** Numbers that a kind or a robot has in place of its fleet's, where they are explained. */
  numbersAsFleet(path, vehicle, wanted) {
    return wanted.map(([name, about]) => numberField(this.fields, path, name, { ...about, description: "" }, this.preset(vehicle, name, "as the fleet")));
  }

  /** The numbers of a kind that belong to no group: its own ones, then those in place of its fleet's. */
  numbersOfKinds(path, vehicle) {
    const wanted = numbersOf(this.properties.kinds.items.properties).filter(([, about]) => about.group === undefined);
    const own = wanted.filter(([name]) => !(name in this.properties));
    const others = wanted.filter(([name]) => name in this.properties);
    return [
      ...own.map(([name, about]) => numberField(this.fields, path, name, about)),
      ...this.numbersAsFleet(path, vehicle, others),
    ];
  }

  /** A battery by a preset, by its watts or by the seconds that it lasts, folded; of a kind or a robot its fleet's, too. */
  battery(path, block) {
    const own = path.length > 1;
    const none = own ? "in seconds" : "in seconds, or none";
    const presets = plain(plain(this.properties.battery).properties.preset).enum;
    const options = { "": none, watts: "by its watts", ...Object.fromEntries(presets.map((name) => [name, name])) };
    const select = el("select", {}, ...Object.entries(options).map(([value, name]) => el("option", { value }, name)));
    select.addEventListener("change", () => this.chooseBattery(path, select.value));
    const form = batteryForm(block);
    const show = () => (select.value = batteryForm(valueAt(this.fields.store.document, path)));
    const given = this.fields.custom([...path, "battery", "preset"], "Given", select, show);
    const inputs = form === "" ? this.secondsOfBattery(path, own) : this.wattsOfBattery(path, form !== "watts");
    return el("details", {}, el("summary", { "data-of": pathKey(path) }, "Battery"), el("div", { class: "fields" }, given, ...inputs));
  }

  secondsOfBattery(path, own) {
    const isSeconds = (name, about) => about.group === "battery";
    return own ? this.numbersAsFleet(path, undefined, numbersOf(this.properties).filter((each) => isSeconds(...each))) : this.numbers(path, undefined, isSeconds);
  }

  wattsOfBattery(path, isPreset) {
    return numbersOf(plain(this.properties.battery).properties)
      .filter(([name]) => !(isPreset && OF_PRESETS.includes(name)))
      .map(([name, about]) => numberField(this.fields, [...path, "battery"], name, about));
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
