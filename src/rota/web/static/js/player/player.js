/** The player: a playback on a Leaflet map with its controls. */

/* global L */

import { lapsesFrom } from "./ages.js";
import { CoverageChart } from "./chart.js";
import { Clock } from "./clock.js";
import { contains } from "./playback.js";
import { drawGround, drawHeat, drawMoving, trace } from "./ground.js";
import { HeatMap } from "./heat.js";
import { Losses } from "./losses.js";
import { Panel } from "./panel.js";
import { Robots } from "./robots.js";
import { Walls } from "./sight.js";
import { Stage } from "./stage.js";
import { colours, onThemeChange } from "./theme.js";
import { plain } from "./text.js";
import { timelineOf } from "./timeline.js";

const TOLD_EVERY_MS = 100; // texts change so often at most; pictures at every frame
const PLACE_EVERY_MS = 500;
const HIT_PIXELS = 12;
const MANY = 60;

const FOCUSED = "button, input, select, summary";

/** What a control is called, by which it is found again in a panel made anew. */
function nameOf(node) {
  return node.getAttribute("aria-label") ?? node.labels?.[0]?.textContent ?? node.textContent;
}

/** Whether two plans take over at one moment, without the same robots. */
function sameChange(seam, other) {
  return Boolean(other) && seam.at_s === other.at_s && String(seam.lost) === String(other.lost);
}

/** A place in the plan's own metres. */
function inMetres(x, y) {
  return `(${plain(x)}, ${plain(y)}) m`;
}

/**
 * Events: `place` {entry, x, y}, `robot` {robot}, `violation` {violation}, `time` {time}.
 */
export class Player extends EventTarget {
  /**
   * @param {object} options
   * @param {import("./playback.js").Playback} options.playback
   * @param {any} options.map a Leaflet map
   * @param {HTMLElement} options.controls what the panel is put into
   * @param {(x: number, y: number) => any} [options.project] metres to LatLng; default lat = y, lng = x
   * @param {(x: number, y: number) => string} [options.where] metres as a place in words
   * @param {number} [options.opacity] of the heat map, for a map with tiles below
   * @param {((change: {at_s: number, lost: string[]}) => Promise<void>)|null} [options.replan] asks for a plan that
   *   takes over; null: nobody can be asked
   */
  constructor({ playback, map, controls, project = (x, y) => L.latLng(y, x), where = inMetres, opacity = 1, replan = null }) {
    super();
    Object.assign(this, { map, controls, project, where, opacity, replan });
    this.shown = { footprints: true, routes: playback.robots.length <= MANY, trails: true };
    this._colours = colours();
    this._endTheme = onThemeChange(() => this._recolour());
    this._click = (event) => this._clicked(event);
    this._key = (event) => this._pressed(event);
    map.on("click", this._click);
    document.addEventListener("keydown", this._key);
    this._take(playback, null);
    this._last = performance.now();
    /** Milliseconds of script that the last frames took, for measuring. */
    this.frameCosts = [];
    this._frame = requestAnimationFrame((now) => this._step(now));
  }

  destroy() {
    cancelAnimationFrame(this._frame);
    this._endTheme();
    this.map.off("click", this._click);
    document.removeEventListener("keydown", this._key);
    this._stage.destroy();
    this.controls.replaceChildren();
  }

  /** Shows another plan in place of this one, at the same time and speed. */
  replace(playback) {
    const { clock } = this;
    this._stage.destroy();
    this._take(playback, clock);
  }

  /** Makes everything that depends on the playback. */
  _take(playback, before) {
    const shown = this.playback;
    this.playback = playback;
    this.clock = new Clock(playback.clock);
    this.clock.time = Clock.steady(playback.clock, playback.header.report.first_coverage_s);
    this.clock.playing = !window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    if (before) {
      Object.assign(this.clock, { speed: before.speed, playing: before.playing, startsAt: before.startsAt });
      const time = Math.min(before.time, this.clock.end);
      this.clock.time = this._sought ? time : Math.max(time, this.clock.time);
    }
    // a plan that takes over is looked at from the change on
    const { seam } = playback.header;
    if (seam && !(shown && sameChange(seam, shown.header.seam))) this.clock.time = 0;
    /** What is heard of robots that are watched now; null: the plan is played. */
    this.live = null;
    // a place that no loop sees only grows older
    this._steady = playback.arrays.cell_worst.every(Number.isFinite);
    this.clock.mayWrap = this._steady;
    this.losses = new Losses(playback);
    this.heat = new HeatMap(playback);
    this.robots = new Robots(playback, new Walls(playback.header.mission));
    this.chart = playback.header.coverage ? new CoverageChart(playback, (time) => this.seek(time)) : null;
    const modes = playback.rowOfCell.size ? ["age", "worst", "none"] : ["none", "age"];
    if (playback.header.cells) modes.unshift("entries");
    this.mode = before && modes.includes(this.mode) ? this.mode : modes[0];
    this.chosenEntry = -1;
    this.chosenRobot = -1;
    this._dirty = true;
    this._toldAt = -Infinity;
    this._stage = new Stage(this.map, this.project, playback.header.bounds_m, ["heat", "shapes", "moving"], () => {
      this._groundDirty = true;
      this._dirty = true;
    });
    const focused = this.controls.contains(document.activeElement) ? nameOf(document.activeElement) : null;
    this.panel = new Panel(this, this.controls);
    this.panel.showLosses();
    this.panel.showTime();
    if (focused) [...this.controls.querySelectorAll(FOCUSED)].find((node) => nameOf(node) === focused)?.focus();
  }

  // ------------------------------------------------------------ what the controls do

  toggle() {
    const { clock } = this;
    if (clock.startsAt !== null) clock.startsAt = null;
    else if (!clock.playing && clock.span.repeat_s === 0 && clock.time >= clock.end) {
      clock.time = 0;
      clock.playing = true;
    } else clock.playing = !clock.playing;
    this._changed();
  }

  seek(time) {
    this._sought = true;
    this.clock.seek(time);
    this._changed();
  }

  setSpeed(speed) {
    this.clock.speed = speed;
  }

  /** Follows the clock on the wall; `start`: milliseconds of time 0; null: no more. */
  followClock(start) {
    this.clock.startsAt = start;
    this.clock.playing = false;
    this._changed();
  }

  setMode(mode) {
    this.mode = mode;
    this.panel.mode.value = mode;
    this.panel.showLegend();
    this._changed();
  }

  show(name, on) {
    this.shown[name] = on;
    this._groundDirty = true;
    this._changed();
  }

  toggleLoss(robot) {
    if (this.losses.lost.has(robot)) this.losses.bringBack(robot);
    else this.losses.lose(robot, this.clock.time);
    this._lossesChanged();
  }

  undoLoss() {
    this.losses.undo();
    this._lossesChanged();
  }

  _lossesChanged() {
    const { losses, clock } = this;
    clock.mayStop = losses.lost.size === 0;
    clock.mayWrap = clock.mayStop && this._steady;
    if (losses.lapses) {
      const last = Math.max(...losses.zones.map(({ first }) => first), clock.time);
      clock.end = Math.max(clock.end, last + Math.max(0, ...this.playback.periods.slice(0, 1)));
    } else {
      clock.end = Math.max(this.playback.clock.end_s, clock.time);
      if (this.mode === "lapse") this.setMode("age");
    }
    this.panel.showLosses();
    this._groundDirty = true;
    this._showPlace();
    this._changed();
  }

  /**
   * Shows robots where they really are, and ages as they really are; null: the plan again.
   * @param {{time_s: number, robots: {robot: number, x_m: number|null, y_m: number|null, lost: boolean}[],
   *   ages?: (number|null)[]}|null} state `ages`: of the playback's entries; without them the last ones stay
   */
  showLive(state) {
    const began = state !== null && this.live === null;
    const ages = state?.ages ? Float32Array.from(state.ages, (age) => age ?? Infinity) : this.live?.ages ?? null;
    this.live = state === null ? null : { ...state, ages };
    if (began) {
      this.clock.playing = false;
      this.clock.startsAt = null;
      if (this.mode !== "age" && this.playback.rowOfCell.size) this.setMode("age");
    }
    this.panel.showLive(this.live !== null);
    this._changed();
  }

  /** The time that is shown: the clock's, or that of what was heard last. */
  get time() {
    return this.live === null ? this.clock.time : this.live.time_s;
  }

  /** Shows an entry's sightings; `fly`: and moves the map there. */
  choosePlace(entry, fly = false) {
    this.chosenEntry = entry;
    const [x, y] = this.playback.middleOf(entry);
    if (fly) this.flyTo(x, y);
    this._showPlace();
    this.panel.placeSection.open = true;
    this.panel.say(this.panel.place.querySelector("p").textContent);
    this._changed();
    this.dispatchEvent(new CustomEvent("place", { detail: { entry, x, y } }));
  }

  chooseRobot(robot, fly = false) {
    this.chosenRobot = robot;
    const [x, y] = [this.robots.places[2 * robot], this.robots.places[2 * robot + 1]];
    if (fly) this.flyTo(x, y);
    if (this.panel.pick) this.panel.pick.value = robot;
    this.panel.showLosses();
    this.panel.say(`${this.playback.robots[robot].name} at (${x.toFixed(1)}, ${y.toFixed(1)}) m.`);
    const row = this.panel.robotRows?.[robot];
    if (row && !fly) {
      row.closest("details").open = true;
      row.focus({ preventScroll: false });
    }
    this._changed();
    this.dispatchEvent(new CustomEvent("robot", { detail: { robot } }));
  }

  showViolation(violation) {
    if (violation.time_s !== null) this.seek(violation.time_s);
    if (violation.place_m !== null) this.flyTo(...violation.place_m);
    this.panel.say(violation.text);
    this.dispatchEvent(new CustomEvent("violation", { detail: { violation } }));
  }

  /** Goes to a place and a moment at which it has not been seen for longest since a plan took over. */
  showLateness({ place_m: [x, y], time_s: time, worst_at_least_s: late }, period) {
    this.seek(Math.max(0, time + period + (late ?? period)));
    this.setMode("age");
    const entry = this._entryAt(x, y);
    if (entry >= 0) this.choosePlace(entry);
    this.flyTo(x, y);
  }

  /** Goes to where and when a zone lapses first after a loss. */
  showLapse({ entry, first }) {
    this.seek(first);
    this.setMode("age");
    this.choosePlace(entry, true);
  }

  flyTo(x, y) {
    this._mark = [x, y];
    this.map.panTo(this.project(x, y));
    this._changed();
  }

  /** The entry of a demand that waits longest by plan; -1: it has none. */
  worstEntry(demand) {
    const { cell_demand: demands, cell_worst: worst } = this.playback.arrays;
    let found = -1;
    for (let entry = 0; entry < demands.length; entry++) {
      if (demands[entry] === demand && (found < 0 || worst[entry] > worst[found])) found = entry;
    }
    return found;
  }

  /** When each entry's period lapses from a time on, see `lapsesFrom`. */
  lapses(from) {
    return lapsesFrom(this.playback, from, this.losses.stops);
  }

  /** Whether robots that spread are shown, with the ground that they have in range. */
  get coversGround() {
    return this.playback.header.coverage?.what === "ground in range";
  }

  // ------------------------------------------------------------ frames

  _changed() {
    this._dirty = true;
    this._toldAt = -Infinity;
  }

  _recolour() {
    this._colours = colours();
    this._groundDirty = true;
    this._dirty = true;
  }

  _step(now) {
    this._frame = requestAnimationFrame((next) => this._step(next));
    const elapsed = Math.min((now - this._last) / 1000, 1);
    this._last = now;
    if (!this.clock.tick(elapsed) && !this._dirty) return;
    const begun = performance.now();
    this.draw();
    if (now - this._toldAt >= TOLD_EVERY_MS) {
      this._toldAt = now;
      this._tell();
    }
    this.frameCosts.push(performance.now() - begun);
    if (this.frameCosts.length > 600) this.frameCosts.shift();
  }

  /** Draws the time that the clock shows. */
  draw() {
    this._dirty = false;
    const { playback, time, live, losses, _stage: stage, _colours: palette } = this;
    if (this._groundDirty) {
      this._groundDirty = false;
      drawGround(stage, playback, palette, this.shown, losses.lost);
    }
    const pixel = 1 / stage.pixelsPerMetre;
    this.heat.paint(this.mode, time, losses.stops, losses.lapses, live?.ages);
    if (live) this.robots.moveTo(live.robots, time);
    else this.robots.move(time, losses.lost, pixel);
    drawHeat(stage, playback, this.heat, palette, this.opacity, (context) => {
      if (this.shown.footprints) this.robots.drawFootprints(context, palette, pixel);
    });
    const context = stage.begin("moving");
    this._drawVisits(context, pixel);
    drawMoving(context, playback.header.mission, time, palette, pixel);
    const shown = live ? { ...this.shown, trails: false } : this.shown;
    this.robots.draw(stage, context, shown, palette, this.chosenRobot);
    this._drawMark(stage, pixel);
  }

  /** A zone to visit that is late is striped. */
  _drawVisits(context, pixel) {
    this.lateVisits = [];
    const { arrays, entries, header, demands } = this.playback;
    for (let entry = this.playback.rowOfCell.size; entry < entries; entry++) {
      if (!this.heat.isLate(entry)) continue;
      const { name } = demands[arrays.cell_demand[entry]];
      this.lateVisits.push(name);
      const { shape } = header.mission.zones.find((zone) => zone.name === name);
      context.save();
      trace(context, shape);
      context.fillStyle = "rgb(228 0 58 / 0.5)";
      context.fill("evenodd");
      context.strokeStyle = this._colours.danger;
      context.lineWidth = 5 * pixel;
      context.stroke();
      context.restore();
    }
  }

  /** Cross hairs on the chosen place. */
  _drawMark(stage, pixel) {
    const place = this.chosenEntry >= 0 ? this.playback.middleOf(this.chosenEntry) : this._mark;
    if (!place) return;
    const context = stage.inPixels("moving");
    const [x, y] = stage.toPixels(...place);
    for (const [colour, width] of [[this._colours.halo, 4], [this._colours.ink, 2]]) {
      context.strokeStyle = colour;
      context.lineWidth = width;
      context.beginPath();
      context.arc(x, y, 8, 0, 2 * Math.PI);
      for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
        context.moveTo(x + 5 * dx, y + 5 * dy);
        context.lineTo(x + 13 * dx, y + 13 * dy);
      }
      context.stroke();
    }
  }

  _tell() {
    this.panel.showTime();
    this.panel.showLate(this.heat.late, this.lateVisits);
    this.chart?.update(this.time);
    this.panel.showBumps(this.time);
    this.panel.showBatteries(this.time);
    this.dispatchEvent(new CustomEvent("time", { detail: { time: this.time } }));
    if (!this.clock.playing || performance.now() - this._placeShownAt > PLACE_EVERY_MS) this._showPlace();
  }

  _showPlace() {
    const { place } = this.panel;
    // what somebody is about to use stays as it is
    if (this.chosenEntry < 0 || place.contains(document.activeElement)) return;
    this._placeShownAt = performance.now();
    const open = place.querySelector("details")?.open ?? false;
    const seek = (time) => this.seek(time);
    place.replaceChildren(timelineOf(this.playback, this.chosenEntry, this.time, this.losses.stops, seek, this.where));
    const table = place.querySelector("details");
    if (table) table.open = open;
  }

  // ------------------------------------------------------------ mouse and keyboard

  _clicked({ containerPoint }) {
    const [x, y] = this._stage.toMetres(containerPoint.x, containerPoint.y);
    const robot = this.robots.at(x, y, HIT_PIXELS / this._stage.pixelsPerMetre);
    if (robot >= 0) {
      this.chooseRobot(robot);
      return;
    }
    this.chosenRobot = -1;
    const entry = this._entryAt(x, y);
    if (entry >= 0) this.choosePlace(entry);
    else this._changed();
  }

  _entryAt(x, y) {
    const { playback } = this;
    const visits = playback.header.mission.zones.filter(({ demand, shape }) => demand === "visit" && contains(shape, x, y));
    for (const { name } of visits) {
      for (let entry = playback.rowOfCell.size; entry < playback.entries; entry++) {
        if (playback.demands[playback.arrays.cell_demand[entry]].name === name) return entry;
      }
    }
    return playback.entryAt(x, y);
  }

  _pressed(event) {
    if (event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey) return;
    const { target } = event;
    const typing = target.closest?.("input, select, textarea, [contenteditable]");
    if (event.key === " " && !typing && !target.closest?.("button, summary, a")) {
      event.preventDefault();
      this.toggle();
    } else if ((event.key === "ArrowLeft" || event.key === "ArrowRight") && !typing && !target.closest?.(".leaflet-container")) {
      if (target.closest?.("[tabindex]") && !this.controls.contains(target)) return;
      event.preventDefault();
      const step = (event.shiftKey ? 10 : 1) * (event.key === "ArrowLeft" ? -1 : 1);
      this.seek(this.clock.time + step);
    }
  }
}
