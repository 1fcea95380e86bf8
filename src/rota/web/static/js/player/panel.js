/** The player's controls: buttons and fields that the keyboard reaches, and what they tell. */

import { SPEEDS } from "./clock.js";
import { NEVER, NOT_YET, css, viridis } from "./colours.js";
import { el, labelled, section, table, ticked } from "./elements.js";
import { area, count, percent, reading, seconds } from "./text.js";

const MOST_BUTTONS = 60; // robots with a row each; of more, one is chosen from a list
const MOST_LISTED = 100;

export class Panel {
  /** @param {import("./player.js").Player} player whose methods the controls call */
  constructor(player, host) {
    this.player = player;
    this.playback = player.playback;
    this.root = el("div", { class: "rota-player" });
    this.root.append(
      this._summary(),
      this._transport(),
      this._view(),
      ...[this._change(), this._coverage(), this._bumps(), this._demands(), this._robots(), this._place(), this._losses(), this._wrongs()].filter(Boolean),
    );
    host.replaceChildren(this.root);
  }

  _summary() {
    const { plan, report, robots } = this.playback.header;
    const bound = plan.bound === null || plan.bound <= 1 ? "" : `, no plan with fewer than ${plan.bound}`;
    return el(
      "div",
      { class: "rota-summary" },
      el("h2", { text: plan.name }),
      el("p", {}, el("strong", { class: `rota-verdict rota-${report.verdict.replace(" ", "-")}`, text: report.verdict }),
        ` · ${count(robots.length, "robot")}${bound} · planner ${plan.planner}`),
    );
  }

  /** Where the plan takes over from another one: who is lost, how late that makes places, when all holds again. */
  _change() {
    const { report, seam } = this.playback.header;
    if (!seam) return null;
    const { lateness } = report;
    const lost = seam.lost.length ? `; lost: ${seam.lost.join(", ")}` : "";
    const rows = lateness.demands.map((late) => {
      const { period_s: period } = this.playback.demands.find(({ name }) => name === late.name);
      const name = late.place_m === null ? late.name : el("button", {
        type: "button", class: "rota-link", text: late.name, title: "Show the place that is late by most",
        on: { click: () => this.player.showLateness(late, period) },
      });
      return [name, lateText(late)];
    });
    const again = lateness.holds_again_s === null ? "Some period does not hold again." : lateness.holds_again_s === 0
      ? "Every period holds throughout." : `Every period holds again from ${reading(lateness.holds_again_s)} on.`;
    return section("The change", true,
      el("p", { text: `0:00.0 is ${reading(seam.at_s)} of the plan before${lost}.` }),
      el("p", {}, el("strong", { text: again })),
      table("How late places are since the change", ["zone", "late at most"], rows));
  }

  _transport() {
    const { player } = this;
    this.play = el("button", { type: "button", class: "rota-play", on: { click: () => player.toggle() } });
    this.time = el("output", { class: "rota-time", for: "" });
    this.end = el("span", { class: "rota-hint" });
    this.slider = el("input", {
      type: "range", min: 0, step: 0.1, class: "rota-slider", "aria-label": "Time",
      on: { input: () => player.seek(Number(this.slider.value)) },
    });
    this.speed = el("select", { on: { change: () => player.setSpeed(Number(this.speed.value)) } },
      ...SPEEDS.map((speed) => el("option", { value: speed, text: `×${speed}`, selected: speed === player.clock.speed })));
    this.wall = ticked("On the clock", false, (on) => player.followClock(on ? this._start() : null));
    this.start = el("input", { type: "datetime-local", step: 1, value: localNow(),
      on: { change: () => this.wall.box.checked && player.followClock(this._start()) } });
    this.status = el("p", { class: "rota-status", "aria-live": "polite" });
    this.live = el("p", { class: "rota-live", hidden: true, text: "Live: where robots are, and when places were really seen." });
    this.transport = el(
      "fieldset",
      { class: "rota-transport", "aria-label": "Playback" },
      el("div", { class: "rota-row" }, this.play,
        el("button", { type: "button", text: "↺", title: "From the start, when nothing has been seen", "aria-label": "From the start", on: { click: () => player.seek(0) } }),
        this.time, labelled("Speed", this.speed)),
      el("div", { class: "rota-scrub" }, this.slider, this.end),
      el("div", { class: "rota-row" }, this.wall.row, labelled("Robots start at", this.start)),
      el("p", { class: "rota-hint", text: "Space plays and pauses; ← and → go 1 s, with Shift 10 s." }),
    );
    return el("div", { class: "rota-transport" }, this.live, this.transport, this.status);
  }

  _start() {
    const start = new Date(this.start.value);
    return Number.isNaN(start.getTime()) ? Date.now() : start.getTime();
  }

  _view() {
    const { player, playback } = this;
    const modes = [];
    if (playback.entries) modes.push(["age", "time since last seen"], ["worst", "worst gap by plan"]);
    if (playback.header.cells) modes.push(["entries", "times entered in a loop"]);
    modes.push(["none", "nothing"]);
    this.lapseOption = el("option", { value: "lapse", text: "places that lapse after the loss", disabled: true });
    this.mode = el("select", { on: { change: () => player.setMode(this.mode.value) } },
      ...modes.map(([value, text]) => el("option", { value, text, selected: value === player.mode })), playback.entries ? this.lapseOption : null);
    this.legend = el("div", { class: "rota-legend" });
    const tick = (name, text) => ticked(text, player.shown[name], (on) => player.show(name, on)).row;
    const view = el(
      "div",
      { class: "rota-view", role: "group", "aria-label": "View" },
      modes.length > 1 ? labelled("Colours show", this.mode) : null,
      this.legend,
      el("div", { class: "rota-row" }, tick("footprints", "Footprints"), tick("routes", "Routes"), tick("trails", "Trails")),
    );
    this.showLegend();
    return view;
  }

  /** Tells what the colours mean. */
  showLegend() {
    const { mode } = this.player;
    const bar = el("span", { class: "rota-scale", "aria-hidden": "true" });
    const stops = Array.from({ length: 9 }, (_, k) => css(viridis(mode === "lapse" ? 1 - k / 8 : k / 8)));
    bar.style.backgroundImage = `linear-gradient(to right, ${stops.join(", ")})`;
    const swatch = (kind, text, colour) => {
      const box = el("span", { class: `rota-swatch ${kind}`, "aria-hidden": "true" });
      if (colour) box.style.backgroundColor = css(colour);
      return el("span", { class: "rota-key" }, box, text);
    };
    const scale = (low, high) => el("span", { class: "rota-key" }, `${low} `, bar, ` ${high}`);
    const keys = {
      age: () => [scale("just seen", "period over"), swatch("rota-late", "late"),
        swatch("", "not seen yet", NOT_YET), swatch("rota-never", "nor in time", NEVER)],
      worst: () => [scale("0", "1 period"), swatch("rota-late", "longer"), swatch("rota-never", "never seen", NEVER)],
      lapse: () => [scale("lapses at once", "after 2 periods"), swatch("rota-calm", "on time without them")],
      entries: () => [scale("1", `${this.playback.header.cells?.most} times`), swatch("", "entered later: faint")],
      none: () => (this.player.coversGround ? [swatch("rota-covered", "in range of some robot")] : []),
    };
    const charging = this.playback.hasBatteries ? [swatch("rota-charging", "on a charger, sees nothing"), swatch("rota-battery", "battery")] : [];
    this.legend.replaceChildren(...keys[mode](), ...charging);
  }

  _coverage() {
    if (!this.player.chart) return null;
    return section(this.playback.header.coverage.what === "cells entered" ? "Cells entered" : "Coverage", true, this.player.chart.node);
  }

  /** How often robots that bounce turn. */
  _bumps() {
    const { turn_offsets: offsets } = this.playback.arrays;
    if (!offsets) return null;
    this.bumps = el("p", {});
    return section("Bumps", true, this.bumps);
  }

  /** Tells how often each robot has bumped or turned until a time. */
  showBumps(time) {
    if (!this.bumps) return;
    const { turn_offsets: offsets, turn_time_s: times } = this.playback.arrays;
    const told = this.playback.robots.map((robot, k) => {
      const until = Math.min(time, this.player.losses.lost.get(k) ?? Infinity);
      const all = [...times.subarray(offsets[k], offsets[k + 1])];
      const turn = robot.end_s - robot.loop_start_s;
      const rounds = robot.loops ? Math.max(0, Math.floor((until - robot.loop_start_s) / turn)) : 0;
      const again = all.filter((at) => at >= robot.loop_start_s).length;
      const local = until - rounds * turn;
      const now = all.filter((at) => at <= local && (!rounds || at >= robot.loop_start_s)).length;
      // before this turn of the loop: the way there, and as many whole turns
      const before = rounds ? all.length - again + rounds * again : 0;
      return `${robot.name} ${before + now}`;
    });
    this.bumps.textContent = `Bumps and turns until ${reading(time)}: ${told.join(", ")}.`;
  }

  _demands() {
    const { demands } = this.playback;
    if (!demands.length) return null;
    const rows = demands.map((demand, k) => {
      const worst = this.player.worstEntry(k);
      const show = el("button", {
        type: "button", class: "rota-link", text: demand.name, disabled: worst < 0,
        title: "Show its place that waits longest", on: { click: () => this.player.choosePlace(worst, true) },
      });
      const asks = demand.demand === "visit" ? "visit" : "every point";
      return [show, `${asks} in ${seconds(demand.period_s)}`, seconds(demand.worst_gap_s), demand.outcome];
    });
    this.late = el("p", { class: "rota-late-now" });
    return section("What is asked", true, table("What is asked", ["zone", "asks", "worst gap", "outcome"], rows), this.late);
  }

  _robots() {
    const { robots } = this.playback;
    if (!robots.length) return null;
    this.robotRows = [];
    this.batteries = this.playback.hasBatteries ? robots.map(() => el("span", {})) : null;
    const button = (k) => {
      const lose = el("button", { type: "button", on: { click: () => this.player.toggleLoss(k) } });
      this.robotRows[k] = lose;
      return lose;
    };
    this.undo = el("button", { type: "button", text: "Undo", disabled: true, on: { click: () => this.player.undoLoss() } });
    if (robots.length <= MOST_BUTTONS) {
      const rows = robots.map((robot, k) => [
        el("button", { type: "button", class: "rota-link", text: robot.name === `robot-${k + 1}` ? robot.name : `${k + 1} ${robot.name}`, title: "Show it on the map",
          on: { click: () => this.player.chooseRobot(k, true) } }),
        robot.loops ? `loop ${seconds(robot.end_s - robot.loop_start_s)}` : "stays in the end",
        ...(this.batteries ? [this.batteries[k]] : []),
        button(k),
      ]);
      const heads = ["robot", "goes", ...(this.batteries ? ["battery"] : []), "lost from now on"];
      return section(`Robots (${robots.length})`, robots.length <= 12 || this.batteries !== null, table("Robots", heads, rows), this.undo);
    }
    this.pick = el("select", { on: { change: () => this.player.chooseRobot(Number(this.pick.value), true) } },
      ...robots.map((robot, k) => el("option", { value: k, text: robot.name })));
    this.pickLose = el("button", { type: "button", on: { click: () => this.player.toggleLoss(Number(this.pick.value)) } });
    return section(`Robots (${robots.length})`, false,
      el("div", { class: "rota-row" }, labelled("Robot", this.pick), this.pickLose, this.undo));
  }

  _place() {
    this.place = el("div", {}, el("p", { class: "rota-hint", text: "Click a place on the map, or a zone in the table." }));
    this.placeSection = section("A place's sightings", true, this.place);
    return this.playback.entries ? this.placeSection : null;
  }

  _losses() {
    this.losses = el("div", { "aria-live": "polite" });
    this.lossSection = section("Lost robots", true, this.losses);
    this.lossSection.hidden = true;
    return this.lossSection;
  }

  _wrongs() {
    const { violations, demands } = this.playback.header.report;
    const excluded = demands.flatMap((demand) => demand.excluded_places.map((place) => ({ ...place, name: demand.name })));
    if (!violations.length && !excluded.length) return null;
    const rows = violations.slice(0, MOST_LISTED).map((wrong) => el("li", {}, wrong.place_m === null && wrong.time_s === null
      ? wrong.text
      : el("button", { type: "button", class: "rota-link", text: wrong.text, on: { click: () => this.player.showViolation(wrong) } })));
    const hidden = excluded.map(({ x, y, area_m2: size, name }) => el("li", {}, el("button", {
      type: "button", class: "rota-link", text: `nobody can see ${this.player.where(x, y)} in ${name}: ${area(size)} left out`,
      on: { click: () => this.player.flyTo(x, y) },
    })));
    return section(
      `Violations (${violations.length})`, true,
      violations.length > MOST_LISTED ? el("p", { text: `The first ${MOST_LISTED} of them:` }) : null,
      rows.length ? el("ul", { class: "rota-list" }, ...rows) : el("p", { text: "None." }),
      hidden.length ? el("h4", { text: "Excluded places" }) : null,
      hidden.length ? el("ul", { class: "rota-list" }, ...hidden) : null,
    );
  }

  // ------------------------------------------------------------ what changes

  /** Shows the clock. */
  showTime() {
    const { clock } = this.player;
    const running = clock.playing || clock.startsAt !== null;
    const text = running ? "‖ Pause" : "▶ Play";
    if (this.play.textContent !== text) this.play.textContent = text;
    this.time.textContent = reading(this.player.time);
    const end = Math.ceil(clock.end * 10) / 10;
    if (Number(this.slider.max) !== end) {
      this.slider.max = end;
      this.end.textContent = reading(end);
    }
    this.slider.value = clock.time;
    this.slider.setAttribute("aria-valuetext", reading(clock.time));
    this.wall.box.checked = clock.startsAt !== null;
    this.speed.disabled = clock.startsAt !== null;
  }

  /** Whether robots are watched now; the plan's clock then rests. */
  showLive(on) {
    this.live.hidden = !on;
    this.transport.disabled = on;
  }

  /** Tells how full batteries are, and who charges where. */
  showBatteries(time) {
    const { chargers } = this.playback.header.mission;
    this.batteries?.forEach((node, k) => {
      const [share, charger] = [this.playback.charge(k, time), this.playback.chargerAt(k, time)];
      const level = share === null ? "–" : `${Math.round(100 * share)} %`;
      const text = charger < 0 ? level : `${level}, on ${chargers[charger].name}`;
      if (node.textContent !== text) node.textContent = text;
    });
  }

  /** Tells how much is late now. */
  showLate(late, visits) {
    if (!this.late) return;
    const told = [];
    late.forEach((size, k) => size > 0 && told.push(`${area(size)} of ${this.playback.demands[k].name}`));
    for (const name of visits) told.push(`the visit of ${name}`);
    const { report } = this.playback.header;
    const first = report.verdict === "met" && report.holds_from_s > 0 ? ` The plan is met from ${reading(report.holds_from_s)} on, once all robots are in their loops.` : "";
    const text = told.length ? `Late now: ${told.join(", ")}.${first}` : "Nothing is late now.";
    if (this.late.textContent !== text) this.late.textContent = text;
    this.late.classList.toggle("rota-late-text", told.length > 0);
  }

  /** Says something once, also to those who hear the page. */
  say(text) {
    this.status.textContent = text;
  }

  /** Shows which robots are lost and what lapses. */
  showLosses() {
    const { losses, playback } = this.player;
    const label = (k) => (losses.lost.has(k) ? "Bring back" : "Lost");
    this.robotRows?.forEach((button, k) => {
      button.textContent = label(k);
      button.setAttribute("aria-label", `${label(k)}: ${playback.robots[k].name}`);
      button.setAttribute("aria-pressed", String(losses.lost.has(k)));
    });
    if (this.pick) this.pickLose.textContent = label(Number(this.pick.value));
    if (this.undo) this.undo.disabled = !losses.canUndo;
    this.lapseOption.disabled = losses.lapses === null;
    this.lossSection.hidden = losses.lost.size === 0;
    const who = [...losses.lost].map(([k, from]) => `${playback.robots[k].name} from ${reading(from)} on`).join(", ");
    const rows = losses.zones.map((zone) => [
      el("button", { type: "button", class: "rota-link", text: playback.demands[zone.demand].name, title: "Show the place that lapses first",
        on: { click: () => this.player.showLapse(zone) } }),
      reading(zone.first),
      seconds(zone.first - losses.lapses.from),
      zone.visit ? "no visit in time" : `${area(zone.area)} (${percent(Math.min(1, zone.area / Math.max(playback.demands[zone.demand].area_m2, 1e-9)))})`,
    ]);
    const told = losses.zones.length ? table("What lapses", ["zone", "first at", "after the loss", "lapses"], rows)
      : el("p", { text: playback.entries ? "Nothing more lapses: the others are on time without them." : "Nothing is asked of the ground." });
    this.losses.replaceChildren(el("p", { text: `Without ${who}:` }), told, ...this._offer());
  }

  /** The button that asks for a plan for those that remain when the first one is lost. */
  _offer() {
    const { player, playback } = this;
    const { lost } = player.losses;
    if (player.replan === null || !lost.size || lost.size === playback.robots.length) return [];
    const at = Math.min(...lost.values());
    const gone = [...lost].filter(([, from]) => from === at).map(([k]) => playback.robots[k].name);
    const later = gone.length < lost.size ? " Who is lost later is lost again in the new plan." : "";
    const ask = el("button", {
      type: "button", class: "rota-replan", text: "Replan for those that remain",
      on: {
        click: async () => {
          ask.disabled = true;
          await player.replan({ at_s: at, lost: gone });
          ask.disabled = false;
        },
      },
    });
    return [el("div", { class: "rota-row" }, ask),
      el("p", { class: "rota-hint", text: `From ${reading(at)} on without ${gone.join(", ")}, from where all are then.${later}` })];
  }
}

/** By how much a demand is late at most; without an upper bound, by how much some place is. */
function lateText({ worst_s: most, worst_at_least_s: least }) {
  if (least === null) return "never seen again";
  if (most === null) return `${seconds(least)} or more`;
  return most > 0 ? seconds(most) : "not late";
}

/** Now as a field for date and time takes it. */
function localNow() {
  const now = new Date();
  return new Date(now.getTime() - now.getTimezoneOffset() * 60_000).toISOString().slice(0, 19);
}

