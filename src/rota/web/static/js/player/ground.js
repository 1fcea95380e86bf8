/** The ground as it stands: area, obstacles, zones with their names, routes, moving obstacles. */

import { boundsOf } from "./playback.js";

// from its upper end on, within -1 .. 1
const BOLT = [[0.25, 1], [-0.65, -0.15], [-0.05, -0.15], [-0.25, -1], [0.65, 0.2], [0.05, 0.2]];
const MOST_CORNERS = 60_000; // with more, routes would take longer than a frame to draw

/** Adds polygons to the path of a context in metres. */
export function trace(context, polygons) {
  context.beginPath();
  for (const polygon of polygons) {
    for (const ring of polygon) {
      ring.forEach(([x, y], k) => (k ? context.lineTo(x, y) : context.moveTo(x, y)));
      context.closePath();
    }
  }
}

/** The heat map on the area, and on it what `more` draws there. */
export function drawHeat(stage, playback, heat, colours, opacity, more) {
  const context = stage.begin("heat");
  const { mission } = playback.header;
  context.save();
  trace(context, mission.area);
  context.fillStyle = colours.ground;
  // a map's own tiles shine through
  if (opacity === 1) context.fill("evenodd");
  context.clip("evenodd");
  const { x0_m: x0, y0_m: y0, cell_m: size, columns, rows } = heat.grid;
  context.imageSmoothingEnabled = false;
  context.globalAlpha = opacity;
  // the image's first row lies in the north
  context.transform(1, 0, 0, -1, x0, y0 + rows * size);
  context.drawImage(heat.canvas, 0, 0, columns * size, rows * size);
  context.transform(1, 0, 0, -1, -x0, y0 + rows * size);
  context.globalAlpha = 1;
  more(context);
  context.restore();
}

/** Outlines, obstacles and names. */
export function drawGround(stage, playback, colours, shown, lost) {
  const context = stage.begin("shapes");
  const { mission } = playback.header;
  const pixel = 1 / stage.pixelsPerMetre;
  for (const { shape, blocks } of mission.obstacles) {
    trace(context, shape);
    context.fillStyle = blocks === "both" ? colours.obstacle : "transparent";
    context.fill("evenodd");
    context.strokeStyle = blocks === "motion" ? colours.noEntry : blocks === "sight" ? colours.noSight : colours.obstacle;
    context.lineWidth = (blocks === "both" ? 1 : 2) * pixel;
    context.setLineDash(blocks === "motion" ? [6 * pixel, 4 * pixel] : blocks === "sight" ? [2 * pixel, 3 * pixel] : []);
    context.stroke();
  }
  context.setLineDash([]);
  for (const zone of mission.zones) {
    trace(context, zone.shape);
    context.strokeStyle = colours.halo;
    context.lineWidth = 4 * pixel;
    context.stroke();
    context.strokeStyle = colours.zone;
    context.lineWidth = 1.75 * pixel;
    context.setLineDash(zone.demand === "visit" ? [7 * pixel, 4 * pixel] : []);
    context.stroke();
    context.setLineDash([]);
  }
  trace(context, mission.area);
  context.strokeStyle = colours.ink;
  context.lineWidth = 1.5 * pixel;
  context.stroke();
  if (shown.routes) {
    drawRoutes(context, playback, colours, pixel, lost);
    if ("turn_time_s" in playback.arrays) drawTurns(context, playback, colours, pixel);
  }
  if (playback.header.seam) drawWaysBefore(context, playback.header.seam, colours, pixel);
  drawChargers(stage, mission);
  drawNames(stage, mission, colours);
}

/** Every robot's loop as a thin line; its way there is dotted. */
function drawRoutes(context, playback, colours, pixel, lost) {
  const { corner_offsets: offsets, corner_time_s: times, corner_x_m: xs, corner_y_m: ys } = playback.arrays;
  if (xs.length > MOST_CORNERS) return;
  context.lineJoin = "round";
  playback.robots.forEach((robot, k) => {
    context.globalAlpha = lost.has(k) ? 0.2 : 0.75;
    const parts = robot.loops ? [[-1, robot.loop_start_s], [robot.loop_start_s, Infinity]] : [[-1, Infinity]];
    parts.forEach(([from, to], part) => {
      context.beginPath();
      let begun = false;
      for (let i = offsets[k]; i < offsets[k + 1]; i++) {
        if (times[i] < from || times[i] > to) continue;
        if (begun) context.lineTo(xs[i], ys[i]);
        else context.moveTo(xs[i], ys[i]);
        begun = true;
      }
      const way = part === 0 && parts.length === 2;
      context.setLineDash(way ? [1 * pixel, 3 * pixel] : []);
      context.strokeStyle = colours.halo;
      context.lineWidth = 3 * pixel;
      if (!way) context.stroke();
      context.strokeStyle = colours.routes[k % colours.routes.length];
      context.lineWidth = 1.25 * pixel;
      context.stroke();
    });
  });
  context.setLineDash([]);
  context.globalAlpha = 1;
}

/** A square with a bolt at each charger. */
function drawChargers(stage, { chargers }) {
  const context = stage.inPixels("shapes");
  for (const { at } of chargers) {
    const [x, y] = stage.toPixels(...at);
    context.fillStyle = "#ffe45c";
    context.strokeStyle = "#222222";
    context.lineWidth = 1.25;
    context.fillRect(x - 6, y - 6, 12, 12);
    context.strokeRect(x - 6, y - 6, 12, 12);
    context.beginPath();
    BOLT.forEach(([right, up]) => context.lineTo(x + 4.5 * right, y - 4.5 * up));
    context.fillStyle = "#222222";
    context.fill();
  }
}

/** How robots came to where the plan takes over, dotted in grey; a cross where one was lost. */
function drawWaysBefore(context, { ways, lost }, colours, pixel) {
  context.strokeStyle = colours.away;
  context.lineWidth = 2 * pixel;
  context.setLineDash([2 * pixel, 3 * pixel]);
  for (const { positions_m: places } of ways) {
    context.beginPath();
    places.forEach(([x, y]) => context.lineTo(x, y));
    context.stroke();
  }
  context.setLineDash([]);
  context.beginPath();
  for (const { robot, positions_m: places } of ways) if (lost.includes(robot)) cross(context, ...places.at(-1), pixel);
  context.strokeStyle = colours.danger;
  context.lineWidth = 2.5 * pixel;
  context.stroke();
}

/** Adds a cross to a path, where a robot is lost. */
export function cross(context, x, y, pixel) {
  const arm = 7 * pixel;
  context.moveTo(x - arm, y - arm);
  context.lineTo(x + arm, y + arm);
  context.moveTo(x - arm, y + arm);
  context.lineTo(x + arm, y - arm);
}

/** A short bar across the way wherever a bouncing robot turns: where it bumps, or its clock tells it to. */
function drawTurns(context, playback, colours, pixel) {
  const { turn_offsets: offsets, turn_x_m: xs, turn_y_m: ys, turn_before_rad: facing } = playback.arrays;
  playback.robots.forEach((robot, k) => {
    const ahead = Math.max(robot.body_radius_m, 4 * pixel);
    context.beginPath();
    for (let i = offsets[k]; i < offsets[k + 1]; i++) {
      const [dx, dy] = [Math.cos(facing[i]), Math.sin(facing[i])];
      const [x, y] = [xs[i] + ahead * dx, ys[i] + ahead * dy];
      context.moveTo(x - 4 * pixel * dy, y + 4 * pixel * dx);
      context.lineTo(x + 4 * pixel * dy, y - 4 * pixel * dx);
    }
    for (const [colour, width] of [[colours.halo, 4.5], [colours.routes[k % colours.routes.length], 2.5]]) {
      context.strokeStyle = colour;
      context.lineWidth = width * pixel;
      context.stroke();
    }
  });
}

/** The zones' names above their shapes. */
function drawNames(stage, mission, colours) {
  const context = stage.inPixels("shapes");
  context.font = "600 12px system-ui, sans-serif";
  context.textAlign = "center";
  context.textBaseline = "bottom";
  context.lineJoin = "round";
  for (const zone of mission.zones) {
    const [x0, , x1, y1] = boundsOf(zone.shape);
    const [px, py] = stage.toPixels((x0 + x1) / 2, y1);
    write(context, zone.name, px, py - 4, colours);
  }
}

/** Text with a halo, so that it reads on any colour. */
export function write(context, text, x, y, colours) {
  context.strokeStyle = colours.halo;
  context.lineWidth = 3;
  context.strokeText(text, x, y);
  context.fillStyle = colours.ink;
  context.fillText(text, x, y);
}

/** Obstacles that move, where they are at a time. */
export function drawMoving(context, mission, time, colours, pixel) {
  for (const { radius_m: radius, times_s: times, positions_m: places } of mission.moving_obstacles) {
    const [x, y] = between(times, places, time);
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.fillStyle = colours.obstacle;
    context.globalAlpha = 0.7;
    context.fill();
    context.globalAlpha = 1;
    context.strokeStyle = colours.halo;
    context.lineWidth = pixel;
    context.stroke();
  }
}

/** A place on timed points, straight between them; before the first and after the last it stands. */
export function between(times, places, time) {
  let k = times.findIndex((other) => other > time);
  if (k === 0) return places[0];
  if (k < 0) return places[places.length - 1];
  const share = (time - times[k - 1]) / (times[k] - times[k - 1]);
  return [0, 1].map((axis) => places[k - 1][axis] + share * (places[k][axis] - places[k - 1][axis]));
}
