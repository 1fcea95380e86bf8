/** The editor: the document, the map with its shapes, the forms beside it, and what the server says of it. */

import { byId } from "../dom.js";
import { notify } from "../notices.js";
import { dockAt } from "./dock.js";
import { Drawing, startReadout } from "./drawing.js";
import { Fields } from "./fields.js";
import { FleetForm } from "./fleet_form.js";
import { Frame } from "./frame.js";
import { Keeper } from "./keeper.js";
import { ShapeLayers } from "./layers.js";
import { MissionForm } from "./mission_form.js";
import { newMission } from "./new_mission.js";
import { pathKey, startsWith } from "./paths.js";
import { PlannerForm } from "./planner_form.js";
import { ShapeList } from "./shape_list.js";
import { listAt, pointsOf, shapesOf, withGeometry, withNewShape, withoutShape } from "./shapes.js";
import { DocumentStore } from "./store.js";
import { Validation } from "./validation.js";
import { startGoing } from "./going.js";
import { startVerdict } from "./verdict.js";

const L = window.L;
const SHARE = 0.2; // of the view's height: the size of a shape that is added by numbers

export class Editor extends EventTarget {
  /**
   * @param {import("./map.js").MissionMap} missionMap
   * @param {{planners: string[], schema: any}} known
   */
  constructor(missionMap, { planners, schema }) {
    super();
    this.missionMap = missionMap;
    this.store = new DocumentStore(newMission("mission", missionMap.hasTiles));
    this.keeper = new Keeper(this.store);
    this.fields = new Fields(this.store);
    this.validation = new Validation(() => ({ document: this.store.document, mission: this.keeper.id, ...this.uploaded }));
    this.layers = new ShapeLayers(missionMap.map);
    this.drawing = new Drawing(missionMap.map, byId("tools"), byId("hint"));
    this.forms = [
      new MissionForm(byId("mission-form"), this.fields),
      new FleetForm(byId("fleet-form"), this.fields, schema),
      new PlannerForm(byId("planner-form"), this.fields, planners, schema),
    ];
    this.list = new ShapeList(byId("shape-list"), this.fields);
    this.chosen = null;
    this.frame = Frame.of(this.store.document, null, missionMap.hasTiles);
    this.drawing.frame = this.frame;
    this.ground = null;
    this.faulty = new Set();
    this.listen();
    startReadout(missionMap.map, this.drawing, byId("readout"));
    startGoing(byId("going"), (place) => this.goToPlace(place));
    startVerdict(byId("verdict"), this.validation, this);
    this.update();
    this.validation.ask();
  }

  get isEmpty() {
    return shapesOf(this.store.document).length === 0;
  }

  listen() {
    this.store.addEventListener("change", (event) => this.changed(event.detail));
    this.validation.addEventListener("result", (event) => this.judged(event.detail));
    this.keeper.addEventListener("named", () => this.needsFiles && this.validation.ask());
    this.keeper.addEventListener("state", () => this.keeper.state === "failed" && this.needsFiles && this.validation.soon());
    this.layers.addEventListener("choose", (event) => this.choose(event.detail));
    this.layers.addEventListener("change", (event) => this.store.apply(withGeometry(this.store.document, event.detail.path, event.detail.geometry)));
    this.list.addEventListener("choose", (event) => this.choose(event.detail === this.chosen ? null : event.detail));
    this.list.addEventListener("delete", (event) => this.remove(event.detail));
    this.list.addEventListener("geometry", ({ detail }) => this.store.apply(withGeometry(this.store.document, detail.path, detail.geometry), detail.merge));
    this.list.addEventListener("add", (event) => this.addByNumbers(event.detail));
    this.drawing.addEventListener("drawn", (event) => this.add(event.detail.kind, event.detail.geometry));
    this.drawing.addEventListener("dock", (event) => this.dockStarts(event.detail));
    this.drawing.addEventListener("begin", () => this.layers.hold("drawing", true));
    this.drawing.addEventListener("end", () => this.layers.hold("drawing", false));
    this.drawing.addEventListener("nothing", () => this.choose(null));
    this.drawing.addEventListener("delete", () => this.removeChosen());
    this.drawing.addEventListener("fit", () => this.fit());
    this.drawing.addEventListener("moving", (event) => {
      this.layers.moving = event.detail;
      this.layers.draw({});
    });
    document.addEventListener("keydown", (event) => this.key(event));
    byId("undo").addEventListener("click", () => this.step("undo"));
    byId("redo").addEventListener("click", () => this.step("redo"));
  }

  /** Whether starts are single places, which a dock can take the place of. */
  get canDock() {
    return listAt(this.store.document, ["fleet", "start", "points"]).length > 0;
  }

  /** One box round a place, without one round the first start, with room for all robots that are surely needed. */
  dockStarts(place = L.latLng(this.frame.toMap(this.store.document.fleet.start.points[0]))) {
    const { document } = this.store;
    const robots = this.validation.latest?.bound?.robots ?? 1;
    this.store.apply(withGeometry(document, ["fleet", "start"], dockAt(place, this.frame, document, robots)));
    this.choose("fleet/start");
  }

  /** Whether shapes come from files that the server has with the mission only. */
  get needsFiles() {
    return shapesOf(this.store.document).some((shape) => shape.geometry.type === "reference");
  }

  /** Another mission: `keep` tells the keeper where it comes from. */
  load(document, keep) {
    this.drawing.stop();
    this.chosen = null;
    this.frame = Frame.of(document, null, this.missionMap.hasTiles);
    this.ground = null;
    this.faulty = new Set();
    this.waitsForFit = true;
    keep(this.keeper);
    this.validation.forget();
    this.fields.showFaults([]);
    this.store.load(document);
    this.fit();
    if (this.hasItsFiles) {
      this.validation.ask();
    } else {
      this.validation.wait();
    }
  }

  /** What was uploaded with a mission that the server does not keep yet. */
  get uploaded() {
    const { id, source } = this.keeper;
    return id === null && source.upload !== undefined ? { upload: source.upload } : {};
  }

  /** Whether the server can find the files that the mission names: those of an example come when it is kept. */
  get hasItsFiles() {
    return !this.needsFiles || this.keeper.id !== null || this.keeper.source.example === undefined;
  }

  changed(why) {
    this.frame = Frame.of(this.store.document, this.frame, this.missionMap.hasTiles);
    if (why !== "load") {
      this.validation.soon();
    }
    this.update();
    if (why !== "edit") {
      this.fields.refresh();
    }
  }

  update() {
    const { document } = this.store;
    const shapes = shapesOf(document);
    if (!shapes.some((shape) => shape.key === this.chosen)) {
      this.chosen = null;
    }
    this.drawing.frame = this.frame;
    if (this.missionMap.useFrame(this.frame)) {
      this.fit();
    }
    this.forms.forEach((form) => form.update());
    this.list.update(this.chosen);
    this.fields.update();
    this.drawShapes();
    const chosen = shapes.find((shape) => shape.key === this.chosen) ?? null;
    this.drawing.showChosen(chosen, chosen !== null && chosen.geometry.type !== "reference");
    this.showUndo();
    byId("mission-name").textContent = typeof document.name === "string" ? document.name : "";
    this.dispatchEvent(new Event("update"));
  }

  drawShapes() {
    const { chosen, faulty, frame, ground } = this;
    this.layers.draw({ document: this.store.document, chosen, faulty, frame, ground });
  }

  judged(result) {
    this.fields.showFaults(this.isEmpty ? [] : result.faults);
    this.ground = result.ground ?? this.ground;
    const isAbout = (fault, shape) => startsWith(fault.path, shape.path) && !["name", "period_s", "demand", "importance"].includes(String(fault.path[shape.path.length]));
    this.faulty = new Set(shapesOf(this.store.document).filter((shape) => result.faults.some((fault) => isAbout(fault, shape))).map((shape) => shape.key));
    this.drawShapes();
    if (this.waitsForFit && (result.ground || !this.needsFiles)) {
      this.waitsForFit = false;
      if (this.needsFiles) {
        this.fit();
      }
    }
  }

  choose(key) {
    if (key !== this.chosen) {
      this.chosen = key;
      this.update();
    }
  }

  add(kind, geometry) {
    const { document, path } = withNewShape(this.store.document, kind, geometry);
    this.chosen = pathKey(path);
    this.store.apply(document);
    if (kind === "zone") {
      this.fields.focus([...path, "period_s"]);
    }
  }

  /** A shape in the middle of the view, to be moved by its table. */
  addByNumbers({ kind, form }) {
    const { map } = this.missionMap;
    const middle = map.getSize().divideBy(2);
    const half = (map.getSize().y * SHARE) / 2;
    const at = (dx, dy) => this.frame.fromMap(map.containerPointToLatLng(middle.add(L.point(dx, dy))));
    if (form === "ring") {
      this.add(kind, { type: "ring", outer: [at(-half, half), at(half, half), at(half, -half), at(-half, -half)], holes: [] });
    } else if (form === "circle") {
      const [centre, rim] = [middle, middle.add(L.point(half, 0))].map((point) => map.containerPointToLatLng(point));
      this.add(kind, { type: "circle", centre: at(0, 0), radius_m: Math.round(this.frame.distance(centre, rim) * 10) / 10 });
    } else {
      this.add(kind, { type: "points", points: [at(0, 0)] });
    }
  }

  remove(path) {
    const shape = shapesOf(this.store.document).find((other) => other.key === pathKey(path));
    const before = this.store.document;
    this.chosen = null;
    this.store.apply(withoutShape(before, path));
    const after = this.store.document;
    notify(`${shape?.name ?? "The shape"} is deleted.`, { undo: () => this.store.document === after && this.store.undo() });
  }

  removeChosen() {
    const shape = shapesOf(this.store.document).find((other) => other.key === this.chosen);
    if (shape !== undefined) {
      this.remove(shape.path);
    }
  }

  /** Shows the field of a fault; where none is, its shape. */
  goTo(path) {
    const shape = shapesOf(this.store.document).find((other) => startsWith(path, other.path));
    if (shape !== undefined) {
      this.choose(shape.key);
      this.missionMap.fit(pointsOf(shape.geometry).map((point) => this.frame.toMap(point)));
    }
    this.dispatchEvent(new CustomEvent("goto", { detail: path }));
    if (!this.fields.focus(path) && shape !== undefined) {
      byId("shape-list").querySelector("[data-chosen=true] button")?.focus();
    }
  }

  /** Shows a place on the globe. A mission in which nothing is drawn yet lies there from then on. */
  goToPlace({ lat, lon }) {
    const { document } = this.store;
    const { hasTiles } = this.missionMap;
    if (this.isEmpty && (document.coordinates !== "wgs84" || !hasTiles)) {
      const { origin: _, ...rest } = document;
      this.frame = new Frame("wgs84", { lat, lon }, hasTiles);
      this.store.apply({ ...rest, coordinates: "wgs84" });
      this.update();
    } else if (this.frame.origin === null) {
      notify("This mission is in metres, and nothing says where on the globe they begin: give its origin first, under Coordinates.", { error: true });
      return;
    }
    const origin = { lat, lon };
    this.missionMap.look(this.frame.coordinates === "wgs84" ? this.frame.toMap([lon, lat]) : this.frame.metresToMap(0, 0, origin));
  }

  /** Shows all shapes. */
  fit() {
    const places = shapesOf(this.store.document).flatMap((shape) => placesOf(shape.geometry, this.frame));
    const resolved = (this.needsFiles ? (this.ground?.area ?? []) : []).flat(2).map(([x, y]) => this.frame.metresToMap(x, y, this.ground.origin));
    this.missionMap.fit([...places, ...resolved]);
  }

  /** Whether a tab is shown in which the mission is edited: its shapes and numbers, or its planner. */
  get isEdited() {
    return ["edit", "plan"].includes(document.body.dataset.tab);
  }

  showUndo() {
    byId("undo").disabled = !this.isEdited || !this.store.canUndo;
    byId("redo").disabled = !this.isEdited || !this.store.canRedo;
  }

  /** Goes back or forth where one sees it: what is no planner's setting is shown in its tab. */
  step(direction) {
    if (!this.isEdited) {
      return;
    }
    const before = this.store.document;
    this.store[direction]();
    const after = this.store.document;
    const changed = Object.keys({ ...before, ...after }).find((key) => before[key] !== after[key] && !isOfPlanner([key]));
    if (changed !== undefined) {
      this.dispatchEvent(new CustomEvent("goto", { detail: [changed] }));
    }
  }

  key(event) {
    const typing = event.target.closest?.("input, select, textarea, dialog") ?? null;
    if ((event.ctrlKey || event.metaKey) && ["z", "y"].includes(event.key.toLowerCase())) {
      if (event.target.closest?.("dialog")) {
        return;
      }
      event.preventDefault();
      this.step(event.shiftKey || event.key.toLowerCase() === "y" ? "redo" : "undo");
    } else if (typing === null && event.key === "Delete" && this.drawing.kind === null && document.body.dataset.tab === "edit") {
      this.removeChosen();
    } else if (typing === null && event.key === "Escape" && this.drawing.kind === null) {
      this.choose(null);
    }
  }
}

/** Whether a path leads to the planner or one of its settings. */
export function isOfPlanner(path) {
  return ["planner", "patrol", "swarm", "bounce"].includes(String(path[0]));
}

/** Places on the map that bound a geometry. */
function placesOf(geometry, frame) {
  if (geometry.type !== "circle") {
    return pointsOf(geometry).map((point) => frame.toMap(point));
  }
  const [lat, lng] = frame.toMap(geometry.centre);
  const reach = frame.tiled ? geometry.radius_m / 111000 : geometry.radius_m;
  return [
    [lat - reach, lng - reach],
    [lat + reach, lng + reach],
  ];
}
