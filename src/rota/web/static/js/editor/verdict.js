/** What is known of the mission while it is edited: faults, warnings, and how many robots are surely needed. */

import { button, el } from "../dom.js";
import { messageOf } from "../notices.js";
import { faultInWords } from "./words.js";

const MOST_SHOWN = 20;
const NOTHING_DRAWN = "Draw the area that robots are to watch: press Area above the map, then click its corners.";

/**
 * @param {HTMLElement} section
 * @param {import("./validation.js").Validation} validation
 * @param {import("./editor.js").Editor} editor shows the field or the shape of a fault, and knows what is drawn
 */
export function startVerdict(section, validation, editor) {
  const show = (...boxes) => section.replaceChildren(...boxes);
  validation.addEventListener("asking", () => {
    section.setAttribute("aria-busy", "true");
    if (editor.isEmpty) {
      show(box("plain", NOTHING_DRAWN));
    } else if (section.querySelector(".verdict-ok, .verdict-fault") === null) {
      show(box("plain", "Checking the mission…"));
    }
  });
  validation.addEventListener("forgotten", () => show());
  validation.addEventListener("failed", (event) => {
    section.removeAttribute("aria-busy");
    show(box("fault", `The mission could not be checked: ${messageOf(/** @type {CustomEvent} */ (event).detail)}`));
  });
  validation.addEventListener("result", (event) => {
    section.removeAttribute("aria-busy");
    show(...boxesOf(/** @type {CustomEvent} */ (event).detail, editor));
  });
}

function boxesOf(result, editor) {
  if (editor.isEmpty) {
    return [box("plain", NOTHING_DRAWN)];
  }
  const boxes = [];
  if (result.faults.length > 0) {
    boxes.push(box("fault", countOf(result.faults), faultList(result.faults, editor)));
  } else if (result.bound !== null && result.bound !== undefined) {
    const robots = result.bound.robots === 1 ? "1 robot" : `${result.bound.robots} robots`;
    boxes.push(box("ok", el("strong", {}, `At least ${robots}, proved: `), result.bound.reason, areaText(result)));
  } else {
    const more = result.compiling ? " How many robots are surely needed follows once Rota has compiled itself, which it does once." : "";
    boxes.push(box("ok", `The mission can be planned.${more}`, areaText(result)));
  }
  if (result.warnings.length > 0) {
    boxes.push(box("warn", faultList(result.warnings, editor)));
  }
  return boxes;
}

/** How many faults there are, as a beginning of their list. */
export function countOf(faults) {
  return `${faults.length === 1 ? "One thing keeps" : `${faults.length} things keep`} this mission from being planned:`;
}

/** Faults in words, each leading to its field or shape, with what mends it where that is one step. */
export function faultList(faults, editor) {
  const lines = faults.slice(0, MOST_SHOWN).map((fault) => el("li", {}, faultLine(fault, editor)));
  if (faults.some(isOfStarts) && editor.canDock) {
    lines.push(el("li", {}, button("All start here (dock)", () => editor.dockStarts(), { title: "One box round the first start instead of single places" })));
  }
  const more = faults.length - MOST_SHOWN;
  return el("ul", {}, ...lines, more > 0 ? el("li", {}, `and ${more} more`) : null);
}

function isOfStarts(fault) {
  return fault.path?.[0] === "fleet" && fault.path[1] === "start";
}

function faultLine(fault, editor) {
  const told = faultInWords(fault, editor.store.document);
  return (fault.path ?? []).length === 0 ? told : button(told, () => editor.goTo(fault.path), { class: "link" });
}

function areaText(result) {
  const free = result.free_m2;
  if (typeof free !== "number") {
    return null;
  }
  const shown = free >= 1e4 ? `${(free / 1e4).toFixed(2)} ha` : `${free.toFixed(1)} m²`;
  return el("p", { class: "soft" }, `Free ground: ${shown}.`);
}

function box(kind, ...children) {
  return el("div", { class: `verdict-${kind}` }, ...children);
}
