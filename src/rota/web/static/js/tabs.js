/** Tabs by the pattern of WAI-ARIA: arrow keys move between them, one panel is shown. */

import { byId } from "./dom.js";

export class Tabs extends EventTarget {
  /** @param {HTMLElement} list with buttons role=tab whose aria-controls name the panels */
  constructor(list) {
    super();
    this.tabs = /** @type {HTMLElement[]} */ ([...list.querySelectorAll("[role=tab]")]);
    for (const tab of this.tabs) {
      tab.addEventListener("click", () => this.show(this.nameOf(tab)));
      tab.addEventListener("keydown", (event) => this.moved(event, tab));
    }
    this.current = this.nameOf(this.tabs[0]);
  }

  nameOf(tab) {
    return tab.dataset.tab ?? "";
  }

  moved(event, tab) {
    const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (step === undefined) {
      return;
    }
    const count = this.tabs.length;
    const next = this.tabs[(this.tabs.indexOf(tab) + step + count) % count];
    event.preventDefault();
    this.show(this.nameOf(next));
    next.focus();
  }

  /** Shows the panel of a tab by its name and tells "change". */
  show(name) {
    for (const tab of this.tabs) {
      const chosen = this.nameOf(tab) === name;
      tab.setAttribute("aria-selected", String(chosen));
      tab.tabIndex = chosen ? 0 : -1;
      byId(tab.getAttribute("aria-controls") ?? "").hidden = !chosen;
    }
    const changed = name !== this.current;
    this.current = name;
    document.body.dataset.tab = name;
    if (changed) {
      this.dispatchEvent(new Event("change"));
    }
  }
}
