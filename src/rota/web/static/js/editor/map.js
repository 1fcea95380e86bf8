/** The Leaflet map: metres on CRS.Simple with a grid, or tiles in Web Mercator where somebody has them. */

import { GridLines } from "./grid.js";

const L = window.L;

const METRES_VIEW = [
  [-20, -30],
  [200, 330],
];
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

  /** Where tiles come from, for missions that lie on the globe; null for nowhere. */
  useTiles(url) {
    this.tiles = url === null ? null : L.tileLayer(url, { maxZoom: 22, maxNativeZoom: 19 });
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
      this.map.setView([frame.origin.lat, frame.origin.lon], 15, { animate: false });
      this.tiles.addTo(this.map);
    } else {
      this.tiles.remove();
      this.map.fitBounds(METRES_VIEW, { animate: false });
      this.grid.addTo(this.map);
    }
    return true;
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
