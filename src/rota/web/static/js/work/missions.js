/** The dialog of missions: those that are kept, a new one, examples, files; and files dropped on the page. */

import { api } from "../api.js";
import { button, byId, el, saveBlob } from "../dom.js";
import { confirmed, messageOf, notify, notifyError } from "../notices.js";
import { chosenRoles } from "./features.js";

const FIRST_EXAMPLES = ["harbour-copters", "parcel", "building", "coast"];
const HEAD_BYTES = 4096;

export class Missions extends EventTarget {
  /** @param {import("../editor/keeper.js").Keeper} keeper */
  constructor(keeper) {
    super();
    this.keeper = keeper;
    this.dialog = byId("missions");
    this.body = byId("missions-body");
    this.fault = el("p", { class: "fault", role: "alert" });
    byId("missions-open").addEventListener("click", () => this.show());
    this.listenForDrops();
  }

  async show() {
    this.fault.textContent = "";
    this.body.replaceChildren(el("p", {}, "…"));
    this.dialog.showModal();
    await this.list();
  }

  async list() {
    try {
      const [missions, examples] = await Promise.all([api.missions(), api.examples()]);
      this.body.replaceChildren(this.fault, this.starts(examples), this.files(), this.kept(missions));
    } catch (error) {
      this.body.replaceChildren(this.fault);
      this.fault.textContent = `Missions cannot be listed: ${messageOf(error)}`;
    }
  }

  starts(examples) {
    const first = (name) => (FIRST_EXAMPLES.includes(name) ? FIRST_EXAMPLES.indexOf(name) : FIRST_EXAMPLES.length);
    const sorted = [...examples].sort((a, b) => first(a.name) - first(b.name));
    const rows = sorted.map(({ name, title }) => {
      const open = button(name, () => this.openExample(name), { class: "link", "data-example": name });
      return el("li", {}, open, el("span", { class: "soft" }, ` ${title}`));
    });
    const shown = el("ul", { class: "plain" }, ...rows.slice(0, FIRST_EXAMPLES.length));
    const others = el("details", {}, el("summary", {}, `${Math.max(rows.length - FIRST_EXAMPLES.length, 0)} more examples`), el("ul", { class: "plain" }, ...rows.slice(FIRST_EXAMPLES.length)));
    const fresh = button("New, empty mission", () => this.leaveTo("new", null), { class: "primary" });
    return el("div", { class: "plain" }, el("div", {}, fresh), el("h3", {}, "Examples"), shown, others);
  }

  files() {
    const input = el("input", { type: "file", multiple: true, id: "mission-files", accept: ".yaml,.yml,.json,.geojson,.png,.pgm,.jpg,.tif,.tiff" });
    input.addEventListener("change", () => {
      const files = [...input.files];
      input.value = ""; // so that a file that was mended can be chosen again
      this.openFiles(files);
    });
    const save = button("Save this mission as a file", () => this.download(), { id: "save-yaml" });
    const words = "Mission (.yaml), GeoJSON, a ROS map (.yaml and its image together), or a plan (.rota.json); dropping them on the page does the same";
    return el("div", { class: "field" }, el("label", { for: "mission-files" }, words), input, el("div", { class: "row" }, save));
  }

  kept(missions) {
    const rows = missions.map((mission) => {
      const open = button(mission.name, () => this.open(mission.id), { class: "link grow" });
      const remove = button("Delete", () => this.remove(mission), { "aria-label": `Delete ${mission.name}`, class: "quiet" });
      const here = mission.id === this.keeper.id ? el("span", { class: "state" }, "open") : null;
      return el("li", { class: "row" }, open, here, el("span", { class: "soft" }, `${mission.planner ?? ""} · ${whenOf(mission.changed_at)}`), remove);
    });
    const nothing = el("p", { class: "soft" }, "None yet: what you draw is kept here.");
    return el("div", {}, el("h3", {}, "Kept missions"), rows.length === 0 ? nothing : el("ul", { class: "plain" }, ...rows));
  }

  async open(id) {
    try {
      await this.leaveTo("open", await api.mission(id));
    } catch (error) {
      this.fault.textContent = messageOf(error);
    }
  }

  async openExample(name) {
    try {
      const read = await api.example(name);
      await this.leaveTo("read", { document: read.document, warnings: read.warnings ?? [], source: { example: name, as: read.document } });
    } catch (error) {
      this.fault.textContent = messageOf(error);
    }
  }

  /** Reads files on the server; faults are told in the dialog. Plans among them go to the plans. */
  async openFiles(given) {
    const kinds = await Promise.all(given.map(isPlan));
    given.filter((_, k) => kinds[k]).forEach((plan) => this.dispatchEvent(new CustomEvent("plan", { detail: plan })));
    const files = given.filter((_, k) => !kinds[k]);
    if (files.length === 0) {
      if (given.length > 0) {
        this.dialog.close();
      }
      return;
    }
    this.fault.textContent = "Reading…";
    try {
      let read = await api.readMission(files);
      this.fault.textContent = "";
      if ((read.features ?? []).length > 0) {
        const roles = await chosenRoles(read.features);
        if (roles === null) {
          return;
        }
        read = await api.readMission(files, roles);
      }
      const source = read.upload === undefined || read.upload === null ? {} : { upload: read.upload };
      await this.leaveTo("read", { document: read.document, warnings: read.warnings ?? [], source });
    } catch (error) {
      const names = files.map((file) => file.name).join(", ");
      this.fault.textContent = `${names}: ${messageOf(error)}`;
      if (!this.dialog.open) {
        notifyError(error, names);
      }
    }
  }

  /** Saves what is open, then tells what to open instead. */
  async leaveTo(name, detail) {
    if (await this.keep()) {
      this.dialog.close();
      this.dispatchEvent(new CustomEvent(name, { detail }));
    }
  }

  /** Saves what is open; resolves to whether it may be left. */
  async keep() {
    if (this.keeper.state === "new" || this.keeper.state === "saved") {
      return true;
    }
    try {
      await this.keeper.flush();
      return true;
    } catch {
      return confirmed("The mission that is open could not be saved. Leave it, and lose its last changes?", "Leave it");
    }
  }

  async remove(mission) {
    if (!(await confirmed(`Delete the mission ${mission.name}? Its plans stay.`, "Delete"))) {
      return;
    }
    try {
      await api.deleteMission(mission.id);
      if (mission.id === this.keeper.id) {
        this.dispatchEvent(new CustomEvent("new"));
      }
      await this.list();
    } catch (error) {
      this.fault.textContent = messageOf(error);
    }
  }

  /** The mission as a file; with attachments it is a zip. */
  async download() {
    try {
      const id = await this.keeper.flush();
      const { attachments } = await api.mission(id);
      const { blob, name } = await api.download(api.missionFile(id, (attachments ?? []).length > 0 ? "zip" : "yaml"));
      saveBlob(blob, name);
    } catch (error) {
      this.fault.textContent = `It could not be saved as a file: ${messageOf(error)}`;
    }
  }

  listenForDrops() {
    document.addEventListener("dragover", (event) => {
      event.preventDefault();
      document.body.classList.add("dropping");
    });
    document.addEventListener("dragleave", () => document.body.classList.remove("dropping"));
    document.addEventListener("drop", (event) => {
      event.preventDefault();
      document.body.classList.remove("dropping");
      const files = [...(event.dataTransfer?.files ?? [])];
      if (files.length === 0) {
        notify("Only files can be dropped here.", { error: true });
      } else {
        this.openFiles(files);
      }
    });
  }
}

/** Whether a file is a plan: by its name, or by what it begins with. */
async function isPlan(file) {
  const head = file.name.toLowerCase().endsWith(".json") ? await file.slice(0, HEAD_BYTES).text().catch(() => "") : "";
  return file.name.endsWith(".rota.json") || head.includes('"rota_plan"');
}

/** A moment of the server in local words. */
export function whenOf(moment) {
  const date = new Date(typeof moment === "number" ? moment * 1000 : moment);
  return Number.isNaN(date.getTime()) ? "" : date.toLocaleString(undefined, { dateStyle: "short", timeStyle: "short" });
}
