/** The start of a page that holds one playback and opens from disk. */

/* global L */

import { Playback } from "./playback.js";
import { Player } from "./player.js";

const MARGIN = 0.04; // of the area's size, left free round it

/** Bytes of a text in base 64 that were packed by gzip. */
async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

async function start() {
  const told = document.getElementById("message");
  try {
    const playback = Playback.decode(await unpacked(document.getElementById("playback").textContent));
    const map = L.map("map", {
      crs: L.CRS.Simple, zoomSnap: 0.25, minZoom: -12, maxZoom: 12, attributionControl: false, zoomControl: true,
    });
    const [x0, y0, x1, y1] = playback.header.bounds_m;
    map.fitBounds(L.latLngBounds([y0, x0], [y1, x1]).pad(MARGIN), { animate: false });
    const controls = document.getElementById("controls");
    window.rotaPlayer = new Player({ playback, map, controls });
    told.remove();
  } catch (error) {
    told.textContent = `The plan cannot be shown: ${error.message}`;
    throw error;
  }
}

start();
