/** A fleet that drives the plan now, by a link: started here, shown on the map by the player. */

import { api } from "../api.js";
import { button, el, freshId } from "../dom.js";
import { messageOf } from "../notices.js";

const MOST_NOTICES = 50;
const OVER = ["ended", "failed"];

export class Live {
  /**
   * @param {HTMLElement} section
   * @param {any[]} links as the server lists them
   * @param {() => {plan: string|null, player: any}} shown the plan on the map, and its player
   */
  constructor(section, links, shown) {
    this.shown = shown;
    this.links = links;
    this.watch = null;
    this.endEvents = () => undefined;
    this.link = el("select", { id: "link", on: { change: () => this.fillSettings() } }, ...links.map(({ name, what }) => el("option", { value: name }, `${name}: ${what}`)));
    this.settings = el("div", { class: "fields" });
    this.start = button("Watch the fleet", () => this.begin(), { id: "live-start" });
    this.stop = button("End the watch", () => this.end(), { hidden: true, id: "live-stop" });
    this.fault = el("p", { class: "fault", role: "alert" });
    this.state = el("p", { role: "status" });
    this.robots = el("div", { class: "scroll" });
    this.notices = el("ul", { class: "plain", "aria-live": "polite", "aria-label": "Notices" });
    const link = el("div", { class: "field" }, el("label", { for: "link" }, "Link to the robots"), this.link);
    const more = el("details", {}, el("summary", {}, "Settings of the link"), this.settings);
    const parts = [link, more, el("div", { class: "row" }, this.start, this.stop), this.fault, this.state, this.robots, this.notices];
    this.box = el("details", {}, el("summary", {}, "A live fleet on this plan"), el("div", { class: "plain" }, ...parts));
    section.append(this.box);
    this.fillSettings();
    this.showPlan();
  }

  /** Only a plan on the map can be watched live. */
  showPlan() {
    this.box.hidden = this.shown().plan === null && this.watch === null;
  }

  fillSettings() {
    const chosen = this.links.find(({ name }) => name === this.link.value);
    const fields = (chosen?.settings ?? []).map(({ name, what, default: usual }) => {
      const input = el("input", { type: "text", autocomplete: "off", id: freshId("setting"), "data-setting": name, placeholder: usual === null ? "none" : String(usual) });
      return el("div", { class: "field" }, el("label", { for: input.id }, name), input, el("span", { class: "field-help" }, what));
    });
    this.settings.replaceChildren(...fields);
  }

  async begin() {
    const { plan } = this.shown();
    if (plan === null) {
      return;
    }
    this.fault.textContent = "";
    this.start.disabled = true;
    const given = [...this.settings.querySelectorAll("[data-setting]")].filter((input) => input.value !== "");
    const settings = Object.fromEntries(given.map((input) => [input.dataset.setting, input.value]));
    try {
      this.watch = await api.startWatch({ plan, link: this.link.value, settings });
      this.notices.replaceChildren();
      this.follow();
    } catch (error) {
      this.fault.textContent = `The fleet cannot be watched: ${messageOf(error)}`;
    }
    this.start.disabled = false;
    this.showButtons();
  }

  follow() {
    const { id } = this.watch;
    this.state.textContent = "Listening to the robots…";
    const listeners = { state: (state) => this.show(state), notice: (notice) => this.tell(notice), ended: (watch) => this.ended(watch) };
    this.endEvents = api.watchEvents(id, listeners, () => this.broken(id));
  }

  show(state) {
    const { plan, player } = this.shown();
    if (this.watch === null) {
      return;
    }
    if (plan === this.watch.plan) {
      player?.showLive(state);
    }
    this.state.textContent = `Live: ${state.robots.filter((robot) => !robot.lost).length} of ${state.robots.length} robots heard, ${Math.round(state.time_s)} s since the start.`;
    const heads = ["Robot", "Off its way", "Behind", "Battery", "State"].map((text) => el("th", { scope: "col" }, text));
    const rows = state.robots.map((robot) => {
      const texts = [robot.name, metres(robot.away_m), seconds(robot.lag_s), share(robot.battery), stateOf(robot)];
      return el("tr", {}, ...texts.map((text) => el("td", {}, text)));
    });
    this.robots.replaceChildren(el("table", {}, el("thead", {}, el("tr", {}, ...heads)), el("tbody", {}, ...rows)));
  }

  tell(notice) {
    const line = el("li", { class: notice.is_alarm ? "fault" : "soft" }, `${Math.round(notice.time_s)} s: ${notice.text}`);
    this.notices.prepend(line);
    while (this.notices.childElementCount > MOST_NOTICES) {
      this.notices.lastElementChild?.remove();
    }
  }

  async end() {
    if (this.watch === null) {
      return;
    }
    try {
      const watch = await api.stopWatch(this.watch.id);
      if (OVER.includes(watch.state)) {
        this.ended(watch);
      } else {
        this.state.textContent = "Ending the watch…"; // its last event tells when
      }
    } catch (error) {
      this.fault.textContent = `The watch could not be ended: ${messageOf(error)}`;
    }
  }

  ended(watch) {
    if (this.watch === null) {
      return;
    }
    this.endEvents();
    this.watch = null;
    this.shown().player?.showLive(null);
    this.state.textContent = watch.message ? `The watch has ended: ${watch.message}` : "The watch has ended.";
    this.showButtons();
    this.showPlan();
  }

  /** The events broke off: the watch has ended, or the server is gone. */
  async broken(id) {
    if (this.watch?.id !== id) {
      return;
    }
    try {
      const watch = await api.watch(id);
      if (OVER.includes(watch.state)) {
        this.ended(watch);
      } else {
        this.follow();
      }
    } catch (error) {
      this.ended({ message: messageOf(error) });
    }
  }

  showButtons() {
    this.start.hidden = this.watch !== null;
    this.stop.hidden = this.watch === null;
  }
}

function metres(value) {
  return typeof value === "number" ? `${value.toFixed(1)} m` : "–";
}

function seconds(value) {
  return typeof value === "number" ? `${value.toFixed(1)} s` : "–";
}

function share(value) {
  return typeof value === "number" ? `${Math.round(value * 100)} %` : "–";
}

function stateOf(robot) {
  if (robot.lost) {
    return "lost";
  }
  if (typeof robot.silent_s === "number" && robot.silent_s > 5) {
    return `silent for ${Math.round(robot.silent_s)} s`;
  }
  return robot.standing ? "stands" : "on its way";
}
