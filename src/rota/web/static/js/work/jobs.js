/** Planning: starts jobs, follows the newest one live, and lists the others. */

import { api, ApiError, connection } from "../api.js";
import { button, el } from "../dom.js";
import { textInWords } from "../editor/words.js";
import { confirmed, messageOf, notify, notifyError } from "../notices.js";
import { changeText, robotsText } from "./stale.js";

const POLL_MS = 2000;
const TICK_MS = 1000;
const REPLAN_S = 20; // of the search for better plans that take over
const TOLD = "rota-interrupted"; // the newest job of which was told that it was interrupted
const ACTIVE = ["queued", "running"];
const WORDS = {
  queued: "waiting",
  running: "planning",
  done: "done",
  no_plan: "no plan found",
  failed: "failed",
  stopped: "stopped",
  interrupted: "interrupted",
};

export class Jobs extends EventTarget {
  /**
   * @param {HTMLElement} section for the button, what is planned now and what went wrong last
   * @param {HTMLElement} earlier for the jobs before
   * @param {import("../editor/keeper.js").Keeper} keeper
   */
  constructor(section, earlier, keeper) {
    super();
    this.keeper = keeper;
    this.mayPlan = async () => true; // asked before a mission is planned
    this.jobs = [];
    this.followed = null; // the id of the job whose events are read
    this.bestPlan = null; // the id of the best plan so far that was told last
    this.endEvents = () => undefined;
    this.announced = "";
    this.seed = el("input", { type: "number", min: "0", step: "1", value: "0", id: "seed" });
    this.limit = el("input", { type: "number", min: "1", step: "any", placeholder: "none", id: "time-limit" });
    this.plan = button("Plan", () => this.start(), { class: "primary", id: "plan-now" });
    this.fault = el("p", { class: "fault", role: "alert" });
    this.list = el("ul", { class: "plain" });
    this.words = el("p", { class: "unseen", "aria-live": "polite", id: "job-words" });
    this.earlier = el("ul", { class: "plain" });
    this.earlierHead = el("summary", {}, "");
    this.earlierBox = el("details", { class: "earlier" }, this.earlierHead, this.earlier);
    section.append(this.form(), this.fault, this.words, this.list);
    earlier.append(this.earlierBox);
    connection.addEventListener("back", () => this.refresh());
    window.setInterval(() => this.jobs.some(isActive) && this.refresh(), POLL_MS);
    window.setInterval(() => this.tick(), TICK_MS);
  }

  /** Time goes on also while nothing is told. */
  tick() {
    for (const words of this.list.querySelectorAll("[data-job]")) {
      const job = this.jobs.find((other) => other.id === words.getAttribute("data-job"));
      if (job !== undefined && isActive(job)) {
        words.textContent = describe(job);
      }
    }
  }

  /** The job that plans a mission now or next; null for none. */
  activeOf(mission) {
    const own = this.jobs.filter((job) => isActive(job) && mission !== null && job.mission === mission);
    return own.find((job) => job.state === "running") ?? own[0] ?? null;
  }

  /** Another mission is open: what was refused before is not about it. */
  forget() {
    this.fault.textContent = "";
  }

  /** Tells once more of the best plan so far, since another mission is open. */
  tellAgain() {
    this.bestPlan = null;
    this.tellBetter(this.jobs.find((job) => job.id === this.followed));
  }

  form() {
    const field = (label, input) => el("div", { class: "field" }, el("label", { for: input.id }, label), input);
    const help = el("p", { class: "field-help" }, "The same seed gives the same plan. When the time is over, the best plan so far is kept.");
    const fields = el("div", { class: "fields" }, field("Seed", this.seed), field("Time limit (s)", this.limit));
    return el("div", { class: "plain" }, fields, help, this.plan);
  }

  /** Saves the mission, then plans it. */
  async start() {
    this.fault.textContent = "";
    this.plan.disabled = true;
    try {
      if (!(await this.mayPlan())) {
        return;
      }
      const mission = await this.keeper.flush();
      const body = { mission, revision: this.keeper.revision, seed: Number(this.seed.value) };
      const limit = this.limit.value === "" ? {} : { time_limit_s: Number(this.limit.value) };
      this.followNew(await api.startJob({ ...body, ...limit }));
    } catch (error) {
      this.fault.textContent = `Planning could not begin: ${messageOf(error)}`;
      if (error instanceof ApiError && error.status === 409) {
        this.dispatchEvent(new Event("outdated"));
      }
    } finally {
      this.plan.disabled = false;
    }
  }

  followNew(job) {
    this.put(job);
    this.follow(job.id);
    this.dispatchEvent(new CustomEvent("started", { detail: job }));
  }

  /** Replans from a moment of a plan on; resolves to the job. */
  async replan(plan, change) {
    const job = await api.replan(plan, { ...change, time_limit_s: REPLAN_S });
    this.followNew(job);
    return job;
  }

  /** Reads a job's events until it ends. */
  follow(id) {
    this.endEvents();
    this.followed = id;
    this.tellBetter(this.jobs.find((job) => job.id === id));
    this.endEvents = api.jobEvents(id, { job: (job) => this.put(job) }, () => {
      this.followed = null; // the events end with the job, and break off with the server: the list tells which
      this.refresh();
    });
  }

  /** Tells of a better plan of the job that is followed, each one once. */
  tellBetter(job) {
    const plan = job?.best?.plan ?? null;
    if (plan !== null && plan !== this.bestPlan && job.id === this.followed) {
      this.bestPlan = plan;
      this.dispatchEvent(new CustomEvent("better", { detail: { job, plan } }));
    }
  }

  async refresh() {
    try {
      const jobs = await api.jobs();
      const before = new Map(this.jobs.map((job) => [job.id, job]));
      this.jobs = jobs.map(received);
      this.draw();
      this.tellInterrupted();
      jobs.filter((job) => !isActive(job) && before.has(job.id) && isActive(before.get(job.id))).forEach((job) => this.ended(job));
      const waiting = jobs.find((job) => job.state === "running") ?? jobs.find(isActive);
      const followed = jobs.find((job) => job.id === this.followed);
      if (waiting !== undefined && (followed === undefined || !isActive(followed))) {
        this.follow(waiting.id);
      }
    } catch (error) {
      if (!(error instanceof ApiError && error.isGone)) {
        notifyError(error, "Jobs cannot be listed");
      }
    }
  }

  /** Tells once that the newest job was interrupted, however long ago. */
  tellInterrupted() {
    const [newest] = this.jobs;
    if (newest?.state === "interrupted" && window.localStorage.getItem(TOLD) !== newest.id) {
      window.localStorage.setItem(TOLD, newest.id);
      const kept = newest.plan === null ? "There was no plan yet." : "The best plan until then is kept.";
      notify(`Planning of ${newest.mission_name} was interrupted when the server ended. ${kept} Run it again in step 2.`, { error: true });
    }
  }

  put(told) {
    const job = received(told);
    const before = this.jobs.find((other) => other.id === job.id);
    this.jobs = before === undefined ? [job, ...this.jobs] : this.jobs.map((other) => (other.id === job.id ? job : other));
    this.draw();
    this.tellBetter(job);
    if (before !== undefined && isActive(before) && !isActive(job)) {
      this.ended(job);
    }
  }

  ended(job) {
    if (job.id === this.followed) {
      this.endEvents();
      this.followed = null;
      this.refresh();
    }
    this.dispatchEvent(new CustomEvent("ended", { detail: job }));
  }

  draw() {
    const active = this.jobs.find((job) => job.id === this.followed && isActive(job));
    this.announce(active);
    const focused = document.activeElement?.getAttribute("data-mark");
    const isShown = (job, k) => isActive(job) || (k === 0 && (job.plan === null || job.state === "interrupted"));
    const shown = this.jobs.filter(isShown);
    const others = this.jobs.filter((job, k) => !isShown(job, k));
    this.list.replaceChildren(...shown.map((job) => this.row(job)));
    this.earlier.replaceChildren(...others.map((job) => this.row(job)));
    this.earlierHead.textContent = `Earlier jobs (${others.length})`;
    this.earlierBox.hidden = others.length === 0;
    this.dispatchEvent(new Event("listed"));
    if (focused) {
      [this.list, this.earlier].map((list) => list.querySelector(`[data-mark="${CSS.escape(focused)}"]`)).find(Boolean)?.focus();
    }
  }

  /** Tells progress in words to who listens, by tenths so that it does not chatter. */
  announce(job) {
    const tenths = job === undefined ? "" : `${job.state} ${Math.floor((job.progress?.fraction ?? 0) * 10)} ${job.best?.robots ?? ""}`;
    if (tenths === this.announced) {
      return;
    }
    this.announced = tenths;
    this.words.textContent = job === undefined ? "" : describe(job);
  }

  row(job) {
    const state = el("span", { class: `state state-${job.state}` }, WORDS[job.state] ?? job.state);
    const head = el("div", { class: "row" }, el("strong", { class: "grow" }, job.mission_name ?? ""), state);
    const facts = [job.planner, job.effort, `seed ${job.seed}`, changeText(job)];
    const parts = [head, el("p", { class: "soft" }, facts.filter(Boolean).join(" · "))];
    if (isActive(job)) {
      const fraction = job.progress?.fraction;
      const bar = el("progress", { max: "1", "aria-label": `Progress of ${job.mission_name}` });
      if (job.state === "running" && typeof fraction === "number" && fraction > 0) {
        bar.value = fraction;
      }
      parts.push(bar, el("p", { "data-job": job.id }, describe(job)));
    } else if (job.message) {
      parts.push(el("p", { class: job.state === "failed" || job.state === "no_plan" ? "fault" : "soft" }, textInWords(job.message)));
    }
    parts.push(el("div", { class: "row" }, ...this.buttons(job)));
    return el("li", { class: "card" }, ...parts);
  }

  buttons(job) {
    const named = (name) => ({ "aria-label": `${name}: ${job.mission_name}, seed ${job.seed}`, "data-mark": `${name} ${job.id}` });
    if (isActive(job)) {
      return [button(job.best === null ? "Stop" : "Stop and keep the best", () => this.act(() => api.stopJob(job.id), "It could not be stopped"), named("Stop"))];
    }
    const again = button("Run again", () => this.again(job), named("Run again"));
    const remove = button("Delete", () => this.remove(job), { ...named("Delete"), class: "quiet" });
    return job.plan === null ? [again, remove] : [button("Watch", () => this.dispatchEvent(new CustomEvent("watch", { detail: job.plan })), named("Watch")), again, remove];
  }

  async again(job) {
    await this.act(async () => this.followNew(await api.runAgain(job.id)), "It could not be run again");
  }

  async remove(job) {
    if (await confirmed("Delete this job from the list? Its plan stays.", "Delete")) {
      await this.act(() => api.deleteJob(job.id), "The job could not be deleted");
    }
  }

  async act(call, doing) {
    this.fault.textContent = "";
    try {
      await call();
      await this.refresh();
    } catch (error) {
      this.fault.textContent = `${doing}: ${messageOf(error)}`;
    }
  }
}

/** A job with the moment when it was told. */
function received(job) {
  return { ...job, at_ms: performance.now() };
}

function isActive(job) {
  return ACTIVE.includes(job.state);
}

/** A running job in a sentence. */
function describe(job) {
  if (job.state === "queued") {
    const place = job.place_in_queue;
    return typeof place === "number" && place > 1 ? `Waiting: number ${place} in the queue.` : "Waiting: next in the queue.";
  }
  const { progress } = job;
  const share = progress.fraction > 0 ? `${Math.floor(progress.fraction * 100)} %` : "";
  const best = job.best === null ? "no plan yet" : `best so far ${robotsText(job.best)}${job.best.met === false ? " (periods not met)" : ""}`;
  const since_s = (performance.now() - job.at_ms) / 1000;
  const elapsed_s = progress.elapsed_s + since_s;
  return [share, progress.doing || "starting", spanText(elapsed_s), leftText(progress, since_s), best].filter(Boolean).join(" · ");
}

function spanText(seconds) {
  return seconds < 99.5 ? `${Math.round(seconds)} s` : `${Math.floor(seconds / 60)} min ${Math.floor(seconds % 60)} s`;
}

/** About how long it goes on yet; nothing while it has told too little of itself. */
function leftText({ left_s, elapsed_s }, since_s) {
  if (left_s === null) {
    return elapsed_s + since_s < 3 ? "" : "time left unknown";
  }
  const left = left_s - since_s;
  if (left < 10) {
    return "a few seconds left";
  }
  return left < 90 ? `about ${Math.ceil(left / 10) * 10} s left` : `about ${Math.round(left / 60)} min left`;
}
