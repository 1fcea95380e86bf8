/** What a mission asks for as a whole: its name, the period, and where it lies. */

import { button, el } from "../dom.js";
import { canConvert, inDegrees, inMetres } from "./coordinates.js";
import { keepingFocus } from "./fields.js";
import { isOrigin } from "./frame.js";
import { listAt } from "./shapes.js";
import { withValue } from "./paths.js";

export class MissionForm {
  /**
   * @param {HTMLElement} section
   * @param {import("./fields.js").Fields} fields
   */
  constructor(section, fields) {
    this.section = section;
    this.fields = fields;
    this.built = "";
  }

  update() {
    const { document } = this.fields.store;
    const built = `${document.coordinates ?? "metres"} ${isOrigin(document.origin)} ${canConvert(document)} ${listAt(document, ["moving_obstacles"]).length}`;
    if (built !== this.built) {
      this.built = built;
      keepingFocus(this.section, () => this.build(document));
    }
  }

  build(document) {
    const { fields } = this;
    const general = el(
      "div",
      { class: "fields" },
      fields.text(["name"], "Name"),
      fields.number(["period_s"], "Period", { unit: "s", empty: null, help: "Every point is seen at least so often. Empty: nothing is asked." }),
    );
    const place = el("details", {}, el("summary", {}, "Coordinates, hidden ground"), el("div", { class: "fields" }, ...this.placeFields(document)));
    this.section.replaceChildren(el("h2", {}, "Mission"), general, place);
  }

  placeFields(document) {
    const { fields } = this;
    const unseeable = fields.choice(["unseeable"], "Ground that nobody can see", { exclude: "leave it out", refuse: "do not plan" });
    const parts = [unseeable, this.coordinates(document)];
    if (document.coordinates === "wgs84") {
      parts.push(el("p", { class: "field-help" }, "Shapes are kept as longitude and latitude, and shown in metres about the area's middle."));
    } else {
      parts.push(
        fields.number(["origin", "lat"], "Origin: latitude", { unit: "°", help: "Where on the globe (0, 0) lies: for exports with places on the globe." }),
        fields.number(["origin", "lon"], "Origin: longitude", { unit: "°" }),
      );
    }
    if (document.origin !== undefined && document.origin !== null) {
      parts.push(button("No origin", () => this.apply(withValue(this.fields.store.document, ["origin"], undefined))));
    }
    const moving = listAt(document, ["moving_obstacles"]).length;
    if (moving > 0) {
      parts.push(el("p", { class: "field-help" }, `${moving} moving obstacles: kept as they are, not shown here.`));
    }
    return parts;
  }

  coordinates(document) {
    const options = { metres: "metres", wgs84: "longitude, latitude (WGS84)" };
    const select = el("select", {}, ...Object.entries(options).map(([value, name]) => el("option", { value }, name)));
    select.disabled = !canConvert(document);
    const help = select.disabled ? "Shapes from other files, and moving obstacles, keep their coordinates." : "Shapes are converted when you change it.";
    select.addEventListener("change", () => this.convert(select));
    return this.fields.custom(["coordinates"], "Coordinates", select, (value) => (select.value = value ?? "metres"), { help });
  }

  convert(select) {
    const { document } = this.fields.store;
    if (select.value === "metres") {
      this.apply(inMetres(document));
    } else if (isOrigin(document.origin)) {
      this.apply(inDegrees(document, document.origin));
    } else {
      select.value = "metres";
      const fault = { field: "origin", path: ["origin", "lat"], message: "Where on the globe do the metres begin? Give the origin's latitude and longitude first." };
      this.fields.showFaults([fault]);
      this.fields.focus(["origin", "lat"]);
    }
  }

  apply(document) {
    this.fields.store.apply(document);
  }
}
