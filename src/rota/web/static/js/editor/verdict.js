/** What is known of the mission while it is edited: faults, warnings, and how many robots are surely needed. */

import { button, el } from "../dom.js";
import { messageOf } from "../notices.js";

const MOST_SHOWN = 20;
const NOTHING_DRAWN = "Draw the area that robots are to watch: press Area above the map, then click its corners.";

/**
 * @param {HTMLElement} section
 * @param {import("./validation.js").Validation} validation
 * @param {(path: (string|number)[]) => void} goTo shows the field or the shape of a fault
 * @param {() => boolean} isEmpty whether nothing is drawn yet
 */
export function startVerdict(section, validation, goTo, isEmpty) {
  const show = (...boxes) => section.replaceChildren(...boxes);
  validation.addEventListener("asking", () => {
    section.setAttribute("aria-busy", "true");
    if (isEmpty()) {
      show(box("plain", NOTHING_DRAWN));
    } else if (section.textContent === "" || section.textContent === NOTHING_DRAWN) {
      show(box("plain", "Checking the mission…"));
    }
  });
  validation.addEventListener("failed", (event) => {
    section.removeAttribute("aria-busy");
    show(box("fault", `The mission could not be checked: ${messageOf(/** @type {CustomEvent} */ (event).detail)}`));
  });
  validation.addEventListener("result", (event) => {
    section.removeAttribute("aria-busy");
    show(...boxesOf(/** @type {CustomEvent} */ (event).detail, goTo, isEmpty()));
  });
}

function boxesOf(result, goTo, empty) {
  if (empty) {
    return [box("plain", NOTHING_DRAWN)];
  }
  const boxes = [];
  if (result.faults.length > 0) {
    const count = result.faults.length;
    const list = el("ul", {}, ...result.faults.slice(0, MOST_SHOWN).map((fault) => el("li", {}, faultLine(fault, goTo))));
    boxes.push(box("fault", `${count === 1 ? "One thing keeps" : `${count} things keep`} this mission from being planned:`, list));
  } else if (result.bound !== null && result.bound !== undefined) {
    const robots = result.bound.robots === 1 ? "1 robot" : `${result.bound.robots} robots`;
    boxes.push(box("ok", el("strong", {}, `At least ${robots}, proved: `), result.bound.reason, areaText(result)));
  } else {
    const more = result.compiling ? " How many robots are surely needed follows once Rota has compiled itself, which it does once." : "";
    boxes.push(box("ok", `The mission can be planned.${more}`, areaText(result)));
  }
  if (result.warnings.length > 0) {
    boxes.push(box("warn", el("ul", {}, ...result.warnings.map((warning) => el("li", {}, textOf(warning))))));
  }
  return boxes;
}

function faultLine(fault, goTo) {
  const named = fault.field ? `${fault.field}: ${fault.message}` : fault.message;
  return fault.path.length === 0 ? named : button(named, () => goTo(fault.path), { class: "link" });
}

function areaText(result) {
  const free = result.free_m2;
  if (typeof free !== "number") {
    return null;
  }
  const shown = free >= 1e4 ? `${(free / 1e4).toFixed(2)} ha` : `${free.toFixed(1)} m²`;
  return el("p", { class: "soft" }, `Free ground: ${shown}.`);
}

function textOf(warning) {
  return typeof warning === "string" ? warning : (warning.message ?? String(warning));
}

function box(kind, ...children) {
  return el("div", { class: `verdict-${kind}` }, ...children);
}
