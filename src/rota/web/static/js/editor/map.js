/** The Leaflet map: metres on CRS.Simple with a grid, or tiles in Web Mercator where somebody has them. */

import { el } from "../dom.js";
import { GridLines } from "./grid.js";

const L = window.L;

const METRES_VIEW = [
  [-20, -30],
  [200, 330],
];
const WORLD = { centre: [25, 10], zoom: 2 };
const LAST_VIEW = "rota-view"; // where somebody looked last, under which name the browser keeps it
const NEAR_ZOOM = 16; // to which the view goes for a place, unless it is nearer already
const NEAR_PX_M = 2; // as near, without tiles
const FIT = { padding: [24, 24], maxZoom: 6, animate: false };

export class MissionMap {
  /** @param {HTMLElement} element */
  constructor(element) {
    // Geoman looks after layers that ask for it, so that it leaves the player's alone
    L.PM.setOptIn(true);
    // handles of corners have no names to be read out: the keyboard has the table of coordinates
    L.Marker.mergeOptions({ keyboard: false });
    this.tiles = null;
    this.tiled = false;
    this.map = L.map(element, {
      crs: L.CRS.Simple,
      pmIgnore: false,
      minZoom: -8,
      maxZoom: 8,
      zoomSnap: 0.25,
      wheelPxPerZoomLevel: 120,
      attributionControl: false,
      doubleClickZoom: false,
    });
    this.grid = new GridLines();
    L.control.scale({ imperial: false, maxWidth: 140 }).addTo(this.map);
    this.map.fitBounds(METRES_VIEW, { animate: false });
    this.grid.addTo(this.map);
    new ResizeObserver(() => this.map.invalidateSize({ animate: false })).observe(element);
  }

  /** Where tiles come from, for missions that lie on the globe, and the words beside them; null for nowhere. */
  useTiles(url, attribution) {
    // servers of tiles may refuse who does not say what page asks; more than its origin is not said
    this.tiles = url === null ? null : L.tileLayer(url, { maxZoom: 22, maxNativeZoom: 19, referrerPolicy: "strict-origin-when-cross-origin" });
    this.attribution = attributionControl(attribution);
    this.map.on("moveend", () => this.tiled && keepView(this.map));
  }

  get hasTiles() {
    return this.tiles !== null;
  }

  /** Shows places as a frame has them; the caller draws its layers anew and fits the view where this returns true. */
  useFrame(frame) {
    const tiled = frame.tiled && this.tiles !== null;
    if (tiled === this.tiled) {
      return false;
    }
    this.tiled = tiled;
    this.map.options.crs = tiled ? L.CRS.EPSG3857 : L.CRS.Simple;
    this.map.setMinZoom(tiled ? 1 : -8);
    this.map.setMaxZoom(tiled ? 22 : 8);
    if (tiled) {
      this.grid.remove();
      const { centre, zoom } = frame.isPlaced ? { centre: [frame.origin.lat, frame.origin.lon], zoom: 15 } : lastView();
      this.map.setView(centre, zoom, { animate: false });
      this.tiles.addTo(this.map);
      this.attribution.addTo(this.map);
    } else {
      this.tiles.remove();
      this.attribution.remove();
      this.map.fitBounds(METRES_VIEW, { animate: false });
      this.grid.addTo(this.map);
    }
    return true;
  }

  /** Shows a place on the map from near. */
  look(place) {
    const near = this.tiled ? NEAR_ZOOM : Math.log2(NEAR_PX_M);
    this.map.setView(place, Math.max(this.map.getZoom(), near), { animate: false });
    const ring = L.circleMarker(place, { radius: 14, className: "place-mark", interactive: false, pmIgnore: true }).addTo(this.map);
    window.setTimeout(() => ring.remove(), 4000);
  }

  /** Fits the view to places on the map; the start's view without any. */
  fit(places) {
    if (places.length === 0) {
      if (!this.tiled) {
        this.map.fitBounds(METRES_VIEW, { animate: false });
      }
      return;
    }
    const bounds = L.latLngBounds(places);
    if (bounds.getNorthEast().equals(bounds.getSouthWest())) {
      this.map.setView(bounds.getCenter(), this.map.getZoom(), { animate: false });
    } else {
      this.map.fitBounds(bounds, this.tiled ? { ...FIT, maxZoom: 20 } : FIT);
    }
  }
}

/** The words that makers of tiles ask for; OpenStreetMap's lead to its terms. */
function attributionControl(text) {
  const control = L.control({ position: "bottomleft" });
  control.onAdd = () => {
    const its = text.includes("OpenStreetMap");
    const words = its ? el("a", { href: "https://www.openstreetmap.org/copyright", target: "_blank", rel: "noopener" }, text) : text;
    return el("div", { class: "attribution", hidden: text === "" }, words);
  };
  return control;
}

function keepView(map) {
  const { lat, lng } = map.getCenter();
  try {
    localStorage.setItem(LAST_VIEW, JSON.stringify({ centre: [lat, lng], zoom: map.getZoom() }));
  } catch {
    // a browser that keeps nothing begins with the world
  }
}

function lastView() {
  try {
    const { centre, zoom } = JSON.parse(localStorage.getItem(LAST_VIEW) ?? "null") ?? WORLD;
    return [...centre, zoom].every(Number.isFinite) ? { centre, zoom } : WORLD;
  } catch {
    return WORLD;
  }
}
