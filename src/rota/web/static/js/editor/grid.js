/** A grid of round metres under everything, so that a hand knows how far it draws. */

const L = window.L;
const APART_PX = 60; // at least so far apart

export const GridLines = L.Layer.extend({
  onAdd(map) {
    this.renderer = L.svg({ pane: "tilePane", padding: 0.5 });
    this.lines = L.layerGroup().addTo(map);
    map.on("moveend zoomend resize", this.draw, this);
    this.draw();
  },

  onRemove(map) {
    map.off("moveend zoomend resize", this.draw, this);
    this.lines.remove();
    this.renderer.remove();
  },

  draw() {
    const bounds = this._map.getBounds().pad(0.5);
    const step = roundStep(APART_PX / this._map.getZoomScale(this._map.getZoom(), 0));
    const [west, east, south, north] = [bounds.getWest(), bounds.getEast(), bounds.getSouth(), bounds.getNorth()];
    const paths = [];
    for (let x = Math.ceil(west / step) * step; x <= east; x += step) {
      paths.push([
        [south, x],
        [north, x],
      ]);
    }
    for (let y = Math.ceil(south / step) * step; y <= north; y += step) {
      paths.push([
        [y, west],
        [y, east],
      ]);
    }
    this.lines.clearLayers();
    const options = { renderer: this.renderer, className: "grid-line", interactive: false, stroke: true, noClip: true };
    this.lines.addLayer(L.polyline(paths, options));
  },
});

/** The least of 1, 2, 5, 10, ... (and their tenths) that is not below a length. */
export function roundStep(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].map((digit) => digit * power).find((step) => step >= least * (1 - 1e-9)) ?? 10 * power;
}
