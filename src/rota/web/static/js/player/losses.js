/** What becomes of the ground when robots are lost: which places lapse, when first, and how much of each zone. */

import { lapsesFrom, stopsOf } from "./ages.js";
import { NO_CELL } from "./playback.js";

/**
 * @typedef {object} ZoneLapse
 * @property {number} demand
 * @property {number} first when its first place lapses, seconds
 * @property {number} entry which place that is
 * @property {number} area how many square metres lapse; 0 for a zone to visit
 * @property {boolean} visit whether the zone as a whole is to be visited
 */

export class Losses {
  /** @param {import("./playback.js").Playback} playback */
  constructor(playback) {
    this.playback = playback;
    /** @type {Map<number, number>} from when on each lost robot is lost */
    this.lost = new Map();
    this.stops = stopsOf(playback, this.lost);
    /** @type {{from: number, at: Float64Array}|null} */
    this.lapses = null;
    /** @type {ZoneLapse[]} */
    this.zones = [];
    this._undo = [];
  }

  get canUndo() {
    return this._undo.length > 0;
  }

  /** Loses a robot from a time on. */
  lose(robot, time) {
    this._keep();
    this.lost.set(robot, time);
    this._workOut();
  }

  /** Brings a robot back as if it had not been lost. */
  bringBack(robot) {
    this._keep();
    this.lost.delete(robot);
    this._workOut();
  }

  /** Takes the last loss or return back. */
  undo() {
    const before = this._undo.pop();
    if (!before) return;
    this.lost = before;
    this._workOut();
  }

  _keep() {
    this._undo.push(new Map(this.lost));
  }

  _workOut() {
    this.stops = stopsOf(this.playback, this.lost);
    this.zones = [];
    this.lapses = null;
    if (!this.lost.size) return;
    const from = Math.min(...this.lost.values());
    const at = lapsesFrom(this.playback, from, this.stops);
    const anyway = lapsesFrom(this.playback, from, stopsOf(this.playback, new Map()));
    // what lapses as soon with all robots is not the loss's doing
    for (let entry = 0; entry < at.length; entry++) if (at[entry] >= anyway[entry]) at[entry] = Infinity;
    this.lapses = { from, at };
    this.zones = this._byZone(at);
  }

  _byZone(at) {
    const { cell_demand: demands, cell_index: index } = this.playback.arrays;
    const square = this.playback.grid.cell_m ** 2;
    /** @type {Map<number, ZoneLapse>} */
    const zones = new Map();
    for (let entry = 0; entry < at.length; entry++) {
      if (at[entry] === Infinity) continue;
      const visit = index[entry] === NO_CELL;
      const demand = demands[entry];
      const zone = zones.get(demand) ?? { demand, first: Infinity, entry, area: 0, visit };
      if (at[entry] < zone.first) {
        zone.first = at[entry];
        zone.entry = entry;
      }
      zone.area += visit ? 0 : square;
      zones.set(demand, zone);
    }
    return [...zones.values()].sort((a, b) => a.first - b.first);
  }
}
