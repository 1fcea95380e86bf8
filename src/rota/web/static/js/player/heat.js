/** The heat map: one image of as many pixels as there are cells, painted through a lookup table. */

import { agesInto, ON_TIME } from "./ages.js";
import { EXCLUDED, LATE, LEVELS, NEVER, NOT_YET, STRIPE, pixel, table } from "./colours.js";
import { NO_CELL } from "./playback.js";

/** @typedef {"age"|"worst"|"lapse"|"entries"|"none"} Mode */

const LATE_PIXEL = pixel(LATE);
const STRIPE_PIXEL = pixel(STRIPE);
const NEVER_PIXEL = pixel(NEVER);
const NOT_YET_PIXEL = pixel(NOT_YET, 140);

export class HeatMap {
  /** @param {import("./playback.js").Playback} playback */
  constructor(playback) {
    this.playback = playback;
    this.ages = new Float32Array(playback.entries);
    this._table = table();
    this._image = image(playback.grid.columns, playback.grid.rows);
    this._shown = shownCells(playback);
    const cells = playback.header.cells;
    this._bounceImage = cells ? image(cells.columns, cells.rows) : null;
    this.canvas = this._image.canvas;
    this.grid = playback.grid;
    /** Square metres that are late at the time painted last, by demand. */
    this.late = new Float64Array(playback.demands.length);
  }

  /**
   * Paints what is to be shown at a time into `canvas`, a pixel for each cell of `grid`.
   * @param {Mode} mode
   * @param {number} time
   * @param {Float64Array} stops
   * @param {{from: number, at: Float64Array}|null} lapses
   * @param {Float32Array|null} [ages] in place of those by plan
   */
  paint(mode, time, stops, lapses, ages = null) {
    if (ages) this.ages.set(ages.subarray(0, this.ages.length));
    else agesInto(this.playback, time, stops, this.ages);
    // what was not seen before all robots are on their loops may wait for a period from then on
    this._waited = time - this.playback.clock.from_s;
    this._countLate();
    if (mode === "entries" && this._bounceImage) {
      this._paintEntries(time);
      return;
    }
    this.canvas = this._image.canvas;
    this.grid = this.playback.grid;
    this._image.pixels.fill(0);
    if (mode === "age") this._paintAges();
    else if (mode === "worst") this._paintShares(this.playback.arrays.cell_worst);
    else if (mode === "lapse" && lapses) this._paintLapses(lapses);
    if (mode !== "none") this._paintExcluded();
    this._image.show();
  }

  _countLate() {
    const { cell_demand: demand, cell_index: index } = this.playback.arrays;
    const square = this.playback.grid.cell_m ** 2;
    this.late.fill(0);
    for (let entry = 0; entry < this.ages.length; entry++) {
      if (index[entry] !== NO_CELL && this.isLate(entry)) this.late[demand[entry]] += square;
    }
  }

  /** Whether an entry's period is over at the time painted last. */
  isLate(entry) {
    const age = this.ages[entry];
    return (age === Infinity ? this._waited : age) > this.playback.periods[entry] * ON_TIME;
  }

  _paintAges() {
    const { pixels, entries, stripes } = this._shown;
    const { periods } = this.playback;
    const target = this._image.pixels;
    for (let k = 0; k < pixels.length; k++) {
      const age = this.ages[entries[k]];
      const share = age / periods[entries[k]];
      if (share <= 1) target[pixels[k]] = this._table[(share * (LEVELS - 1)) | 0];
      else if (age === Infinity && this._waited <= periods[entries[k]]) target[pixels[k]] = NOT_YET_PIXEL;
      else if (age === Infinity) target[pixels[k]] = stripes[k] & 2 ? LATE_PIXEL : NEVER_PIXEL;
      else if (share <= ON_TIME) target[pixels[k]] = this._table[LEVELS - 1];
      else target[pixels[k]] = stripes[k] & 1 ? STRIPE_PIXEL : LATE_PIXEL;
    }
  }

  _paintShares(shares) {
    const { pixels, entries, stripes } = this._shown;
    const target = this._image.pixels;
    for (let k = 0; k < pixels.length; k++) {
      const share = shares[entries[k]];
      if (share <= ON_TIME) target[pixels[k]] = this._table[Math.min((share * (LEVELS - 1)) | 0, LEVELS - 1)];
      else if (share === Infinity) target[pixels[k]] = stripes[k] & 2 ? LATE_PIXEL : NEVER_PIXEL;
      else target[pixels[k]] = stripes[k] & 1 ? STRIPE_PIXEL : LATE_PIXEL;
    }
  }

  /** What lapses after a loss: the sooner, the brighter; striped. What is served on time is faint. */
  _paintLapses({ from, at }) {
    const { pixels, entries, stripes } = this._shown;
    const target = this._image.pixels;
    const calm = pixel([120, 130, 140], 60);
    for (let k = 0; k < pixels.length; k++) {
      const lapse = at[entries[k]];
      const wait = (lapse - from) / (2 * this.playback.periods[entries[k]]);
      if (lapse === Infinity) target[pixels[k]] = calm;
      else if (stripes[k] & 1) target[pixels[k]] = LATE_PIXEL;
      else target[pixels[k]] = this._table[Math.max(0, LEVELS - 1 - ((Math.min(wait, 1) * (LEVELS - 1)) | 0))];
    }
  }

  _paintExcluded() {
    const { columns, rows } = this.playback.grid;
    const grey = pixel(EXCLUDED);
    for (const index of this.playback.arrays.excluded_index) {
      this._image.pixels[(rows - 1 - Math.floor(index / columns)) * columns + (index % columns)] = grey;
    }
  }

  /** How often robots that bounce enter each cell in a loop; cells that were not entered yet are faint. */
  _paintEntries(time) {
    const { columns, rows, most } = this.playback.header.cells;
    const { cell_entries: entries, cell_entered_s: entered } = this.playback.arrays;
    const target = this._bounceImage.pixels;
    const scale = most > 20 ? (value) => Math.log(value) / Math.log(most) : (value) => value / most;
    for (let cell = 0; cell < entries.length; cell++) {
      const row = rows - 1 - Math.floor(cell / columns);
      const colour = this._table[Math.round(scale(Math.max(entries[cell], 1)) * (LEVELS - 1))];
      const faint = ((colour & 0xffffff) | (0x40 << 24)) >>> 0;
      target[row * columns + (cell % columns)] = entries[cell] === 0 ? 0 : entered[cell] <= time ? colour : faint;
    }
    this._bounceImage.show();
    this.canvas = this._bounceImage.canvas;
    this.grid = this.playback.header.cells;
  }
}

/** A canvas with its pixels as 32-bit numbers. */
function image(columns, rows) {
  const canvas = document.createElement("canvas");
  canvas.width = columns;
  canvas.height = rows;
  const context = canvas.getContext("2d");
  const data = context.createImageData(columns, rows);
  return { canvas, pixels: new Uint32Array(data.data.buffer), show: () => context.putImageData(data, 0, 0) };
}

/**
 * Which pixels show which entry, and where stripes run. A cell whose middle lies in a wall or just outside may still
 * reach inside; it shows what a neighbour shows.
 */
function shownCells(playback) {
  const { columns, rows } = playback.grid;
  const shown = new Int32Array(columns * rows).fill(-1);
  for (const [index, entry] of playback.rowOfCell) shown[index] = entry;
  const pixels = [];
  const entries = [];
  const stripes = [];
  const beside = [[0, 1], [0, -1], [1, 0], [-1, 0], [1, 1], [1, -1], [-1, 1], [-1, -1]];
  for (let row = 0; row < rows; row++) {
    for (let column = 0; column < columns; column++) {
      let entry = shown[row * columns + column];
      for (let k = 0; entry < 0 && k < beside.length; k++) {
        const [down, right] = [row + beside[k][0], column + beside[k][1]];
        if (down >= 0 && down < rows && right >= 0 && right < columns) entry = shown[down * columns + right];
      }
      if (entry < 0) continue;
      pixels.push((rows - 1 - row) * columns + column);
      entries.push(entry);
      stripes.push(((row + column) % 4 === 0 ? 1 : 0) | ((row - column + 4 * columns) % 4 === 0 ? 2 : 0));
    }
  }
  return { pixels: Uint32Array.from(pixels), entries: Uint32Array.from(entries), stripes: Uint8Array.from(stripes) };
}
