/** What the page tells: a banner while the server is gone, short notices with an undo, and questions before a loss. */

import { api, ApiError, connection } from "./api.js";
import { button, byId, el } from "./dom.js";
import { faultInWords, textInWords } from "./editor/words.js";

const NOTICE_S = 12;
const RETRY_S = 3;

/** A notice in the corner; it goes by itself unless it is an error. */
export function notify(text, { error = false, undo = null } = {}) {
  const box = el("div", { class: error ? "notice notice-error" : "notice", role: error ? "alert" : "status" });
  box.append(el("p", {}, text));
  const close = () => box.remove();
  if (undo !== null) {
    box.append(
      button("Undo", () => {
        close();
        undo();
      }),
    );
  }
  box.append(button("Close", close, { class: "quiet" }));
  byId("notices").append(box);
  if (!error) {
    window.setTimeout(close, NOTICE_S * 1000);
  }
}

/** An error in plain words; anything that is no answer of the server is the page's own fault and says so. */
export function notifyError(error, doing) {
  if (error instanceof DOMException && error.name === "AbortError") {
    return;
  }
  notify(`${doing}: ${messageOf(error)}`, { error: true });
}

/** What went wrong, with the faults that the server listed; `ofFile`: as they stand in a file, not in a mission's words. */
export function messageOf(error, { ofFile = false } = {}) {
  if (!(error instanceof ApiError)) {
    console.error(error);
    return `the page itself failed (${error instanceof Error ? error.message : error})`;
  }
  const faults = error.faults.slice(0, 5).map((fault) => (ofFile ? fault.message : faultInWords(fault)));
  const more = error.faults.length > 5 ? [`and ${error.faults.length - 5} more`] : [];
  const missing = faults.filter((fault) => !error.message.includes(fault));
  const told = ofFile ? error.message : textInWords(error.message);
  return missing.length === 0 ? told : [told, ...missing, ...more].join(" — ");
}

/**
 * Asks before something is lost; resolves to whether it may be.
 * @returns {Promise<boolean>}
 */
export function confirmed(question, yes) {
  const dialog = byId("confirm");
  byId("confirm-question").textContent = question;
  byId("confirm-yes").textContent = yes;
  dialog.returnValue = "";
  dialog.showModal();
  return new Promise((resolve) => {
    dialog.addEventListener("close", () => resolve(dialog.returnValue === "yes"), { once: true });
  });
}

/** Shows the banner while the server is gone and asks again until it is back. */
export function startBanner() {
  const banner = byId("banner");
  let timer = 0;
  const retry = () => api.about().catch(() => undefined);
  connection.addEventListener("gone", () => {
    banner.hidden = false;
    timer = window.setInterval(retry, RETRY_S * 1000);
  });
  connection.addEventListener("back", () => {
    banner.hidden = true;
    clearInterval(timer);
  });
  byId("retry").addEventListener("click", retry);
}
