/** The plan that is watched: fetches it and gives it to the player, the newest wish wins. */

import { api } from "../api.js";
import { Frame, sameOrigin } from "../editor/frame.js";
import { placeInWords } from "../editor/places.js";
import { toDegrees, toMetres } from "../geodesy.js";
import { messageOf } from "../notices.js";

const L = window.L;
const SHEER = 0.7; // colours above a map's tiles
const NEAR_M = 20000; // plans so near to the mission on the map are shown where they lie

export class Watching {
  /**
   * @param {import("../editor/map.js").MissionMap} missionMap
   * @param {HTMLElement} controls
   * @param {HTMLElement} title
   */
  constructor(missionMap, controls, title) {
    this.missionMap = missionMap;
    this.controls = controls;
    this.title = title;
    this.player = null;
    this.shown = null; // the plan's id
    this.frame = null; // of the editor
    this.running = null;
    this.notice = null; // above the player
    this.replan = async () => undefined; // asked for a plan that takes over from the one that is shown
    this.tell(false);
  }

  /** What stands here while there is no plan; a mission that is being planned will have one. */
  tell(isPlanning) {
    this.emptyText = isPlanning ? "Planning goes on: the first plan plays here as soon as it is found." : "There is no plan yet: make one in step 2.";
    this.describe(this.notice);
  }

  /** Tells what is to be known of the plan above its player. */
  describe(note) {
    this.notice = note;
    this.controls.toggleAttribute("data-stale", note !== null && this.player !== null);
    if (this.player === null) {
      this.title.replaceChildren(this.running === null ? this.emptyText : "…");
    } else {
      this.title.replaceChildren(...(note === null ? [] : [note]));
    }
  }

  /**
   * Shows a plan; `fit` moves the view to it. Resolves to whether it is shown.
   * @param {string} id
   * @param {{fit: boolean}} options
   */
  async show(id, { fit }) {
    if (id === this.shown && this.player !== null) {
      return true;
    }
    this.running?.abort();
    const running = new AbortController();
    this.running = running;
    this.describe(this.notice);
    try {
      // the player is loaded when there is something to play
      const [buffer, { Playback }, { Player }] = await Promise.all([
        api.playback(id, running.signal),
        import("../player/playback.js"),
        import("../player/player.js"),
      ]);
      if (running !== this.running) {
        return false;
      }
      this.play(Player, Playback.decode(buffer), fit);
      this.shown = id;
      return true;
    } catch (error) {
      if (running === this.running && !(error instanceof DOMException)) {
        this.title.textContent = `The plan cannot be shown: ${messageOf(error)}`;
      }
      return false;
    }
  }

  play(Player, playback, fit) {
    const origin = playback.header.mission.origin ?? null;
    const key = JSON.stringify([origin, this.frame.origin, this.frame.tiled]);
    if (this.player !== null && key === this.playedIn) {
      this.player.replace(playback);
    } else {
      this.player?.destroy();
      this.playedIn = key;
      const place = this.placing(origin);
      this.player = new Player({ playback, map: this.missionMap.map, controls: this.controls, project: (x, y) => L.latLng(place(x, y)), ...this.words(origin), replan: (change) => this.replan(this.shown, change), opacity: this.frame.tiled ? SHEER : 1 });
    }
    this.describe(this.notice);
    if (fit) {
      const [x0, y0, x1, y1] = playback.header.bounds_m;
      const place = this.placing(origin);
      this.missionMap.fit([place(x0, y0), place(x1, y1)]);
    }
  }

  /** How places of a plan are told: in degrees where its mission is in degrees. */
  words(origin) {
    if (origin === null || this.frame.coordinates !== "wgs84") {
      return {};
    }
    const where = (x, y) => {
      const [lon, lat] = toDegrees(origin, x, y);
      return placeInWords(lat, lon);
    };
    return { where };
  }

  /** Where the plan's metres lie on the map: in the editor's frame, or, far away, as they are. */
  placing(origin) {
    const { frame } = this;
    const near = origin !== null && frame.origin !== null && Math.hypot(...toMetres(frame.origin, origin.lon, origin.lat)) < NEAR_M;
    if (frame.tiled || near || sameOrigin(frame.origin, origin)) {
      return (x, y) => frame.metresToMap(x, y, origin);
    }
    const own = new Frame("metres", origin, false);
    return (x, y) => own.metresToMap(x, y, origin);
  }

  /** Says something once, where the player is. */
  say(text) {
    this.player?.panel.say(text);
  }

  stopLoading() {
    this.running?.abort();
    this.running = null;
  }

  /** Takes the plan off the map. */
  clear() {
    this.stopLoading();
    this.player?.destroy();
    this.player = null;
    this.shown = null;
    this.describe(null);
  }
}
