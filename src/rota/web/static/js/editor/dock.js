/** A dock: a box in which all robots of a fleet start side by side. */

const ROOM = 2; // times the robots that are surely needed, since a plan may need more
const APART = 1.2; // times two body radii, so that bodies leave one after another without touching
const LEAST_M = 2;

/**
 * The box round a place that has room for a fleet, in the document's coordinates.
 * @param {{lat: number, lng: number}} place on the map
 * @param {import("./frame.js").Frame} frame
 * @param {any} document
 * @param {number} robots that are surely needed
 * @returns {import("./shapes.js").Geometry}
 */
export function dockAt(place, frame, document, robots) {
  const body_m = document.fleet?.body_radius_m ?? 0;
  const rows = Math.ceil(Math.sqrt(ROOM * Math.max(robots, 1)));
  const half_m = Math.max((rows * 2 * body_m * APART) / 2, LEAST_M / 2);
  const corners = [-half_m, half_m].map((step_m) => frame.fromMap(frame.beside(place, step_m, step_m)));
  return { type: "box", corners };
}
