/** Robots where they are, what they see, the trails behind them, and where bouncing ones have just bumped. */

import { cross, write } from "./ground.js";

const MOST_CUT = 24; // robots whose footprints are cut by walls
const MOST_NAMED = 60;
const MOST_EDGED = 200; // robots whose footprints have a line round them
const LEAST_PIXELS = 4.5; // radius of a robot, so that it can be seen and hit
const TRAIL_SHARE = 0.15; // of the longest loop, or of the way to rest
const BUMP_SHOWN_S = 4;
const BAR_PIXELS = 14; // of a full battery
const SPOT_PIXELS = 24; // between robots on one charger

export class Robots {
  /**
   * @param {import("./playback.js").Playback} playback
   * @param {import("./sight.js").Walls} walls
   */
  constructor(playback, walls) {
    this.playback = playback;
    this.walls = walls;
    this.places = new Float64Array(playback.robots.length * 2);
    this._at = { x: 0, y: 0, z: 0, dx: 0, dy: 0 };
    const longest = Math.max(0, ...playback.robots.map((robot) => robot.end_s - (robot.loops ? robot.loop_start_s : 0)));
    this._trail = TRAIL_SHARE * longest;
    this.many = playback.robots.length > MOST_NAMED;
    this._spots = spotsOf(playback);
  }

  /** Moves all robots to a time. `lost`: from when on robots are lost, by number; `pixel`: its size in metres. */
  move(time, lost, pixel) {
    this._time = time;
    this._lost = lost;
    this._groups = this._grouped(time, lost, pixel);
  }

  /** Puts robots where they said that they are; those that have said nothing are not drawn. */
  moveTo(heard, time) {
    this._time = time;
    this._lost = new Map();
    this._groups = { present: [], charging: [], away: [], lost: [], heights: [] };
    this.places.fill(NaN);
    for (const { robot, x_m: x, y_m: y, lost } of heard) {
      if (x === null || y === null || x === undefined) continue;
      this.places[2 * robot] = x;
      this.places[2 * robot + 1] = y;
      this._groups.heights[robot] = this.playback.place(robot, time, this._at).z;
      this._groups[lost ? "lost" : "present"].push(robot);
    }
  }

  /** Draws what they see. */
  drawFootprints(context, colours, pixel) {
    this._footprints(context, this._groups, colours, pixel);
  }

  /** Draws trails, bumps and the robots themselves. `chosen`: one to mark, or -1. */
  draw(stage, context, shown, colours, chosen) {
    const pixel = 1 / stage.pixelsPerMetre;
    if (shown.trails && !this.many) this._trails(context, this._groups.present, this._time, colours, pixel);
    if ("turn_time_s" in this.playback.arrays) this._bumps(context, this._time, this._lost, colours, pixel);
    this._bodies(stage, context, this._groups, colours, pixel, chosen);
  }

  /** Who takes part, who is on a charger, away or lost, and at which height each is. */
  _grouped(time, lost, pixel) {
    const groups = { present: [], charging: [], away: [], lost: [], heights: [] };
    const { chargers } = this.playback.header.mission;
    for (let k = 0; k < this.playback.robots.length; k++) {
      const gone = lost.get(k) ?? Infinity;
      this.playback.place(k, Math.min(time, gone), this._at);
      this.places[2 * k] = this._at.x;
      this.places[2 * k + 1] = this._at.y;
      groups.heights[k] = this._at.z;
      const kind = time >= gone ? "lost" : this.playback.takesPart(k, time) ? "present" : "away";
      const charger = kind === "present" ? this.playback.chargerAt(k, time) : -1;
      groups[charger >= 0 ? "charging" : kind].push(k);
      if (charger >= 0) {
        // those on one charger are told apart: each stands in its own spot round it
        this.places[2 * k] = chargers[charger].at[0] + this._spots[k][0] * pixel;
        this.places[2 * k + 1] = chargers[charger].at[1] + this._spots[k][1] * pixel;
      }
    }
    return groups;
  }

  _footprints(context, { present, heights }, colours, pixel) {
    const { robots } = this.playback;
    const many = present.length > MOST_CUT || this.playback.header.coverage?.what === "ground in range";
    const cut = this.walls.edges.length > 0 && !many;
    context.lineWidth = pixel;
    if (many) {
      this._manyFootprints(context, present, heights, colours);
      return;
    }
    for (const k of present) {
      const [x, y] = [this.places[2 * k], this.places[2 * k + 1]];
      const reach = this.playback.reach(k, heights[k]);
      const outline = cut ? this.walls.outline(x, y, robots[k].sensor.shape, reach) : null;
      context.beginPath();
      if (outline) for (let i = 0; i < outline.length; i += 2) context.lineTo(outline[i], outline[i + 1]);
      else range(context, x, y, robots[k].sensor.shape, reach);
      context.closePath();
      context.fillStyle = colours.footprint;
      context.fill();
      context.strokeStyle = colours.routes[k % colours.routes.length];
      context.stroke();
    }
  }

  /** The union of all footprints, as one path. */
  _manyFootprints(context, present, heights, colours) {
    context.beginPath();
    for (const k of present) {
      const [x, y] = [this.places[2 * k], this.places[2 * k + 1]];
      range(context, x, y, this.playback.robots[k].sensor.shape, this.playback.reach(k, heights[k]));
    }
    context.fillStyle = colours.covered;
    context.fill("nonzero");
    if (present.length > MOST_EDGED) return;
    context.strokeStyle = colours.coveredEdge;
    context.stroke();
  }

  _trails(context, present, time, colours, pixel) {
    context.lineWidth = 3.5 * pixel;
    context.lineCap = "round";
    context.lineJoin = "round";
    context.globalAlpha = 0.55;
    for (const k of present) {
      context.beginPath();
      for (const mark of this._marksOf(k, Math.max(0, time - this._trail), time)) {
        this.playback.place(k, mark, this._at);
        context.lineTo(this._at.x, this._at.y);
      }
      context.strokeStyle = colours.routes[k % colours.routes.length];
      context.stroke();
    }
    context.globalAlpha = 1;
  }

  /** Two times and those of a robot's corners in between. */
  _marksOf(k, from, to) {
    const { corner_offsets: offsets, corner_time_s: times } = this.playback.arrays;
    const robot = this.playback.robots[k];
    const later = to - this.playback.localTime(k, to);
    const marks = [from];
    // a trail is shorter than a loop, so it lies in this turn and the one before
    for (const shift of robot.loops && later > 0 ? [later - (robot.end_s - robot.loop_start_s), later] : [0]) {
      for (let i = offsets[k]; i < offsets[k + 1]; i++) {
        const at = times[i] + shift;
        if (at > from && at < to && (shift === 0 || times[i] >= robot.loop_start_s)) marks.push(at);
      }
    }
    marks.push(to);
    return marks;
  }

  /** Rings where robots have turned in the last seconds: they have bumped, or their clock told them to. */
  _bumps(context, time, lost, colours, pixel) {
    const { turn_offsets: offsets, turn_time_s: times, turn_x_m: xs, turn_y_m: ys, turn_before_rad: facing } =
      this.playback.arrays;
    context.lineWidth = 2.5 * pixel;
    context.strokeStyle = colours.bump;
    this.playback.robots.forEach((robot, k) => {
      const local = this.playback.localTime(k, Math.min(time, lost.get(k) ?? Infinity));
      for (let i = offsets[k]; i < offsets[k + 1]; i++) {
        const since = local - times[i];
        if (since < 0 || since > BUMP_SHOWN_S) continue;
        const reach = Math.max(robot.body_radius_m, LEAST_PIXELS * pixel);
        const middle = facing[i];
        context.globalAlpha = 1 - since / BUMP_SHOWN_S;
        context.beginPath();
        context.arc(xs[i], ys[i], reach * 1.5, middle - 0.9, middle + 0.9);
        context.stroke();
      }
    });
    context.globalAlpha = 1;
  }

  _bodies(stage, context, groups, colours, pixel, chosen) {
    const { robots } = this.playback;
    for (const kind of ["charging", "away", "present", "lost"]) {
      const byColour = new Map();
      for (const k of groups[kind]) {
        const colour = kind === "present" ? colours.routes[k % colours.routes.length] : colours.away;
        if (!byColour.has(colour)) byColour.set(colour, []);
        byColour.get(colour).push(k);
      }
      for (const [colour, members] of byColour) {
        context.beginPath();
        for (const k of members) {
          const [x, y] = [this.places[2 * k], this.places[2 * k + 1]];
          const radius = Math.max(robots[k].body_radius_m, (this.many ? 2 : LEAST_PIXELS) * pixel);
          context.moveTo(x + radius, y);
          context.arc(x, y, radius, 0, 2 * Math.PI);
        }
        context.fillStyle = colour;
        context.fill();
        context.strokeStyle = colours.halo;
        context.lineWidth = (this.many ? 0.5 : 1.5) * pixel;
        context.stroke();
      }
    }
    if (this.playback.hasBatteries && !this.many) this._batteries(context, groups, colours, pixel);
    this._marks(stage, context, groups, colours, pixel, chosen);
  }

  /** A bar below each robot, as long as its battery is full. */
  _batteries(context, groups, colours, pixel) {
    for (const k of [...groups.charging, ...groups.present]) {
      const share = this.playback.charge(k, this._time);
      if (share === null) continue;
      const radius = Math.max(this.playback.robots[k].body_radius_m, LEAST_PIXELS * pixel);
      const left = this.places[2 * k] - (BAR_PIXELS / 2) * pixel;
      const top = this.places[2 * k + 1] - radius - 3 * pixel;
      const bar = (grow, width, colour) => {
        context.fillStyle = colour;
        context.fillRect(left - grow * pixel, top + grow * pixel, (width + 2 * grow) * pixel, -(3 + 2 * grow) * pixel);
      };
      bar(1, BAR_PIXELS, colours.ink);
      bar(0, BAR_PIXELS, colours.ground);
      bar(0, BAR_PIXELS * Math.min(Math.max(share, 0), 1), batteryColour(share, this.playback.robots[k].battery.reserve));
    }
  }

  /** Crosses on lost robots, a ring round the chosen one, numbers beside few. */
  _marks(stage, context, groups, colours, pixel, chosen) {
    context.strokeStyle = colours.danger;
    context.lineWidth = 2.5 * pixel;
    context.beginPath();
    for (const k of groups.lost) cross(context, this.places[2 * k], this.places[2 * k + 1], pixel);
    context.stroke();
    if (chosen >= 0 && !Number.isNaN(this.places[2 * chosen])) {
      context.beginPath();
      context.arc(this.places[2 * chosen], this.places[2 * chosen + 1], 11 * pixel, 0, 2 * Math.PI);
      context.strokeStyle = colours.ink;
      context.lineWidth = 2 * pixel;
      context.stroke();
    }
    if (!this.many) this._numbers(stage, colours, pixel);
  }

  /** Numbers beside robots, each drawn once and then copied: text with a halo is slow to draw. */
  _numbers(stage, colours, pixel) {
    if (this._sprites?.colours !== colours || this._sprites.ratio !== stage.ratio) {
      const made = this.playback.robots.map((_, k) => number(String(k + 1), colours, stage.ratio));
      this._sprites = { colours, ratio: stage.ratio, made };
    }
    const context = stage.inPixels("moving");
    context.setTransform(1, 0, 0, 1, 0, 0);
    this._sprites.made.forEach((sprite, k) => {
      const [px, py] = stage.toPixels(this.places[2 * k], this.places[2 * k + 1]);
      if (Number.isNaN(px)) return;
      const beside = Math.max(this.playback.robots[k].body_radius_m / pixel, LEAST_PIXELS) + 1;
      context.drawImage(sprite, Math.round((px + beside) * stage.ratio), Math.round(py * stage.ratio - sprite.height / 2));
    });
  }

  /** The robot at a place in metres, within so many metres; -1: none. */
  at(x, y, within) {
    let nearest = -1;
    let least = within;
    for (let k = 0; k < this.playback.robots.length; k++) {
      const away = Math.hypot(this.places[2 * k] - x, this.places[2 * k + 1] - y);
      if (away < Math.max(least, nearest < 0 ? this.playback.robots[k].body_radius_m : 0)) {
        nearest = k;
        least = away;
      }
    }
    return nearest;
  }
}

/** The colour of a battery: with less than a quarter of what may be used it is low, near the reserve it is empty. */
function batteryColour(share, reserve) {
  const usable = (share - reserve) / (1 - reserve);
  if (usable < 0.05) return "#c4001a";
  return usable < 0.25 ? "#e8a400" : "#1f9e4b";
}

/** Where each robot stands when it charges, in pixels from the charger: on rings, six on the first one. */
function spotsOf(playback) {
  const taken = new Map();
  return playback.robots.map(({ charges }) => {
    if (!charges.length) return [0, 0];
    let number = taken.get(charges[0][2]) ?? 0;
    taken.set(charges[0][2], number + 1);
    let ring = 1;
    while (number >= 6 * ring) number -= 6 * ring++;
    const turn = Math.PI / 2 + (number * Math.PI) / (3 * ring);
    return [ring * SPOT_PIXELS * Math.cos(turn), ring * SPOT_PIXELS * Math.sin(turn)];
  });
}

/** Adds a sensor's range, nothing in its way, to a path. */
function range(context, x, y, shape, reach) {
  if (shape === "square") {
    context.rect(x - reach, y - reach, 2 * reach, 2 * reach);
  } else {
    context.moveTo(x + reach, y);
    context.arc(x, y, reach, 0, 2 * Math.PI);
  }
}

/** A small text as an image. */
function number(text, colours, ratio) {
  const sprite = document.createElement("canvas");
  sprite.width = Math.ceil((8 * text.length + 8) * ratio);
  sprite.height = Math.ceil(18 * ratio);
  const context = sprite.getContext("2d");
  context.scale(ratio, ratio);
  context.font = "600 11px system-ui, sans-serif";
  context.textBaseline = "middle";
  context.lineJoin = "round";
  write(context, text, 3, 9, colours);
  return sprite;
}
