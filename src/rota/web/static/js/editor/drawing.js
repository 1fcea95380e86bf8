/** Drawing by mouse: which kind of shape, in which form; Geoman does the rest. */

import { button, el } from "../dom.js";
import { geometryOfLayer } from "./layers.js";
import { placeInWords } from "./places.js";

const L = window.L;

export const KINDS = { area: "Area", zone: "Zone", obstacle: "Obstacle", start: "Start", entrance: "Entrance", charger: "Charger" };
export const FORMS = { ring: "Polygon", rectangle: "Rectangle", circle: "Circle" };
/** Forms of the kinds that are places; all others have FORMS. */
const PLACES = { start: { points: "Point", box: "Box", dock: "Dock: all start here" }, entrance: { points: "Point" }, charger: { points: "Point" } };
const GEOMAN = { ring: "Polygon", rectangle: "Rectangle", circle: "Circle", points: "Marker", box: "Rectangle", dock: "Marker" };
const HINTS = {
  ring: "Click the corners one after another. Click the first one again, or press Enter, to close. Backspace takes the last corner back, Escape ends.",
  rectangle: "Click one corner, then the opposite one. Escape ends.",
  box: "Click one corner of the box in which robots start, then the opposite one. Escape ends.",
  circle: "Click the centre, then a point on the circle. Escape ends.",
  points: "Click where a robot starts. Escape ends.",
  dock: "Click where all robots start side by side, however many there are. Escape ends.",
  entrance: "Click where robots come in: they are only where they can get to from there. Escape ends.",
  charger: "Click where robots charge. Escape ends.",
};

/** Whether a kind of shape is places, rather than ground. */
export function isPlaces(kind) {
  return kind in PLACES;
}

export class Drawing extends EventTarget {
  /**
   * @param {L.Map} map
   * @param {HTMLElement} tools
   * @param {HTMLElement} hint
   */
  constructor(map, tools, hint) {
    super();
    this.map = map;
    this.hint = hint;
    this.kind = null;
    this.form = { shape: "ring", start: "points", entrance: "points", charger: "points" };
    this.frame = null;
    this.build(tools);
    map.on("pm:create", (event) => this.created(event.layer));
    map.on("click", () => this.kind === null && this.dispatchEvent(new Event("nothing")));
    document.addEventListener("keydown", (event) => this.key(event));
  }

  build(tools) {
    this.buttons = {};
    const kinds = el("div", { class: "row" }, el("span", { class: "label" }, "Draw"));
    for (const [kind, name] of Object.entries(KINDS)) {
      this.buttons[kind] = button(name, () => (this.kind === kind ? this.stop() : this.start(kind)), { "aria-pressed": "false" });
      kinds.append(this.buttons[kind]);
    }
    this.forms = el("select", { "aria-label": "Form", on: { change: () => this.formChosen() } });
    this.fillForms();
    this.done = button("Close the polygon", () => this.finish(), { hidden: true });
    this.move = button("Move", () => this.toggleMoving(), { "aria-pressed": "false", hidden: true });
    this.remove = button("Delete", () => this.dispatchEvent(new Event("delete")), { hidden: true });
    tools.append(kinds, el("div", { class: "row" }, el("span", { class: "label" }, "as"), this.forms), this.done);
    tools.append(el("div", { class: "row" }, this.move, this.remove), button("Show all", () => this.dispatchEvent(new Event("fit"))));
  }

  get chosenForm() {
    return this.form[this.formKey];
  }

  /** Under which name the form of this kind is remembered. */
  get formKey() {
    return isPlaces(this.kind) ? this.kind : "shape";
  }

  fillForms() {
    const forms = PLACES[this.kind] ?? FORMS;
    this.forms.replaceChildren(...Object.entries(forms).map(([value, name]) => el("option", { value }, name)));
    this.forms.value = this.chosenForm;
  }

  formChosen() {
    this.form = { ...this.form, [this.formKey]: this.forms.value };
    if (this.kind !== null) {
      this.start(this.kind);
    }
  }

  /** Begins to draw a kind of shape. */
  start(kind) {
    this.map.pm.disableDraw();
    this.kind = kind;
    this.fillForms();
    this.dispatchEvent(new Event("begin"));
    const options = { snappable: false, allowSelfIntersection: true, continueDrawing: false, tooltips: false, markerStyle: { pmIgnore: true } };
    this.map.pm.enableDraw(GEOMAN[this.chosenForm], options);
    this.showState();
  }

  /** Ends drawing; what was begun is dropped. */
  stop() {
    if (this.kind === null) {
      return;
    }
    this.kind = null;
    this.map.pm.disableDraw();
    this.fillForms();
    this.showState();
    this.dispatchEvent(new Event("end"));
  }

  finish() {
    if (this.kind !== null && this.chosenForm === "ring") {
      this.map.pm.Draw.Polygon._finishShape();
    }
  }

  created(layer) {
    const [kind, form] = [this.kind, this.chosenForm];
    layer.remove();
    if (kind === null) {
      return;
    }
    this.stop();
    if (form === "dock") {
      this.dispatchEvent(new CustomEvent("dock", { detail: layer.getLatLng() }));
      return;
    }
    const geometry = geometryOfLayer(layer, this.frame, form === "rectangle" ? "ring" : form);
    this.dispatchEvent(new CustomEvent("drawn", { detail: { kind, geometry } }));
  }

  /** Which tools serve the chosen shape. */
  showChosen(shape, editable) {
    this.move.hidden = !editable || shape.geometry.type === "points";
    this.remove.hidden = shape === null;
    this.remove.textContent = shape === null ? "Delete" : `Delete ${shape.name}`;
    if (this.move.hidden) {
      this.move.setAttribute("aria-pressed", "false");
    }
  }

  toggleMoving() {
    const moving = this.move.getAttribute("aria-pressed") !== "true";
    this.move.setAttribute("aria-pressed", String(moving));
    this.dispatchEvent(new CustomEvent("moving", { detail: moving }));
  }

  showState() {
    for (const [kind, element] of Object.entries(this.buttons)) {
      element.setAttribute("aria-pressed", String(kind === this.kind));
    }
    this.done.hidden = this.kind === null || this.chosenForm !== "ring";
    this.hint.textContent = this.kind === null ? "" : HINTS[this.kind in HINTS ? this.kind : this.chosenForm];
  }

  key(event) {
    if (this.kind === null || event.target.closest?.("input, select, textarea, dialog")) {
      return;
    }
    if (event.key === "Escape") {
      this.stop();
    } else if (event.key === "Enter" && !event.target.closest?.("button, a")) {
      this.finish();
    } else if (event.key === "Backspace" && this.chosenForm === "ring") {
      event.preventDefault();
      this.map.pm.Draw.Polygon._removeLastVertex();
    }
  }

  /** The place of the corner drawn last; null while there is none. */
  lastCorner() {
    const working = this.kind === null ? null : this.map.pm.Draw[GEOMAN[this.chosenForm]]?._layer;
    const places = typeof working?.getLatLngs === "function" ? working.getLatLngs().flat() : [];
    return this.chosenForm === "ring" ? (places.at(-1) ?? null) : null;
  }
}

/** Shows where the pointer is, and how far it is from the corner before. */
export function startReadout(map, drawing, readout) {
  map.on("mousemove", (event) => {
    const { frame } = drawing;
    const [x, y] = frame.fromMap(event.latlng);
    const here = frame.coordinates === "wgs84" ? placeInWords(y, x) : `${x.toFixed(1)} m, ${y.toFixed(1)} m`;
    const last = drawing.lastCorner();
    readout.textContent = last === null ? here : `${here} · ${frame.distance(last, event.latlng).toFixed(1)} m from the last corner`;
  });
  map.on("mouseout", () => {
    readout.textContent = "";
  });
}
