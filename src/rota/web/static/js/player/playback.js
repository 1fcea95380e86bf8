/** A playback as the server sends it: a header, plain arrays, and where robots are at any time. */

const TYPES = { f64: Float64Array, f32: Float32Array, u32: Uint32Array, u16: Uint16Array, u8: Uint8Array };
const HEAD_BYTES = 16;
const VERSION = 1;

/** The cell index of an entry that stands for a zone to visit. */
export const NO_CELL = 0xffffffff;

/**
 * @typedef {object} Robot
 * @property {string} name
 * @property {{shape: "disc"|"square", radius_m?: number, side_m?: number, half_angle_deg: number|null}} sensor
 * @property {number} body_radius_m
 * @property {number} speed_m_s
 * @property {number} loop_start_s
 * @property {number} end_s
 * @property {boolean} loops
 * @property {number} joins_s
 * @property {number|null} leaves_s
 * @property {[number, number, number][]} charges from when until when of its own time, and the charger's number
 * @property {{reserve: number, again_s: number, every_s: number}|null} battery
 */

export class Playback {
  /**
   * @param {object} header
   * @param {Record<string, any>} arrays typed arrays by name
   */
  constructor(header, arrays) {
    this.header = header;
    this.arrays = arrays;
    /** @type {Robot[]} */
    this.robots = header.robots;
    this.demands = header.demands;
    this.clock = header.clock;
    this.grid = header.grid;
    /** How many entries there are: asked cells, then zones to visit. */
    this.entries = arrays.cell_index.length;
    this.periods = Float64Array.from(arrays.cell_demand, (demand) => header.demands[demand].period_s);
    this.hasBatteries = "battery_share" in arrays;
    this.hasHeights = "corner_z_m" in arrays;
    this.rowOfCell = new Map();
    this._hints = new Uint32Array(this.robots.length);
    for (let entry = 0; entry < this.entries; entry++) {
      if (arrays.cell_index[entry] !== NO_CELL) this.rowOfCell.set(arrays.cell_index[entry], entry);
    }
  }

  /**
   * @param {ArrayBuffer} buffer
   * @returns {Playback}
   * @throws {Error} for bytes that are no playback
   */
  static decode(buffer) {
    const view = new DataView(buffer);
    const magic = new TextDecoder().decode(buffer.slice(0, 8));
    if (buffer.byteLength < HEAD_BYTES || magic !== "ROTAPLAY" || view.getUint32(8, true) !== VERSION) {
      throw new Error(`This is no playback of version ${VERSION}.`);
    }
    const length = view.getUint32(12, true);
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, HEAD_BYTES, length)));
    const begin = HEAD_BYTES + length;
    /** @type {Record<string, any>} */
    const arrays = {};
    for (const [name, told] of Object.entries(header.arrays)) {
      arrays[name] = new TYPES[told.type](buffer, begin + told.offset, told.length);
    }
    return new Playback(header, arrays);
  }

  /** Seconds of the robot's own trajectory at a time: within its loop where it goes round. */
  localTime(robot, time) {
    const { loop_start_s: start, end_s: end, loops } = this.robots[robot];
    if (time <= end || !loops) return Math.min(time, end);
    return start + ((time - start) % (end - start));
  }

  /** The index of the leg's first corner at the robot's own time. */
  cornerAt(robot, local) {
    const { corner_offsets: offsets, corner_time_s: times } = this.arrays;
    const first = offsets[robot];
    const last = offsets[robot + 1] - 1;
    const hint = Math.min(Math.max(this._hints[robot], first), last);
    if (times[hint] <= local && (hint === last || local < times[hint + 1])) return hint;
    let low = first;
    let high = last;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (times[middle] <= local) low = middle;
      else high = middle - 1;
    }
    this._hints[robot] = low;
    return low;
  }

  /**
   * Where a robot is: x, y and height in metres and the direction of its leg, put into `out`.
   * @param {number} robot
   * @param {number} time
   * @param {{x: number, y: number, z: number, dx: number, dy: number}} out
   */
  place(robot, time, out) {
    const { corner_offsets: offsets, corner_time_s: times, corner_x_m: xs, corner_y_m: ys, corner_z_m: zs } = this.arrays;
    const local = this.localTime(robot, time);
    const at = this.cornerAt(robot, local);
    const next = Math.min(at + 1, offsets[robot + 1] - 1);
    const share = next === at ? 0 : (local - times[at]) / (times[next] - times[at]);
    out.dx = xs[next] - xs[at];
    out.dy = ys[next] - ys[at];
    out.x = xs[at] + share * out.dx;
    out.y = ys[at] + share * out.dy;
    out.z = zs ? zs[at] + share * (zs[next] - zs[at]) : 0;
    return out;
  }

  /** Radius or half side in metres of what a robot has in range from a height. */
  reach(robot, height) {
    const { shape, radius_m: radius, side_m: side, half_angle_deg: angle } = this.robots[robot].sensor;
    if (shape === "square") return side / 2;
    if (angle === null) return radius;
    return Math.min(radius, Math.max(height, 0) * Math.tan((angle * Math.PI) / 180));
  }

  /** Whether a robot takes part at a time, losses aside. */
  takesPart(robot, time) {
    const { joins_s: joins, leaves_s: leaves } = this.robots[robot];
    return time >= joins && (leaves === null || time <= leaves);
  }

  /** The number of the charger that a robot is on at a time; -1: it is on none. */
  chargerAt(robot, time) {
    const { charges, loops, loop_start_s: start, end_s: end } = this.robots[robot];
    if (!charges.length) return -1;
    const local = this.localTime(robot, time);
    const own = loops && local === end ? start : local;
    return charges.find(([from, until]) => from <= own && (own < until || (!loops && own === end)))?.[2] ?? -1;
  }

  /** The share that is left in a robot's battery at a time; null: it has none that runs low. */
  charge(robot, time) {
    const { battery } = this.robots[robot];
    if (battery === null) return null;
    const { battery_offsets: offsets, battery_time_s: times, battery_share: shares } = this.arrays;
    const { again_s: again, every_s: every } = battery;
    const own = every > 0 && time > again ? again + ((time - again) % every) : time;
    let low = offsets[robot];
    let high = offsets[robot + 1] - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (times[middle] <= own) low = middle;
      else high = middle - 1;
    }
    const next = Math.min(low + 1, offsets[robot + 1] - 1);
    const lasts = times[next] - times[low];
    return shares[low] + (lasts > 0 ? Math.max(0, own - times[low]) / lasts : 0) * (shares[next] - shares[low]);
  }

  /** The number of the entry at a place in metres, -1 where nothing is asked. */
  entryAt(x, y) {
    const { x0_m: x0, y0_m: y0, cell_m: size, columns, rows } = this.grid;
    const column = Math.floor((x - x0) / size);
    const row = Math.floor((y - y0) / size);
    if (column < 0 || row < 0 || column >= columns || row >= rows) return -1;
    return this.rowOfCell.get(row * columns + column) ?? -1;
  }

  /** The middle of an entry's cell in metres; of a zone to visit, the middle of its bounds. */
  middleOf(entry) {
    const { x0_m: x0, y0_m: y0, cell_m: size, columns } = this.grid;
    const index = this.arrays.cell_index[entry];
    if (index !== NO_CELL) {
      return [x0 + ((index % columns) + 0.5) * size, y0 + (Math.floor(index / columns) + 0.5) * size];
    }
    const name = this.demands[this.arrays.cell_demand[entry]].name;
    const zone = this.header.mission.zones.find((other) => other.name === name);
    const [x1, y1, x2, y2] = boundsOf(zone.shape);
    return [(x1 + x2) / 2, (y1 + y2) / 2];
  }
}

/** Bounds of polygons as plan files have them: x0, y0, x1, y1. */
export function boundsOf(polygons) {
  const bounds = [Infinity, Infinity, -Infinity, -Infinity];
  for (const polygon of polygons) {
    for (const [x, y] of polygon[0]) {
      bounds[0] = Math.min(bounds[0], x);
      bounds[1] = Math.min(bounds[1], y);
      bounds[2] = Math.max(bounds[2], x);
      bounds[3] = Math.max(bounds[3], y);
    }
  }
  return bounds;
}

/** Whether a place lies in polygons, by the parity of crossings. */
export function contains(polygons, x, y) {
  let inside = false;
  for (const polygon of polygons) {
    for (const ring of polygon) {
      for (let i = 0, j = ring.length - 1; i < ring.length; j = i++) {
        const [xi, yi] = ring[i];
        const [xj, yj] = ring[j];
        if (yi > y !== yj > y && x < ((xj - xi) * (y - yi)) / (yj - yi) + xi) inside = !inside;
      }
    }
  }
  return inside;
}
