/**
 * Where a document's points lie on the map.
 *
 * Metres are shown as they are, longitudes and latitudes as local metres about an origin, or, with tiles, as they are.
 */

import { originOf, round7, toDegrees, toMetres } from "../geodesy.js";
import { pointsOf, shapesOf } from "./shapes.js";

const MILLIMETRES = 1000;

export class Frame {
  /**
   * @param {"metres"|"wgs84"} coordinates
   * @param {import("../geodesy.js").Origin|null} origin of the map's metres; null where none is known
   * @param {boolean} tiled whether the map shows tiles, in Web Mercator
   * @param {boolean} isPlaced whether the origin is where the mission lies; false while nothing says where
   */
  constructor(coordinates, origin, tiled, isPlaced = true) {
    this.coordinates = coordinates;
    this.isPlaced = isPlaced;
    this.origin = origin;
    this.tiled = tiled && origin !== null;
  }

  /** The frame of a document; the one before stays where it serves, so that the map does not move under the hand. */
  static of(document, before, tiled) {
    const coordinates = document.coordinates === "wgs84" ? "wgs84" : "metres";
    const given = isOrigin(document.origin) ? document.origin : null;
    if (coordinates === "metres") {
      const same = before !== null && before.coordinates === "metres" && before.tiled === (tiled && given !== null);
      return same && sameOrigin(before.origin, given) ? before : new Frame("metres", given, tiled);
    }
    if (before !== null && before.coordinates === "wgs84") {
      return before;
    }
    const middle = middleOf(document);
    return new Frame("wgs84", middle ?? { lat: 0, lon: 0 }, tiled, middle !== null);
  }

  /** The map's place of a point of the document. */
  toMap(point) {
    if (this.coordinates === "metres") {
      return this.metresToMap(point[0], point[1], this.origin);
    }
    return this.tiled ? [point[1], point[0]] : swapped(toMetres(this.origin, point[0], point[1]));
  }

  /** The document's point of a place on the map, rounded to what hands can mean: millimetres, 1e-7 degrees. */
  fromMap({ lat, lng }) {
    if (this.coordinates === "metres") {
      const [x, y] = this.tiled ? toMetres(this.origin, lng, lat) : [lng, lat];
      return [Math.round(x * MILLIMETRES) / MILLIMETRES, Math.round(y * MILLIMETRES) / MILLIMETRES];
    }
    const [lon, latitude] = this.tiled ? [lng, lat] : toDegrees(this.origin, lng, lat);
    return [round7(lon), round7(latitude)];
  }

  /** The map's place of local metres about some origin: what the server resolves, and plans. */
  metresToMap(x, y, origin) {
    if (this.origin === null || origin === null || (!this.tiled && sameOrigin(origin, this.origin))) {
      return [y, x];
    }
    const [lon, lat] = toDegrees(origin, x, y);
    return this.tiled ? [lat, lon] : swapped(toMetres(this.origin, lon, lat));
  }

  /** The place on the map so many metres east and north of another. */
  beside({ lat, lng }, east_m, north_m) {
    if (!this.tiled) {
      return { lat: lat + north_m, lng: lng + east_m };
    }
    const [lon, latitude] = toDegrees({ lat, lon: lng }, east_m, north_m);
    return { lat: latitude, lng: lon };
  }

  /** Metres between two places on the map. */
  distance(a, b) {
    if (!this.tiled) {
      return Math.hypot(a.lat - b.lat, a.lng - b.lng);
    }
    const [x, y] = toMetres({ lat: a.lat, lon: a.lng }, b.lng, b.lat);
    return Math.hypot(x, y);
  }
}

/** Whether two origins are one. */
export function sameOrigin(a, b) {
  return a === b || (a !== null && b !== null && a.lat === b.lat && a.lon === b.lon);
}

/** Whether a value of a document places it on the globe. */
export function isOrigin(value) {
  return typeof value?.lat === "number" && typeof value?.lon === "number";
}

/** The centre of a document's area in degrees, where its local metres begin; of all shapes without an area, else null. */
export function middleOf(document) {
  const shapes = shapesOf(document);
  const area = shapes.filter((shape) => shape.kind === "area" && pointsOf(shape.geometry).length > 0);
  const points = (area.length > 0 ? area : shapes).flatMap((shape) => pointsOf(shape.geometry));
  const good = points.filter(([lon, lat]) => Math.abs(lon) <= 180 && Math.abs(lat) <= 90);
  if (good.length === 0) {
    return null;
  }
  const [lons, lats] = [good.map((point) => point[0]), good.map((point) => point[1])];
  const least = (values) => values.reduce((a, b) => Math.min(a, b));
  const greatest = (values) => values.reduce((a, b) => Math.max(a, b));
  return originOf(least(lons), least(lats), greatest(lons), greatest(lats));
}

function swapped([x, y]) {
  return [y, x];
}
