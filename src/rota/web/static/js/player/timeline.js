/** One place's own line of time: who saw it when, how long it waited in between, and how long it may wait. */

import { ON_TIME, agesInto, joined, sightingsBetween } from "./ages.js";
import { el, freshId, svg, table } from "./elements.js";
import { NO_CELL } from "./playback.js";
import { reading, seconds } from "./text.js";

const WIDTH = 400;
const ROW = 16;
const TOP = 6;
const GAPS = 26;
const MOST_ROWS = 12;
const MOST_LISTED = 40;

/**
 * The place of an entry about a time: a drawing, a sentence and a table.
 * @param {import("./playback.js").Playback} playback
 * @param {number} entry
 * @param {number} time
 * @param {Float64Array} stops
 * @param {(time: number) => void} seek
 * @param {(x: number, y: number) => string} where a place in words
 */
export function timelineOf(playback, entry, time, stops, seek, where) {
  const period = playback.periods[entry];
  const demand = playback.demands[playback.arrays.cell_demand[entry]];
  const from = Math.max(0, time - 1.5 * period);
  const to = Math.max(time, from) + 1.5 * period;
  const sightings = sightingsBetween(playback, entry, lastSeen(playback, entry, from, stops), to + period, stops);
  const gaps = gapsOf(joined(sightings), to + period);
  const [x, y] = playback.middleOf(entry);
  const visit = playback.arrays.cell_index[entry] === NO_CELL;
  const worst = playback.arrays.cell_worst[entry] * period;
  const told = `${visit ? `Zone ${demand.name}, to be visited` : `Place ${where(x, y)} in ${demand.name}`}: ` +
    `at least once in ${seconds(period)}; it waits ${worst === Infinity ? "for ever" : `at most ${seconds(worst)}`} by plan.`;
  return el(
    "div",
    {},
    el("p", { text: told }),
    drawing(playback, sightings, gaps, { from, to, time, period }, seek),
    listed(playback, sightings, gaps, period, from, to),
  );
}

/** When a place was seen last before a time; that time itself if it never was. */
function lastSeen(playback, entry, time, stops) {
  const age = agesInto(playback, time, stops, new Float64Array(playback.entries))[entry];
  return age === Infinity ? time : time - age - 1e-6;
}

/** The waits between sightings; the last one goes on. */
function gapsOf(spans, until) {
  const gaps = spans.slice(1).map((span, k) => ({ start: spans[k].end, end: span.start }));
  const last = spans.at(-1)?.end ?? Infinity;
  return last < until ? [...gaps, { start: last, end: until }] : gaps;
}

function drawing(playback, sightings, gaps, { from, to, time, period }, seek) {
  const inside = sightings.filter(({ start, end }) => end >= from && start <= to);
  const names = [...new Set(inside.map(({ robot }) => robot))].sort((a, b) => a - b).slice(0, MOST_ROWS);
  const height = TOP + names.length * ROW + GAPS + 18;
  const across = (moment) => ((moment - from) / (to - from)) * WIDTH;
  const low = TOP + names.length * ROW;
  const parts = [];
  names.forEach((robot, row) => {
    const y = TOP + row * ROW;
    parts.push(svg("line", { class: "rota-lane", x1: 0, x2: WIDTH, y1: y + ROW / 2, y2: y + ROW / 2 }));
    for (const { start, end } of inside.filter((sight) => sight.robot === robot)) {
      const width = Math.max(across(end) - across(start), 2);
      parts.push(svg("rect", { class: `rota-sight rota-route-${robot % 8}`, x: across(start), y: y + 3, width, height: ROW - 6 }));
    }
    parts.push(svg("text", { class: "rota-lane-name", x: 3, y: y + ROW - 4, text: playback.robots[robot].name }));
  });
  const longest = Math.max(period, ...gaps.map(({ start, end }) => end - start));
  const high = (wait) => (wait / longest) * (GAPS - 4);
  for (const { start, end } of gaps) {
    const late = end - start > period * ON_TIME;
    const up = high(end - start);
    const points = `${across(start)},${low + GAPS} ${across(end)},${low + GAPS} ${across(end)},${low + GAPS - up}`;
    parts.push(svg("polygon", { class: late ? "rota-wait rota-late" : "rota-wait", points }));
    if (late) parts.push(svg("text", { class: "rota-late-mark", x: across(end) - 3, y: low + GAPS - 3, text: "late" }));
  }
  const limit = low + GAPS - high(period);
  parts.push(svg("line", { class: "rota-limit", x1: 0, x2: WIDTH, y1: limit, y2: limit }));
  parts.push(svg("line", { class: "rota-now", x1: across(time), x2: across(time), y1: 0, y2: low + GAPS }));
  for (const [moment, anchor] of [[from, "start"], [to, "end"]]) {
    parts.push(svg("text", { class: "rota-axis", x: across(moment), y: height - 3, "text-anchor": anchor, text: reading(moment) }));
  }
  const caption = freshId("timeline");
  const said = `Sightings from ${reading(from)} to ${reading(to)}: a bar is a sighting, a wedge how long the place waits, ` +
    `the dashed line the limit, ${seconds(period)}.`;
  const jump = (event) => {
    const box = picture.getBoundingClientRect();
    seek(from + ((event.clientX - box.left) / box.width) * (to - from));
  };
  const picture = svg(
    "svg",
    { class: "rota-timeline", viewBox: `0 0 ${WIDTH} ${height}`, role: "img", "aria-labelledby": caption, on: { click: jump } },
    svg("title", { id: caption, text: said }),
    ...parts,
  );
  return picture;
}

function listed(playback, sightings, gaps, period, from, to) {
  const shown = sightings.filter(({ start, end }) => end >= from && start <= to).slice(0, MOST_LISTED);
  if (!shown.length) return el("p", { text: "Nobody sees it in this time." });
  const rows = shown.map(({ start, end, robot }) => {
    const gap = gaps.find((other) => other.end === start);
    const waited = gap ? gap.end - gap.start : 0;
    const late = waited > period * ON_TIME;
    return [
      playback.robots[robot].name,
      reading(start),
      end === Infinity ? "for ever" : reading(end),
      gap ? `${seconds(waited)}${late ? ", late" : ""}` : "–",
    ];
  });
  return el(
    "details",
    {},
    el("summary", { text: "As a table" }),
    table("Sightings of this place", ["robot", "sees from", "until", "after"], rows),
  );
}
