/** A shape as numbers: all that can be drawn by mouse can be typed too. */

import { button, el } from "../dom.js";
import { KINDS } from "./drawing.js";

/**
 * The table of a shape's coordinates.
 * @param {import("./shapes.js").Shape} shape
 * @param {boolean} degrees
 * @param {() => any} latest the shape's geometry as it is now: the table is not built anew while somebody types in it
 * @param {(geometry: import("./shapes.js").Geometry, merge: string) => void} change
 */
export function coordinateTable(shape, degrees, latest, change) {
  const { geometry } = shape;
  const names = degrees ? ["Longitude (°)", "Latitude (°)"] : ["x (m, east)", "y (m, north)"];
  const table = (label, get, set, least) => pointTable({ label, names, get: () => get(latest()), set, least, stem: `${shape.key}/${label}` });
  switch (geometry.type) {
    case "ring":
      return el(
        "div",
        { class: "coordinates" },
        table("Corner", (now) => now.outer, (outer, merge) => change({ ...latest(), outer }, merge), 3),
        ...geometry.holes.map((_, k) => {
          const set = (hole, merge) => change({ ...latest(), holes: latest().holes.with(k, hole) }, merge);
          return table(`Hole ${k + 1}, corner`, (now) => now.holes[k], set, 3);
        }),
      );
    case "circle":
      return el(
        "div",
        { class: "coordinates" },
        table("Centre", (now) => [now.centre], ([centre], merge) => change({ ...latest(), centre }, merge), 1),
        radius(shape, latest, change),
      );
    case "points":
      return el("div", { class: "coordinates" }, table(KINDS[shape.kind], (now) => now.points, (points, merge) => change({ ...latest(), points }, merge), 1));
    case "box":
      return el("div", { class: "coordinates" }, table("Opposite corner", (now) => now.corners, (corners, merge) => change({ ...latest(), corners }, merge), 2));
    default:
      return el("p", {}, `${geometry.what}: shown, not edited here.`);
  }
}

function radius(shape, latest, change) {
  const input = numberInput(shape.geometry.radius_m, "Radius in metres", `${shape.key}/radius`);
  input.addEventListener("input", () => {
    const value = Number(input.value);
    if (input.value !== "" && value > 0) {
      change({ ...latest(), radius_m: value }, `${shape.key}/radius`);
    }
  });
  return el("label", { class: "unit" }, "Radius", input, el("span", {}, "m"));
}

function pointTable({ label, names, get, set, least, stem }) {
  const points = get();
  const fixed = least < 3 && !["Start", "Entrance"].includes(label);
  const head = el("tr", {}, el("th", { scope: "col" }, label), ...names.map((name) => el("th", { scope: "col" }, name)), fixed ? null : el("td", {}));
  const rows = points.map((point, k) => {
    const cells = [0, 1].map((axis) => {
      const mark = `${stem}/${k}/${axis}`;
      const input = numberInput(point[axis], `${label} ${k + 1}, ${names[axis]}`, mark);
      input.addEventListener("input", () => {
        if (input.value !== "") {
          set(get().with(k, get()[k].with(axis, Number(input.value))), mark);
        }
      });
      return el("td", {}, input);
    });
    return el("tr", {}, el("td", {}, String(k + 1)), ...cells, fixed ? null : el("td", { class: "row" }, ...buttons({ label, get, set, least, stem }, k)));
  });
  return el("div", { class: "scroll" }, el("table", {}, el("thead", {}, head), el("tbody", {}, ...rows)));
}

function buttons({ label, get, set, least, stem }, k) {
  const add = () => {
    const points = get();
    const next = points[(k + 1) % points.length];
    const between = points.length > 1 ? [0, 1].map((axis) => (points[k][axis] + next[axis]) / 2) : points[k];
    set([...points.slice(0, k + 1), between, ...points.slice(k + 1)], "");
  };
  const remove = () => set(get().filter((_, j) => j !== k), "");
  const name = `${label.toLowerCase()} ${k + 1}`;
  return [
    button("+", add, { "aria-label": `Add after ${name}`, "data-mark": `${stem}/add/${k}` }),
    button("−", remove, { "aria-label": `Delete ${name}`, "data-mark": `${stem}/remove/${k}`, disabled: get().length <= least }),
  ];
}

function numberInput(value, label, mark) {
  return el("input", { type: "number", step: "any", value: String(value), "aria-label": label, "data-mark": mark });
}
