/** Coverage against time, with a line at the time that is shown. */

import { el, freshId, svg } from "./elements.js";
import { percent, reading } from "./text.js";

const [WIDTH, HEIGHT, LEFT, BOTTOM, TOP] = [400, 150, 44, 20, 8];

export class CoverageChart {
  /**
   * @param {import("./playback.js").Playback} playback
   * @param {(time: number) => void} seek
   */
  constructor(playback, seek) {
    const { coverage_time_s: times, coverage_share: shares } = playback.arrays;
    this._times = times;
    this._shares = shares;
    this._end = Math.max(times[times.length - 1], 1e-9);
    const { what, at_rest: atRest } = playback.header.coverage;
    this._what = what;
    const steps = what === "cells entered";
    let path = `M${this._x(times[0])},${this._y(shares[0])}`;
    for (let k = 1; k < times.length; k++) {
      if (steps) path += `H${this._x(times[k])}`;
      path += `${steps ? "V" : `L${this._x(times[k])},`}${this._y(shares[k])}`;
    }
    const grid = [0, 0.25, 0.5, 0.75, 1].flatMap((share) => [
      svg("line", { class: "rota-lane", x1: LEFT, x2: WIDTH, y1: this._y(share), y2: this._y(share) }),
      svg("text", { class: "rota-axis", x: LEFT - 4, y: this._y(share) + 4, "text-anchor": "end", text: `${100 * share} %` }),
    ]);
    this._now = svg("line", { class: "rota-now", y1: TOP, y2: HEIGHT - BOTTOM });
    this._told = el("p", {});
    const title = freshId("coverage");
    const picture = svg(
      "svg",
      {
        class: "rota-chart", viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-labelledby": title,
        on: { click: (event) => {
          const box = picture.getBoundingClientRect();
          const x = ((event.clientX - box.left) / box.width) * WIDTH;
          seek(Math.min(Math.max(((x - LEFT) / (WIDTH - LEFT)) * this._end, 0), this._end));
        } },
      },
      svg("title", { id: title, text: `Share of ${what} from 0 to ${reading(this._end)}, at the end ${percent(shares[shares.length - 1])}` }),
      ...grid,
      svg("text", { class: "rota-axis", x: LEFT, y: HEIGHT - 5, text: "0:00" }),
      svg("text", { class: "rota-axis", x: WIDTH, y: HEIGHT - 5, "text-anchor": "end", text: reading(this._end) }),
      svg("path", { class: "rota-curve", d: path }),
      this._now,
    );
    const rest = atRest === null ? null : el("p", { text: `At rest ${percent(atRest)} of the ground is in range of some robot.` });
    this.node = el("div", {}, this._told, picture, rest);
  }

  /** The share at a time. */
  shareAt(time) {
    let k = 0;
    while (k + 1 < this._times.length && this._times[k + 1] <= time) k++;
    return this._shares[k];
  }

  update(time) {
    const x = this._x(Math.min(time, this._end));
    this._now.setAttribute("x1", x);
    this._now.setAttribute("x2", x);
    this._told.textContent = `${this._what[0].toUpperCase()}${this._what.slice(1)} at ${reading(time)}: ${percent(this.shareAt(time))}`;
  }

  _x(time) {
    return Number((LEFT + (time / this._end) * (WIDTH - LEFT)).toFixed(2));
  }

  _y(share) {
    return Number((HEIGHT - BOTTOM - share * (HEIGHT - BOTTOM - TOP)).toFixed(2));
  }
}
