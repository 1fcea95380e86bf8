/** The document's shapes as layers of the map; the chosen one can be changed by hand. */

import { el } from "../dom.js";
import { isEditable, shapesOf } from "./shapes.js";

const L = window.L;
const EDITING = { allowSelfIntersection: true, removeLayerBelowMinVertexCount: false, snappable: false };

export class ShapeLayers extends EventTarget {
  /** @param {L.Map} map */
  constructor(map) {
    super();
    this.map = map;
    this.group = L.layerGroup().addTo(map);
    this.moving = false;
    this.holds = new Set(); // why shapes only look on
    this.hidden = false;
    this.pressed = false; // whether a button or finger is down on the map
    this.waits = false; // whether there is something to draw once it is up
    this.shown = { frame: null, shapes: [], chosen: null, faulty: new Set(), ground: null, document: {} };
    map.getContainer().addEventListener("pointerdown", () => (this.pressed = true), { capture: true });
    for (const end of ["pointerup", "pointercancel"]) {
      // Leaflet hears of the end by the events that follow this one
      window.addEventListener(end, () => setTimeout(() => this.released()));
    }
  }

  released() {
    this.pressed = false;
    if (this.waits) {
      this.draw({});
    }
  }

  /** Draws everything anew; under a hand that drags or clicks, once it is done: a layer that is taken away loses both. */
  draw(shown) {
    this.shown = { ...this.shown, ...shown };
    this.waits = this.pressed;
    if (this.pressed) {
      return;
    }
    const { document, frame, chosen, ground } = this.shown;
    this.shown.shapes = shapesOf(document);
    this.group.clearLayers();
    if (ground !== null) {
      this.drawGround(ground);
    }
    for (const shape of this.shown.shapes) {
      const layers = this.layersOf(shape, frame);
      layers.forEach((layer) => this.group.addLayer(layer));
      if (shape.key === chosen && !this.locked && !this.hidden && isEditable(shape)) {
        layers.forEach((layer, k) => this.enable(layer, shape, k));
      }
    }
  }

  get locked() {
    return this.holds.size > 0;
  }

  /** Shapes only look on for a reason (one draws; a plan is watched) until it is gone. */
  hold(reason, holds) {
    if (holds !== this.holds.has(reason)) {
      if (holds) {
        this.holds.add(reason);
      } else {
        this.holds.delete(reason);
      }
      this.draw({});
    }
  }

  /** Takes all shapes off the map, or puts them back; hands change only what is on the map. */
  hide(hidden) {
    if (hidden !== this.hidden) {
      this.hidden = hidden;
      if (hidden) {
        this.group.remove();
      } else {
        this.group.addTo(this.map);
      }
      this.draw({});
    }
  }

  options(shape) {
    const names = ["shape", `shape-${shape.kind}`];
    if (shape.kind === "obstacle" && this.blocks(shape) !== "both") {
      names.push("shape-obstacle-motion");
    }
    if (shape.key === this.shown.chosen) {
      names.push("shape-chosen");
    }
    if (this.shown.faulty.has(shape.key)) {
      names.push("shape-fault");
    }
    return { className: names.join(" "), pmIgnore: false, interactive: !this.locked, bubblingMouseEvents: false };
  }

  blocks(shape) {
    return this.shown.document.obstacles?.[shape.path[1]]?.blocks ?? "both";
  }

  layersOf(shape, frame) {
    const { geometry } = shape;
    const toMap = (point) => frame.toMap(point);
    let layers = [];
    if (geometry.type === "ring") {
      layers = [L.polygon([geometry.outer, ...geometry.holes].map((ring) => ring.map(toMap)), this.options(shape))];
    } else if (geometry.type === "circle") {
      layers = [L.circle(toMap(geometry.centre), { ...this.options(shape), radius: geometry.radius_m })];
    } else if (geometry.type === "box") {
      layers = [L.rectangle(L.latLngBounds(geometry.corners.map(toMap)), this.options(shape))];
    } else if (geometry.type === "points") {
      layers = geometry.points.map((point) => this.marker(shape, toMap(point)));
    }
    for (const layer of layers) {
      layer.on("click", (event) => {
        L.DomEvent.stopPropagation(event);
        this.dispatchEvent(new CustomEvent("choose", { detail: shape.key }));
      });
      if (shape.kind === "zone") {
        label(layer, shape.name);
      }
    }
    return layers;
  }

  marker(shape, place) {
    const chosen = shape.key === this.shown.chosen ? " start-mark-chosen" : "";
    const own = shape.kind === "start" ? "" : ` ${shape.kind}-mark`;
    const icon = L.divIcon({ className: `start-mark${own}${chosen}`, iconSize: [16, 16] });
    return L.marker(place, { icon, pmIgnore: true, title: shape.name, alt: shape.name, keyboard: false, interactive: !this.locked });
  }

  /** Lets hands change a layer of the chosen shape, its k-th. */
  enable(layer, shape, k) {
    if (shape.geometry.type === "points") {
      layer.dragging.enable();
      layer.on("dragend", () => this.tell(shape, this.withPoint(shape, k, layer.getLatLng())));
      return;
    }
    const changed = () => this.tell(shape, this.geometryFrom(layer, shape.geometry));
    if (this.moving) {
      layer.pm.enableLayerDrag();
      layer.on("pm:dragend", changed);
    } else {
      layer.pm.enable(EDITING);
      layer.on("pm:edit", changed);
    }
  }

  tell(shape, geometry) {
    this.dispatchEvent(new CustomEvent("change", { detail: { path: shape.path, geometry } }));
  }

  withPoint(shape, k, place) {
    const points = shape.geometry.points.map((point, j) => (j === k ? this.shown.frame.fromMap(place) : point));
    return { type: "points", points };
  }

  /** The document's geometry of a layer; `like` tells of what type it is to be. */
  geometryFrom(layer, like) {
    return geometryOfLayer(layer, this.shown.frame, like.type);
  }

  /** What the server made of the shapes: it shows those that come from other files. */
  drawGround(ground) {
    const references = this.shown.shapes.filter((shape) => !isEditable(shape));
    const has = (kind) => references.some((shape) => shape.kind === kind);
    const draw = (polygons, kind, name) => this.drawResolved(polygons, kind, name, ground.origin, references);
    if (has("area")) {
      draw(ground.area, "area", "");
    }
    if (has("area") || has("obstacle")) {
      ground.obstacles.forEach((obstacle) => draw(obstacle.shape, "obstacle", ""));
    }
    if (has("zone")) {
      ground.zones.forEach((zone) => draw(zone.shape, "zone", zone.name));
    }
  }

  drawResolved(polygons, kind, name, origin, references) {
    const { frame } = this.shown;
    const places = polygons.map((rings) => rings.map((ring) => ring.map(([x, y]) => frame.metresToMap(x, y, origin))));
    const own = references.filter((shape) => shape.kind === kind);
    const chosen = own.some((shape) => shape.key === this.shown.chosen) ? " shape-chosen" : "";
    const className = `shape shape-${kind} shape-resolved${chosen}`;
    const layer = L.polygon(places, { className, pmIgnore: true, interactive: !this.locked && own.length > 0, bubblingMouseEvents: false });
    if (name !== "") {
      label(layer, name);
    }
    layer.on("click", (event) => {
      L.DomEvent.stopPropagation(event);
      this.dispatchEvent(new CustomEvent("choose", { detail: own[0].key }));
    });
    this.group.addLayer(layer);
  }
}

/** The geometry of a drawn layer, in the document's coordinates. */
export function geometryOfLayer(layer, frame, type) {
  if (type === "circle") {
    return { type, centre: frame.fromMap(layer.getLatLng()), radius_m: Math.round(layer.getRadius() * 1000) / 1000 };
  }
  if (type === "points") {
    return { type, points: [frame.fromMap(layer.getLatLng())] };
  }
  if (type === "box") {
    const bounds = layer.getBounds();
    return { type, corners: [frame.fromMap(bounds.getSouthWest()), frame.fromMap(bounds.getNorthEast())] };
  }
  const [outer, ...holes] = layer.getLatLngs().map((ring) => ring.map((place) => frame.fromMap(place)));
  return { type: "ring", outer, holes: holes.filter((hole) => hole.length > 2) };
}

function label(layer, text) {
  // an element, since Leaflet would take a string for HTML
  layer.bindTooltip(el("span", {}, text), { permanent: true, direction: "center", className: "shape-label", interactive: false });
}
