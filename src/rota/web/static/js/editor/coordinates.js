/** A mission in metres as one in longitude and latitude, and back. */

import { round7, toDegrees, toMetres } from "../geodesy.js";
import { middleOf } from "./frame.js";
import { isEditable, listAt, shapesOf, withGeometry } from "./shapes.js";

const MILLIMETRES = 1000;

/** Whether a document can be written the other way: shapes of other files, and obstacles that move, stay as written. */
export function canConvert(document) {
  return shapesOf(document).every(isEditable) && listAt(document, ["moving_obstacles"]).length === 0;
}

/** The document in WGS84; its metres counted from an origin. The area's middle is the origin then. */
export function inDegrees(document, origin) {
  const point = ([x, y]) => toDegrees(origin, x, y).map(round7);
  const { origin: _, ...rest } = converted(document, point);
  return { ...rest, coordinates: "wgs84" };
}

/** The document in metres about the middle of its area. */
export function inMetres(document) {
  const origin = middleOf(document);
  if (origin === null) {
    return { ...document, coordinates: "metres" };
  }
  const point = ([lon, lat]) => toMetres(origin, lon, lat).map((value) => Math.round(value * MILLIMETRES) / MILLIMETRES);
  return { ...converted(document, point), coordinates: "metres", origin };
}

function converted(document, point) {
  let next = document;
  for (const shape of shapesOf(document)) {
    next = withGeometry(next, shape.path, movedGeometry(shape.geometry, point));
  }
  return next;
}

function movedGeometry(geometry, point) {
  switch (geometry.type) {
    case "ring":
      return { ...geometry, outer: geometry.outer.map(point), holes: geometry.holes.map((hole) => hole.map(point)) };
    case "circle":
      return { ...geometry, centre: point(geometry.centre) };
    case "points":
      return { ...geometry, points: geometry.points.map(point) };
    case "box":
      return { ...geometry, corners: geometry.corners.map(point) };
    default:
      return geometry;
  }
}

