/** The dialog in which each feature of GeoJSON files becomes the area, a zone or an obstacle, or is left out. */

import { button, byId, el } from "../dom.js";

const ROLES = { a: "Area", z: "Zone", o: "Obstacle", "-": "Leave out" };
const SVG = "http://www.w3.org/2000/svg";
const KINDS = { a: "area", z: "zone", o: "obstacle", "-": "none" };

/**
 * Asks what each feature is; resolves to a letter for each, or null when nothing is to be opened.
 * @param {{name: string, file: string, m2: number, shape: number[][][][]}[]} features
 * @returns {Promise<string|null>}
 */
export function chosenRoles(features) {
  const dialog = byId("features");
  const roles = features.map(() => "a");
  const rows = features.map((feature, k) => rowOf(feature, k, (role) => set(k, role)));
  const paths = features.map((feature, k) => pathOf(feature, () => set(k, next(roles[k]))));
  const open = button("Open", () => dialog.close("open"), { class: "primary", id: "features-open" });
  const fault = el("p", { class: "fault" });

  function set(k, role) {
    roles[k] = role;
    show();
  }
  function setAll(roleOf) {
    features.forEach((feature, k) => (roles[k] = roleOf(feature, k)));
    show();
  }
  function show() {
    rows.forEach((row, k) => {
      row.querySelectorAll("input").forEach((input) => (input.checked = input.value === roles[k]));
    });
    paths.forEach((path, k) => path.setAttribute("class", `shape shape-${KINDS[roles[k]]}`));
    open.disabled = !roles.includes("a");
    fault.textContent = open.disabled ? "One feature at least is the area." : "";
  }

  const largest = features.reduce((best, feature, k) => (feature.m2 > features[best].m2 ? k : best), 0);
  const shortcuts = el(
    "div",
    { class: "row" },
    button("All are the area", () => setAll(() => "a")),
    button("The largest is the area, others obstacles", () => setAll((_, k) => (k === largest ? "a" : "o"))),
    button("The largest is the area, others zones", () => setAll((_, k) => (k === largest ? "a" : "z"))),
  );
  byId("features-body").replaceChildren(
    el("p", {}, "As the area, features are united. Click a feature on the picture, or choose beside its name."),
    pictureOf(features, paths),
    shortcuts,
    el("ul", { class: "plain features" }, ...rows),
    fault,
    el("div", { class: "row" }, open, button("Cancel", () => dialog.close(""))),
  );
  show();
  dialog.returnValue = "";
  dialog.showModal();
  return new Promise((resolve) => {
    dialog.addEventListener("close", () => resolve(dialog.returnValue === "open" ? roles.join("") : null), { once: true });
  });
}

function next(role) {
  const order = Object.keys(ROLES);
  return order[(order.indexOf(role) + 1) % order.length];
}

function rowOf(feature, k, choose) {
  const inputs = Object.entries(ROLES).map(([value, name]) => {
    const input = el("input", { type: "radio", name: `feature-${k}`, value });
    input.addEventListener("change", () => choose(value));
    return el("label", {}, input, name);
  });
  const size = feature.m2 >= 1e4 ? `${(feature.m2 / 1e4).toFixed(2)} ha` : `${feature.m2.toFixed(0)} m²`;
  const legend = el("legend", {}, el("strong", {}, feature.name), el("span", { class: "soft" }, ` ${size} · ${feature.file}`));
  return el("li", { class: "card" }, el("fieldset", { class: "row" }, legend, ...inputs));
}

/** All features as a map would show them, the smallest on top. */
function pictureOf(features, paths) {
  const points = features.flatMap((feature) => feature.shape.flat(2));
  const ends = (axis) => points.reduce(([low, high], point) => [Math.min(low, point[axis]), Math.max(high, point[axis])], [Infinity, -Infinity]);
  const [[west, east], [south, north]] = [ends(0), ends(1)];
  const narrower = Math.cos((((south + north) / 2) * Math.PI) / 180);
  const scale = 100 / Math.max((east - west) * narrower, north - south);
  features.forEach((feature, k) => {
    const place = ([lon, lat]) => `${((lon - west) * narrower * scale).toFixed(3)},${((north - lat) * scale).toFixed(3)}`;
    const ring = (corners) => `M${corners.map(place).join("L")}Z`;
    paths[k].setAttribute("d", feature.shape.flat().map(ring).join(""));
  });
  const svg = document.createElementNS(SVG, "svg");
  svg.setAttribute("viewBox", `-2 -2 ${(east - west) * narrower * scale + 4} ${(north - south) * scale + 4}`);
  svg.setAttribute("class", "features-picture");
  svg.setAttribute("role", "img");
  svg.setAttribute("aria-label", "The features");
  const order = features.map((_, k) => k).sort((a, b) => features[b].m2 - features[a].m2);
  svg.append(...order.map((k) => paths[k]));
  return svg;
}

function pathOf(feature, click) {
  const path = document.createElementNS(SVG, "path");
  path.addEventListener("click", click);
  const title = document.createElementNS(SVG, "title");
  title.textContent = feature.name;
  path.append(title);
  return path;
}
