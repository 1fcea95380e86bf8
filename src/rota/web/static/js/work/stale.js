/** What is said of a plan whose mission has changed since it was made: that it is stale, and why. */

import { el } from "../dom.js";

const MOST_TOLD = 4;

/** What has changed, in one line. */
export function changesText(plan) {
  const { stale } = plan;
  const more = stale.length > MOST_TOLD ? [`and ${stale.length - MOST_TOLD} more`] : [];
  return [...stale.slice(0, MOST_TOLD), ...more].join(", ");
}

/** From when on a plan or job goes on from another plan, and without whom; nothing for others. */
export function changeText({ change }) {
  return change ? `from ${Number(change.at_s.toFixed(1))} s on without ${change.lost.join(", ")}` : "";
}

/** How many robots a plan has. */
export function robotsText({ robots }) {
  return robots === 1 ? "1 robot" : `${robots} robots`;
}

/** Whether a plan is of the mission as it was, not as it is. */
export function isStale(plan) {
  return (plan?.stale ?? []).length > 0;
}

/** A plan's verdict; that of a stale plan is of the mission as it was, and while edits are being saved nobody knows. */
export function verdictBadge(plan, unsure) {
  if (unsure) {
    return el("span", { class: "state" }, "checking…");
  }
  if (isStale(plan)) {
    return el("span", { class: "state state-stale", title: `Since it was made: ${changesText(plan)}` }, "stale");
  }
  return el("span", { class: `state state-${plan.verdict === "met" ? "met" : "failed"}` }, plan.verdict ?? "?");
}

/** A note above what is shown of a plan; null where the plan holds. */
export function staleNote(plan, unsure) {
  if (plan === null || (!unsure && !isStale(plan))) {
    return null;
  }
  if (unsure) {
    return el("p", { class: "soft" }, "The mission was changed: whether the plan still holds is known once it is saved.");
  }
  const was = `Before, it was ${plan.verdict} with ${robotsText(plan)}. Plan again in step 2.`;
  const head = el("p", {}, el("strong", {}, "Stale: "), "the mission has changed since this plan was made.");
  const changes = el("ul", {}, ...plan.stale.map((change) => el("li", {}, el("strong", {}, change))));
  return el("div", { class: "verdict" }, el("div", { class: "verdict-warn" }, head, changes, el("p", {}, was)));
}
