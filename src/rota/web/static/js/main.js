/** Starts the page: the editor, planning, watching, downloads, and what the address says. */

import { Address } from "./address.js";
import { api } from "./api.js";
import { byId, el } from "./dom.js";
import { Editor, isOfPlanner } from "./editor/editor.js";
import { showSaved } from "./editor/keeper.js";
import { MissionMap } from "./editor/map.js";
import { newMission } from "./editor/new_mission.js";
import { messageOf, notify, startBanner } from "./notices.js";
import { Tabs } from "./tabs.js";
import { startTheme } from "./theme.js";
import { Downloads } from "./work/downloads.js";
import { Jobs } from "./work/jobs.js";
import { Live } from "./work/live.js";
import { Missions } from "./work/missions.js";
import { Plans } from "./work/plans.js";
import { Readiness } from "./work/readiness.js";
import { isStale, robotsText, staleNote } from "./work/stale.js";
import { Watching } from "./work/watching.js";

class Page {
  constructor(missionMap, about, schema) {
    this.missionMap = missionMap;
    missionMap.useTiles(about.tile_url ?? null, about.tile_attribution ?? "");
    this.editor = new Editor(this.missionMap, { planners: about.planners.map((planner) => planner.name), schema });
    this.tabs = new Tabs(byId("tabs"));
    this.address = new Address();
    this.plans = new Plans(byId("plans"));
    this.jobs = new Jobs(byId("jobs"), byId("earlier"), this.editor.keeper);
    const readiness = new Readiness(byId("plan-now"), this.editor);
    this.jobs.mayPlan = () => readiness.mayPlan();
    this.missions = new Missions(this.editor.keeper);
    this.downloads = new Downloads(byId("downloads"), about.formats);
    this.watching = new Watching(this.missionMap, byId("player-controls"), byId("watching"));
    this.live = new Live(byId("live"), about.links ?? [], () => ({ plan: this.watching.shown, player: this.watching.player }));
    this.plan = null; // the id of the plan that is chosen
    this.better = null; // the id of the best plan so far, while a job of this mission runs
    this.soFar = null; // that plan as lists show it
    this.replanned = null; // the job that replans, and the plan that it goes on from
    this.watching.replan = (plan, change) => this.replan(plan, change);
    this.listen();
  }

  listen() {
    const { editor, jobs, missionMap, missions, plans } = this;
    editor.keeper.addEventListener("state", () => this.keeperMoved());
    byId("take-theirs").addEventListener("click", () => this.reload());
    byId("keep-mine").addEventListener("click", () => editor.keeper.keepMine().catch(() => undefined));
    window.addEventListener("focus", () => this.lookElsewhere());
    document.addEventListener("visibilitychange", () => document.visibilityState === "visible" && this.lookElsewhere());
    showSaved(editor.keeper, byId("saved"), messageOf);
    editor.keeper.addEventListener("named", () => {
      this.writeAddress();
      plans.refresh(editor.keeper.id);
    });
    editor.addEventListener("goto", (event) => this.tabs.show(isOfPlanner(event.detail) ? "plan" : "edit"));
    editor.addEventListener("update", () => this.titleShown());
    byId("go-plan").addEventListener("click", () => this.go("plan"));
    missions.addEventListener("new", () => this.open(newMission("mission", missionMap.hasTiles), (keeper) => keeper.fresh()));
    missions.addEventListener("open", (event) => this.openKept(event.detail));
    missions.addEventListener("read", (event) => this.openRead(event.detail));
    missions.addEventListener("plan", (event) => {
      this.tabs.show("plan");
      plans.add(event.detail);
    });
    jobs.addEventListener("started", (event) => event.detail.change === null && this.choosePlan(null));
    jobs.addEventListener("better", (event) => this.showBetter(event.detail));
    jobs.addEventListener("ended", (event) => this.jobEnded(event.detail));
    jobs.addEventListener("outdated", () => this.lookElsewhere());
    jobs.addEventListener("listed", () => this.isPlanned !== plans.isPlanning && this.tellPlanning());
    jobs.addEventListener("watch", (event) => this.watch(event.detail));
    plans.addEventListener("watch", (event) => this.watch(event.detail));
    plans.addEventListener("listed", () => this.tellPlan());
    plans.addEventListener("deleting", (event) => event.detail === this.plan && this.watching.stopLoading());
    plans.addEventListener("deleted", (event) => event.detail === this.plan && this.choosePlan(null));
    this.tabs.addEventListener("change", () => this.tabShown());
    window.addEventListener("hashchange", () => this.readAddress());
  }

  titleShown() {
    const name = byId("mission-name");
    name.title = name.textContent;
    document.title = `${name.textContent || "Rota"} – Rota`;
  }

  /** Shows a tab and moves there. */
  go(tab) {
    this.tabs.show(tab);
    byId(`tab-${tab}`).focus();
  }

  open(document, keep) {
    this.choosePlan(null);
    this.jobs.forget();
    this.editor.load(document, keep);
    this.tabs.show("edit");
    this.writeAddress();
    this.showPlans();
  }

  openKept(mission) {
    this.open(mission.document, (keeper) => keeper.opened(mission.id, mission.document, mission.revision));
  }

  /** Lists the plans of the mission that was opened, and shows the best of them, or of the job that plans it now. */
  async showPlans() {
    const { id, opening } = this.editor.keeper;
    await this.plans.refresh(id);
    if (opening !== this.editor.keeper.opening || this.plan !== null) {
      return;
    }
    this.jobs.tellAgain();
    if (this.jobs.activeOf(id) === null && this.plans.best !== null) {
      await this.showChosen(this.plans.best.id);
    }
  }

  /** The mission as it is on the server, where it was changed elsewhere; resolves to whether it is shown. */
  async reload() {
    const { keeper } = this.editor;
    const { opening, state } = keeper;
    try {
      const mission = await api.mission(keeper.id);
      if (opening === keeper.opening && state === keeper.state) {
        this.editor.load(mission.document, () => keeper.opened(mission.id, mission.document, mission.revision));
        await this.plans.refresh();
        return true;
      }
    } catch (error) {
      notify(`The mission cannot be loaded again: ${messageOf(error)}`, { error: true });
    }
    return false;
  }

  /** Somebody comes back to this page: another may have changed the mission meanwhile, where all is saved here. */
  async lookElsewhere() {
    const { keeper } = this.editor;
    const { id, revision } = keeper;
    if (id === null || keeper.state !== "saved") {
      return;
    }
    const found = (await api.missions().catch(() => [])).find((mission) => mission.id === id);
    if (found !== undefined && found.revision > revision && keeper.id === id && keeper.revision === revision && keeper.state === "saved") {
      if (await this.reload()) {
        notify("The mission was changed elsewhere; it is shown as it is now.");
      }
    }
  }

  keeperMoved() {
    if (this.editor.keeper.state !== "saved") {
      this.plans.doubt();
    } else if (this.plans.unsure) {
      this.plans.refresh();
    }
  }

  /** A mission from files or an example: it is kept at once, so that its files are with it. */
  openRead({ document, warnings, source }) {
    this.open(document, (keeper) => keeper.fresh(source));
    this.editor.keeper.flush().catch(() => undefined);
    warnings.forEach((warning) => notify(warning.message ?? warning));
  }

  tabShown() {
    const { current } = this.tabs;
    const watches = current === "watch" || current === "plan" || current === "take";
    this.editor.drawing.stop();
    this.editor.showUndo();
    if (this.editor.keeper.state === "unsaved") {
      this.editor.keeper.flush().catch(() => undefined); // plans are told apart from the mission as it is now
    }
    if (!watches) {
      this.watching.clear();
    } else if (this.plan !== null || this.better !== null) {
      this.showPlan(this.plan ?? this.better, false);
    }
    this.lookOn();
    this.writeAddress();
  }

  /** Shapes step back while a plan with its own ground is shown. */
  lookOn() {
    this.editor.layers.hold("looking on", this.tabs.current !== "edit");
    this.editor.layers.hide(this.watching.player !== null);
    this.live.showPlan();
  }

  async showPlan(id, fit) {
    this.watching.frame = this.editor.frame;
    await this.watching.show(id, { fit });
    this.lookOn();
  }

  /** The plan that is watched and taken away; null for none. */
  choosePlan(id) {
    this.plan = id;
    this.better = null;
    this.soFar = null;
    this.plans.choose(id);
    if (id === null) {
      this.watching.clear();
      this.lookOn();
    }
    this.tellPlanning();
  }

  /** Chooses a plan, and shows it where plans are looked at. */
  async showChosen(id) {
    this.choosePlan(id);
    this.writeAddress();
    if (this.tabs.current !== "edit") {
      await this.showPlan(id, this.watching.player === null);
    }
  }

  /** Tells of the plan that is chosen, or the best so far, whether it holds. */
  tellPlan() {
    const { plans } = this;
    const found = plans.find(this.plan) ?? this.soFar;
    const unsure = plans.unsure && found?.mission === plans.mission;
    this.watching.describe(staleNote(found, unsure));
    byId("caption").textContent = captionOf(found, { unsure, isPlanning: plans.isPlanning });
    this.downloads.show(found, { unsure, isPlanning: plans.isPlanning });
  }

  /** Whether a job plans the mission that is open, or will. */
  get isPlanned() {
    return this.jobs.activeOf(this.editor.keeper.id) !== null;
  }

  /** Tells of the job that plans the mission which is open, if there is one. */
  tellPlanning() {
    const isPlanning = this.isPlanned;
    this.plans.showPlanning(isPlanning, this.soFar);
    this.watching.tell(isPlanning);
    this.tellPlan();
  }

  /** Watches a plan; null: the best so far, whichever that is. */
  async watch(id) {
    if (id === null) {
      this.go("watch");
      return;
    }
    this.choosePlan(id);
    this.tabs.show("watch");
    this.writeAddress();
    await this.showPlan(id, true);
  }

  /** Replans from a moment of a plan on; that plan stays on the map until another one can take over. */
  async replan(plan, change) {
    try {
      const job = await this.jobs.replan(plan, change);
      this.replanned = { job: job.id, plan };
      this.watching.say("Replanning…");
    } catch (error) {
      this.watching.say(`It could not be replanned: ${messageOf(error)}`);
    }
  }

  /** Whether a job's plans are shown as they come: it replans what is shown, or plans the mission, of which none is. */
  shows(job) {
    return job.id === this.replanned?.job
      ? this.plan === this.replanned.plan || (this.plan === null && this.better !== null)
      : this.plan === null && job.mission === this.editor.keeper.id && job.change === null;
  }

  async showBetter({ job, plan }) {
    if (!this.shows(job)) {
      return;
    }
    if (this.plan !== null) {
      this.plan = null;
      this.plans.choose(null);
    }
    this.better = plan;
    // what there is so far stands among the plans, and can be taken away too
    const told = api.plan(plan).then((found) => {
      if (this.better === plan) {
        this.soFar = { ...found, partial: true };
        this.tellPlanning();
      }
    });
    told.catch(() => undefined);
    if (this.tabs.current !== "edit") {
      await this.showPlan(plan, this.watching.player === null);
    }
  }

  async jobEnded(job) {
    await this.plans.refresh();
    if (job.id === this.replanned?.job && job.plan === null) {
      this.watching.say(`It could not be replanned: ${job.message ?? job.state}`);
    }
    if (job.plan !== null && this.shows(job)) {
      await this.showChosen(job.plan);
    } else {
      this.tellPlanning();
    }
  }

  writeAddress() {
    this.address.write({ mission: this.editor.keeper.id, tab: this.tabs.current, plan: this.plan });
  }

  readAddress() {
    return this.address.follow((shown) => this.show(shown));
  }

  /** Shows a mission, a tab and a plan; without a mission the one changed last. */
  async show({ mission, plan, tab }) {
    try {
      const kept = mission ?? (await api.missions())[0]?.id ?? null;
      if (kept !== null && kept !== this.editor.keeper.id) {
        await this.missions.keep();
        this.openKept(await api.mission(kept));
      }
    } catch (error) {
      notify(`The mission of the address cannot be opened: ${messageOf(error)}`, { error: true });
    }
    await Promise.all([plan === null ? null : this.plans.refresh(this.editor.keeper.id), this.jobs.refresh()]);
    if (plan !== null && this.plans.find(plan) !== null) {
      this.choosePlan(plan);
    }
    if (tab !== null && ["edit", "plan", "watch", "take"].includes(tab)) {
      this.tabs.show(tab);
    }
    if (plan !== null && this.plan === plan && this.tabs.current !== "edit") {
      await this.showPlan(plan, true);
    } else if (this.plan === null) {
      await this.showPlans();
    }
    this.writeAddress();
  }
}

/** What is on the map, in a line. */
function captionOf(plan, { unsure, isPlanning }) {
  if (plan === null) {
    return isPlanning ? "The mission; it is being planned" : "The mission, without a plan";
  }
  const verdict = unsure ? "" : isStale(plan) ? ", stale" : `, ${plan.verdict}`;
  return `${plan.partial ? "The best plan so far" : "The plan"} of ${plan.name}: ${robotsText(plan)}${verdict}`;
}

async function start() {
  startTheme();
  startBanner();
  const missionMap = new MissionMap(byId("map"));
  try {
    const [about, schema] = await Promise.all([api.about(), api.missionSchema()]);
    const page = new Page(missionMap, about, schema);
    byId("missions-open").disabled = false;
    byId("go-plan").disabled = false;
    await page.readAddress();
    document.body.dataset.ready = "true";
  } catch (error) {
    byId("verdict").replaceChildren(el("div", { class: "verdict-fault" }, `The page could not start: ${messageOf(error)}`));
  }
}

start();
