/** What a robot sees from where it is: its sensor's range, cut by the walls that hide what lies behind. */

import { contains } from "./playback.js";

const RAYS = 48;
const BESIDE = 1e-5; // radians past a corner, where sight goes on

export class Walls {
  /** @param {object} mission the header's mission */
  constructor(mission) {
    this.solid = mission.obstacles.filter(({ blocks }) => blocks !== "motion").map(({ shape }) => shape);
    const edges = [];
    for (const polygons of this.solid) {
      for (const polygon of polygons) {
        for (const ring of polygon) {
          ring.forEach(([x, y], k) => edges.push(x, y, ...ring[(k + 1) % ring.length]));
        }
      }
    }
    this.edges = Float64Array.from(edges);
  }

  /** The edges that come into a square of half side `reach` round a place, as numbers relative to it. */
  near(x, y, reach) {
    const { edges } = this;
    const found = [];
    for (let k = 0; k < edges.length; k += 4) {
      const [x0, y0, x1, y1] = [edges[k] - x, edges[k + 1] - y, edges[k + 2] - x, edges[k + 3] - y];
      if (Math.min(x0, x1) > reach || Math.max(x0, x1) < -reach) continue;
      if (Math.min(y0, y1) > reach || Math.max(y0, y1) < -reach) continue;
      found.push(x0, y0, x1, y1);
    }
    return found;
  }

  /**
   * The outline of what is seen, as x, y in turn; null: nothing is in the way.
   * @param {"disc"|"square"} shape
   * @param {number} reach radius or half side
   */
  outline(x, y, shape, reach) {
    const near = this.near(x, y, reach);
    if (!near.length) return null;
    if (this.solid.some((polygons) => contains(polygons, x, y))) return [];
    const square = shape === "square";
    const angles = Array.from({ length: RAYS }, (_, k) => (2 * Math.PI * k) / RAYS);
    if (square) for (const corner of [1, 3, 5, 7]) angles.push((corner * Math.PI) / 4);
    for (let k = 0; k < near.length; k += 2) {
      const angle = Math.atan2(near[k + 1], near[k]);
      angles.push(angle - BESIDE, angle, angle + BESIDE);
    }
    const whole = 2 * Math.PI;
    const sorted = angles.map((angle) => ((angle % whole) + whole) % whole).sort((a, b) => a - b);
    const outline = [];
    for (const angle of sorted) {
      const [dx, dy] = [Math.cos(angle), Math.sin(angle)];
      const range = square ? reach / Math.max(Math.abs(dx), Math.abs(dy)) : reach;
      const far = Math.min(range, this._hit(near, dx, dy));
      outline.push(x + far * dx, y + far * dy);
    }
    return outline;
  }

  /** How far a ray from the middle gets before it meets an edge. */
  _hit(near, dx, dy) {
    let nearest = Infinity;
    for (let k = 0; k < near.length; k += 4) {
      const [ex, ey] = [near[k + 2] - near[k], near[k + 3] - near[k + 1]];
      const across = dx * ey - dy * ex;
      if (across === 0) continue;
      const along = (near[k] * ey - near[k + 1] * ex) / across;
      const part = (near[k] * dy - near[k + 1] * dx) / across;
      if (along > 0 && part >= 0 && part <= 1 && along < nearest) nearest = along;
    }
    return nearest;
  }
}
