/** How long ago places were seen: worked out for any moment from the sightings alone, so that a slider can jump. */

/** @typedef {import("./playback.js").Playback} Playback */

/** A gap that equals the period to rounding meets it. */
export const ON_TIME = 1 + 1e-6;

/**
 * When each robot stops to see: where it leaves by plan, or is lost before.
 * @param {Playback} playback
 * @param {Map<number, number>} lost from when on robots are lost
 * @returns {Float64Array}
 */
export function stopsOf(playback, lost) {
  return Float64Array.from(playback.robots, (robot, k) => Math.min(robot.leaves_s ?? Infinity, lost.get(k) ?? Infinity));
}

/**
 * Seconds since each entry was last seen, also before a plan took over from another one; Infinity: not yet.
 * @param {Playback} playback
 * @param {number} time
 * @param {Float64Array} stops see `stopsOf`
 * @param {Float32Array|Float64Array} out one for each entry
 */
export function agesInto(playback, time, stops, out) {
  const { sight_offsets: offsets, sight_robot: who, sight_start_s: starts, sight_end_s: ends, sight_loops: loops } =
    playback.arrays;
  const before = playback.arrays.cell_before_s;
  const team = clocksAt(playback, time, stops);
  const { until, behind, local, turned, loop } = team;
  const entries = playback.entries;
  for (let entry = 0; entry < entries; entry++) {
    let youngest = before ? time - before[entry] : Infinity;
    for (let i = offsets[entry]; i < offsets[entry + 1]; i++) {
      const robot = who[i];
      let age;
      if (loops[i]) {
        const now = local[robot];
        if (now >= ends[i]) age = now - ends[i];
        else if (now >= starts[i]) age = 0;
        else if (turned[robot]) age = Math.max(0, now + loop[robot] - ends[i]);
        else continue;
      } else {
        const now = until[robot];
        if (now >= ends[i]) age = now - ends[i];
        else if (now >= starts[i]) age = 0;
        else continue;
      }
      age += behind[robot];
      if (age < youngest) youngest = age;
    }
    out[entry] = youngest;
  }
  return out;
}

/** Each robot's own time: until when it has seen, how long that is ago, where in its loop, and whether it went round. */
function clocksAt(playback, time, stops) {
  const n = playback.robots.length;
  const until = new Float64Array(n);
  const behind = new Float64Array(n);
  const local = new Float64Array(n);
  const turned = new Uint8Array(n);
  const loop = new Float64Array(n);
  playback.robots.forEach((robot, k) => {
    until[k] = Math.min(time, stops[k]);
    behind[k] = time - until[k];
    loop[k] = robot.end_s - robot.loop_start_s;
    local[k] = until[k];
    if (robot.loops && until[k] >= robot.end_s) {
      local[k] = robot.loop_start_s + ((until[k] - robot.loop_start_s) % loop[k]);
      turned[k] = 1;
    }
  });
  return { until, behind, local, turned, loop };
}

/**
 * When an entry is seen between two moments: start, end and robot, by start; cut to the moments.
 * @returns {{start: number, end: number, robot: number}[]}
 */
export function sightingsBetween(playback, entry, from, to, stops) {
  const { sight_offsets: offsets, sight_robot: who, sight_start_s: starts, sight_end_s: ends, sight_loops: loops } =
    playback.arrays;
  const found = [];
  const note = (start, end, robot) => {
    const stop = Math.min(to, stops[robot]);
    if (end >= from && start <= stop) found.push({ start: Math.max(start, from), end: Math.min(end, stop), robot });
  };
  for (let i = offsets[entry]; i < offsets[entry + 1]; i++) {
    const robot = who[i];
    if (!loops[i]) {
      note(starts[i], ends[i], robot);
      continue;
    }
    const turn = playback.robots[robot].end_s - playback.robots[robot].loop_start_s;
    const last = Math.floor((Math.min(to, stops[robot]) - starts[i]) / turn);
    for (let k = Math.max(0, Math.ceil((from - ends[i]) / turn)); k <= last; k++) {
      note(starts[i] + k * turn, ends[i] + k * turn, robot);
    }
  }
  return found.sort((a, b) => a.start - b.start || a.end - b.end);
}

/** Sightings that touch or overlap made one, whoever sees: start and end, by start. */
export function joined(sightings, within = 1e-3) {
  const spans = [];
  for (const { start, end } of sightings) {
    const before = spans.at(-1);
    if (before && start <= before.end + within) before.end = Math.max(before.end, end);
    else spans.push({ start, end });
  }
  return spans;
}

/**
 * When the period of each entry lapses first from a moment on; Infinity: not within what is looked at, which is at
 * least two periods and a common period of all loops or two of the longest.
 * @param {Playback} playback
 * @param {number} from
 * @param {Float64Array} stops
 * @returns {Float64Array}
 */
export function lapsesFrom(playback, from, stops) {
  const ages = agesInto(playback, from, stops, new Float64Array(playback.entries));
  const longest = Math.max(0, ...playback.robots.map((robot) => robot.end_s - robot.loop_start_s));
  const around = playback.clock.repeat_s || 2 * longest;
  const found = new Float64Array(playback.entries).fill(Infinity);
  for (let entry = 0; entry < playback.entries; entry++) {
    const period = playback.periods[entry];
    const until = Math.max(from, playback.clock.from_s) + Math.max(2 * period, around + period);
    // what was not seen before all robots are on their loops is waited for from then on
    let seen = ages[entry] === Infinity ? Math.max(from, playback.clock.from_s) : from - ages[entry];
    const end = { start: until, end: until };
    for (const span of [...joined(sightingsBetween(playback, entry, from, until, stops)), end]) {
      if (span.start - seen > period * ON_TIME) {
        found[entry] = seen + period;
        break;
      }
      seen = Math.max(seen, span.end);
    }
  }
  return found;
}
