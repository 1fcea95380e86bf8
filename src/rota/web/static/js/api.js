/**
 * The calls of the HTTP interface: the only module that asks the server for anything.
 *
 * @typedef {{field: string, path: (string|number)[], message: string}} Fault
 */

/** What the server refused, or that it could not be asked (status 0). */
export class ApiError extends Error {
  /**
   * @param {string} message
   * @param {number} status
   * @param {Fault[]} faults
   */
  constructor(message, status, faults = []) {
    super(message);
    this.name = "ApiError";
    this.status = status;
    this.faults = faults;
  }

  /** Whether the server could not be reached. */
  get isGone() {
    return this.status === 0;
  }
}

/** Told whether the server answers: "gone" and "back". */
export const connection = new EventTarget();
let reachable = true;

function tellReachable(now) {
  if (now !== reachable) {
    reachable = now;
    connection.dispatchEvent(new Event(now ? "back" : "gone"));
  }
}

const WORDS = {
  401: "The server asks for its token: open the address that it printed when it started.",
  403: "The server refuses requests from this address.",
  404: "It is not there any more.",
  413: "The file is too large for this server.",
  429: "Too many plans are waiting. Wait until one is done, or stop one.",
  503: "The process that worked on it ended. Try again.",
  507: "The server's disk is full.",
};

async function failure(response) {
  let told = null;
  try {
    told = (await response.json()).error;
  } catch {
    // an answer without JSON has only its status
  }
  const message = told?.message ?? WORDS[response.status] ?? `The server answered with status ${response.status}.`;
  return new ApiError(message, response.status, told?.faults ?? []);
}

async function ask(path, options = {}) {
  let response;
  try {
    response = await fetch(path, { credentials: "same-origin", ...options });
  } catch (error) {
    if (error instanceof DOMException && error.name === "AbortError") {
      throw error;
    }
    tellReachable(false);
    throw new ApiError("The server does not answer.", 0);
  }
  tellReachable(true);
  if (!response.ok) {
    throw await failure(response);
  }
  return response;
}

async function json(path, method = "GET", body = undefined, options = {}) {
  const headers = body === undefined ? {} : { "content-type": "application/json" };
  const sent = body === undefined ? undefined : JSON.stringify(body);
  const response = await ask(path, { method, headers, body: sent, ...options });
  return response.status === 204 ? null : response.json();
}

function form(files, name) {
  const data = new FormData();
  for (const file of files) {
    data.append(name, file, file.name);
  }
  return data;
}

const at = encodeURIComponent;
const TAB = crypto.getRandomValues(new Uint32Array(2)).join("-"); // of questions of one page the newest wins

/**
 * Server-sent events of an address. Returns a function that ends them.
 * @param {string} path
 * @param {Object<string, (data: any) => void>} listeners by the events' names
 * @param {() => void} onBroken when the server is gone
 */
function events(path, listeners, onBroken) {
  const source = new EventSource(path);
  for (const [name, listener] of Object.entries(listeners)) {
    source.addEventListener(name, (event) => listener(JSON.parse(/** @type {MessageEvent} */ (event).data)));
  }
  source.addEventListener("error", () => {
    // an end and a break look alike to an EventSource: the caller asks for the state
    source.close();
    onBroken();
  });
  return () => source.close();
}

export const api = {
  about: () => json("/api/about"),
  missionSchema: () => json("/api/schema/mission"),

  examples: () => json("/api/examples"),
  example: (name) => json(`/api/examples/${at(name)}`),

  readMission: (files, roles = null) => ask(`/api/missions/read${roles === null ? "" : `?as=${at(roles)}`}`, { method: "POST", body: form(files, "files") }).then((r) => r.json()),
  missions: () => json("/api/missions"),
  mission: (id) => json(`/api/missions/${at(id)}`),
  createMission: (body) => json("/api/missions", "POST", body),
  saveMission: (id, document, revision) => json(`/api/missions/${at(id)}`, "PUT", { document, revision }),
  deleteMission: (id) => json(`/api/missions/${at(id)}`, "DELETE"),
  missionFile: (id, suffix) => `/api/missions/${at(id)}/mission.${suffix}`,
  validate: (body, signal) => json(`/api/validate?tab=${TAB}`, "POST", body, { signal }),

  jobs: () => json("/api/jobs"),
  job: (id) => json(`/api/jobs/${at(id)}`),
  startJob: (body) => json("/api/jobs", "POST", body),
  stopJob: (id) => json(`/api/jobs/${at(id)}/stop`, "POST"),
  runAgain: (id) => json(`/api/jobs/${at(id)}/again`, "POST"),
  deleteJob: (id) => json(`/api/jobs/${at(id)}`, "DELETE"),
  jobEvents: (id, listeners, onBroken) => events(`/api/jobs/${at(id)}/events`, listeners, onBroken),

  plans: () => json("/api/plans"),
  plan: (id) => json(`/api/plans/${at(id)}`),
  uploadPlan: (file) => ask("/api/plans", { method: "POST", body: form([file], "file") }).then((r) => r.json()),
  replan: (id, body) => json(`/api/plans/${at(id)}/replan`, "POST", body),
  deletePlan: (id) => json(`/api/plans/${at(id)}`, "DELETE"),
  playback: (id, signal) => ask(`/api/plans/${at(id)}/playback`, { signal }).then((r) => r.arrayBuffer()),

  watch: (id) => json(`/api/watches/${at(id)}`),
  startWatch: (body) => json("/api/watches", "POST", body),
  stopWatch: (id) => json(`/api/watches/${at(id)}/stop`, "POST"),
  watchEvents: (id, listeners, onBroken) => events(`/api/watches/${at(id)}/events`, listeners, onBroken),

  /** A download's bytes and name; the server names files, without paths. */
  download: async (path) => {
    const response = await ask(path);
    const told = /filename="?([^";]+)"?/.exec(response.headers.get("content-disposition") ?? "");
    return { blob: await response.blob(), name: told === null ? (path.split("?")[0].split("/").pop() ?? "file") : told[1] };
  },
  planFile: (id, name, query = {}) => {
    const given = Object.entries(query).filter(([, value]) => value !== "" && value !== null && value !== undefined);
    const search = new URLSearchParams(given.map(([key, value]) => [key, String(value)])).toString();
    return `/api/plans/${at(id)}/${name}${search === "" ? "" : `?${search}`}`;
  },
};
