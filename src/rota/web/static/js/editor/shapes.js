/**
 * The shapes of a mission document, whatever way they are written in.
 *
 * @typedef {[number, number]} Point as in the document: metres, or longitude and latitude
 * @typedef {{type: "ring", outer: Point[], holes: Point[][]} | {type: "circle", centre: Point, radius_m: number}
 *   | {type: "points", points: Point[]} | {type: "box", corners: Point[]} | {type: "reference", what: string}} Geometry
 * @typedef {"area"|"obstacle"|"zone"|"start"|"entrance"|"charger"} Kind
 * @typedef {{kind: Kind, path: (string|number)[], key: string, name: string, geometry: Geometry}} Shape
 */

import { pathKey, valueAt, withValue } from "./paths.js";

const ENTRANCES = ["fleet", "entrances"];
const SHAPE_KEYS = ["ring", "outer", "holes", "circle", "wkt", "geojson", "feature", "map", "inside", "unknown", "close_gaps_m", "text", "cell_m", "graph", "width_m", "place"];

/**
 * All shapes: the area, obstacles, zones, starts, entrances, chargers. A document without an area has none of that kind.
 * @returns {Shape[]}
 */
export function shapesOf(document) {
  const shapes = [];
  const add = (kind, path, name, block) => {
    const geometry = geometryOf(block);
    if (geometry !== null) {
      shapes.push({ kind, path, key: pathKey(path), name, geometry });
    }
  };
  add("area", ["area"], "Area", document.area);
  listAt(document, ["obstacles"]).forEach((block, k) => add("obstacle", ["obstacles", k], textOr(block?.name, `Obstacle ${k + 1}`), block));
  listAt(document, ["zones"]).forEach((block, k) => add("zone", ["zones", k], textOr(block?.name, `Zone ${k + 1}`), block));
  add("start", ["fleet", "start"], "Starts", document.fleet?.start);
  add("entrance", ENTRANCES, "Entrances", { points: document.fleet?.entrances });
  listAt(document, ["chargers"]).forEach((charger, k) => {
    if (isPoint(charger?.at)) {
      add("charger", ["chargers", k], textOr(charger.name, `Charger ${k + 1}`), { points: [charger.at] });
    }
  });
  listAt(document, ["fleet", "robots"]).forEach((robot, k) => {
    if (isPoint(robot?.start)) {
      add("start", ["fleet", "robots", k, "start"], `Start of ${textOr(robot.name, `robot ${k + 1}`)}`, { points: [robot.start] });
    }
  });
  return shapes;
}

/** What a block of a document holds, null for nothing that can be shown (an empty ring, another type). */
export function geometryOf(block) {
  if (Array.isArray(block)) {
    return ringOf(block, []);
  }
  if (block === null || typeof block !== "object") {
    return null;
  }
  if (Array.isArray(block.ring)) {
    return ringOf(block.ring, []);
  }
  const holed = block.ring ?? block;
  if (Array.isArray(holed.outer)) {
    return ringOf(holed.outer, Array.isArray(holed.holes) ? holed.holes.filter(isPoints) : []);
  }
  if (isPoint(block.circle?.centre) && typeof block.circle.radius_m === "number") {
    return { type: "circle", centre: block.circle.centre, radius_m: block.circle.radius_m };
  }
  if (isPoints(block.points) && block.points.length > 0) {
    return { type: "points", points: block.points };
  }
  if (isPoints(block.box) && block.box.length === 2) {
    return { type: "box", corners: block.box };
  }
  return referenceOf(block);
}

function ringOf(outer, holes) {
  return isPoints(outer) && outer.length > 0 ? { type: "ring", outer, holes } : null;
}

/** What a shape takes from another file, in words. */
function referenceOf(block) {
  if (typeof block.geojson === "string") {
    const feature = typeof block.feature === "string" ? `, feature ${block.feature}` : "";
    return { type: "reference", what: `from ${block.geojson}${feature}` };
  }
  if (typeof block.map === "string") {
    return { type: "reference", what: `from the map ${block.map}` };
  }
  if (typeof block.graph === "string") {
    return { type: "reference", what: `from the graph ${block.graph}` };
  }
  if (typeof block.wkt === "string") {
    return { type: "reference", what: "from well-known text" };
  }
  return typeof block.text === "string" ? { type: "reference", what: "a map of characters" } : null;
}

/** A block with another shape; its name, period and the like stay. */
export function blockWith(block, geometry) {
  const kept = Array.isArray(block) || block === null || block === undefined ? {} : { ...block };
  for (const key of SHAPE_KEYS) {
    delete kept[key];
  }
  switch (geometry.type) {
    case "ring":
      if (geometry.holes.length > 0) {
        return { outer: geometry.outer, holes: geometry.holes, ...kept };
      }
      return Object.keys(kept).length === 0 ? geometry.outer : { ring: geometry.outer, ...kept };
    case "circle":
      return { circle: { centre: geometry.centre, radius_m: geometry.radius_m }, ...kept };
    case "points":
      return { points: geometry.points };
    case "box":
      return { box: geometry.corners };
    default:
      return block;
  }
}

/** A document in which the shape at a path is another one. */
export function withGeometry(document, path, geometry) {
  if (pathKey(path) === pathKey(ENTRANCES)) {
    return withValue(document, path, geometry.points);
  }
  if (path[0] === "chargers") {
    return withValue(document, [...path, "at"], geometry.points[0]);
  }
  const isRobotStart = path.length === 4;
  const value = isRobotStart ? geometry.points[0] : blockWith(valueAt(document, path), geometry);
  return withValue(document, path, value);
}

/** A document without the shape at a path. */
export function withoutShape(document, path) {
  return withValue(document, path, path[0] === "area" ? [] : undefined);
}

/**
 * A document with one more shape, and the shape's path. A new area replaces the one before; a point joins the starts or
 * the entrances.
 * @returns {{document: any, path: (string|number)[]}}
 */
export function withNewShape(document, kind, geometry) {
  if (kind === "area") {
    return { document: withValue(document, ["area"], blockWith(null, geometry)), path: ["area"] };
  }
  if (kind === "start") {
    const before = document.fleet?.start?.points;
    const start = geometry.type === "points" && isPoints(before) ? { points: [...before, ...geometry.points] } : blockWith(null, geometry);
    return { document: withValue(document, ["fleet", "start"], start), path: ["fleet", "start"] };
  }
  if (kind === "entrance") {
    return { document: withValue(document, ENTRANCES, [...listAt(document, ENTRANCES), ...geometry.points]), path: ENTRANCES };
  }
  const list = { zone: "zones", charger: "chargers" }[kind] ?? "obstacles";
  const at = listAt(document, [list]).length;
  if (kind === "charger") {
    return { document: withValue(document, [list, at], { name: freeName(document, list, kind), at: geometry.points[0] }), path: [list, at] };
  }
  const block = kind === "zone" ? { name: freeName(document, list, kind), period_s: newPeriod(document), ...zoneBlock(geometry) } : blockWith(null, geometry);
  return { document: withValue(document, [list, at], block), path: [list, at] };
}

function zoneBlock(geometry) {
  const block = blockWith(null, geometry);
  return Array.isArray(block) ? { ring: block } : block;
}

/** The first name for one of a list that no other there has. */
function freeName(document, list, kind) {
  const taken = new Set(listAt(document, [list]).map((one) => one?.name));
  let number = 1;
  while (taken.has(`${kind} ${number}`)) {
    number += 1;
  }
  return `${kind} ${number}`;
}

/** A new zone's period: half of the area's. */
function newPeriod(document) {
  const period = document.period_s;
  return typeof period === "number" && period > 0 ? period / 2 : 60;
}

/** Whether a zone's or an obstacle's shape can be changed by hand. */
export function isEditable(shape) {
  return shape.geometry.type !== "reference";
}

/** All points of a geometry, circles by their centre. */
export function pointsOf(geometry) {
  switch (geometry.type) {
    case "ring":
      return [...geometry.outer, ...geometry.holes.flat()];
    case "circle":
      return [geometry.centre];
    case "points":
      return geometry.points;
    case "box":
      return geometry.corners;
    default:
      return [];
  }
}

/** A list inside a document; empty where there is none. */
export function listAt(document, path) {
  const value = valueAt(document, path);
  return Array.isArray(value) ? value : [];
}

function isPoint(value) {
  return Array.isArray(value) && value.length === 2 && value.every((number) => typeof number === "number");
}

function isPoints(value) {
  return Array.isArray(value) && value.every(isPoint);
}

function textOr(value, other) {
  return typeof value === "string" && value !== "" ? value : other;
}
