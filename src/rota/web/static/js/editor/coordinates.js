/** A mission in metres as one in longitude and latitude, and back. */

import { round7, toDegrees, toMetres } from "../geodesy.js";
import { isOrigin, middleOf } from "./frame.js";
import { isEditable, shapesOf, withGeometry } from "./shapes.js";

const MILLIMETRES = 1000;

/** Whether a document can be written the other way: shapes of other files stay as they are written there. */
export function canConvert(document) {
  return shapesOf(document).every(isEditable);
}

/** The document in WGS84; its metres count from an origin. */
export function inDegrees(document, origin) {
  const point = ([x, y]) => toDegrees(origin, x, y).map(round7);
  return { ...converted(document, point), coordinates: "wgs84", origin: { lat: origin.lat, lon: origin.lon } };
}

/** The document in metres about its origin, or about the middle of its shapes. */
export function inMetres(document) {
  const origin = isOrigin(document.origin) ? document.origin : middleOf(document);
  if (origin === null) {
    const { origin: _, ...rest } = document;
    return { ...rest, coordinates: "metres" };
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

