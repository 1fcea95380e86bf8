/** Canvases in a pane of a Leaflet map that pan and zoom with it, drawn in metres. */

/* global L */

const PANE = "rota-player";

export class Stage {
  /**
   * @param {any} map a Leaflet map
   * @param {(x: number, y: number) => any} project from metres to a LatLng
   * @param {number[]} bounds x0, y0, x1, y1 in metres
   * @param {string[]} names of the canvases, the lowest first
   * @param {() => void} moved called when all must be drawn anew
   */
  constructor(map, project, bounds, names, moved) {
    this.map = map;
    this.project = project;
    this.bounds = bounds;
    this.moved = moved;
    this.pane = map.getPane(PANE) ?? map.createPane(PANE);
    this.pane.classList.add("rota-stage");
    /** @type {Record<string, CanvasRenderingContext2D>} */
    this.contexts = {};
    for (const name of names) {
      const canvas = L.DomUtil.create("canvas", "leaflet-zoom-animated", this.pane);
      canvas.setAttribute("aria-hidden", "true");
      this.contexts[name] = canvas.getContext("2d");
    }
    this._events = { move: this.place, zoomend: this.place, viewreset: this.place, resize: this.place };
    map.on(this._events, this);
    map.on("zoomanim", this._zoom, this);
    this.place();
  }

  destroy() {
    this.map.off(this._events, this);
    this.map.off("zoomanim", this._zoom, this);
    for (const { canvas } of Object.values(this.contexts)) canvas.remove();
  }

  /** Puts the canvases over the map's window and works out how metres become pixels. */
  place() {
    const size = this.map.getSize();
    const ratio = window.devicePixelRatio || 1;
    this.size = size;
    this.ratio = ratio;
    this._topLeft = this.map.containerPointToLayerPoint([0, 0]);
    for (const { canvas } of Object.values(this.contexts)) {
      L.DomUtil.setPosition(canvas, this._topLeft);
      const [width, height] = [Math.round(size.x * ratio), Math.round(size.y * ratio)];
      if (canvas.width !== width || canvas.height !== height) {
        canvas.width = width;
        canvas.height = height;
        canvas.style.width = `${size.x}px`;
        canvas.style.height = `${size.y}px`;
      }
    }
    this._workOut();
    this.moved();
  }

  _workOut() {
    const [x0, y0, x1, y1] = this.bounds;
    const origin = this.map.getPixelOrigin().add(this._topLeft);
    const pixels = (x, y) => this.map.project(this.project(x, y)).subtract(origin);
    const [corner, right, up] = [pixels(x0, y0), pixels(x1, y0), pixels(x0, y1)];
    const [ax, ay] = [(right.x - corner.x) / (x1 - x0), (right.y - corner.y) / (x1 - x0)];
    const [bx, by] = [(up.x - corner.x) / (y1 - y0), (up.y - corner.y) / (y1 - y0)];
    /** x' = a x + c y + e, y' = b x + d y + f, in pixels of the page. */
    this.affine = {
      a: ax, b: ay, c: bx, d: by, e: corner.x - ax * x0 - bx * y0, f: corner.y - ay * x0 - by * y0,
    };
    this.pixelsPerMetre = Math.sqrt(Math.abs(ax * by - ay * bx));
  }

  /** Empties a canvas and lets it draw in metres. */
  begin(name) {
    const context = this.contexts[name];
    const { a, b, c, d, e, f } = this.affine;
    const r = this.ratio;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, context.canvas.width, context.canvas.height);
    context.setTransform(a * r, b * r, c * r, d * r, e * r, f * r);
    return context;
  }

  /** Lets a canvas draw in pixels of the page. */
  inPixels(name) {
    const context = this.contexts[name];
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    return context;
  }

  /** Where a place in metres is, in pixels of the map's window. */
  toPixels(x, y) {
    const { a, b, c, d, e, f } = this.affine;
    return [a * x + c * y + e, b * x + d * y + f];
  }

  /** The place in metres at a pixel of the map's window. */
  toMetres(px, py) {
    const { a, b, c, d, e, f } = this.affine;
    const [u, v] = [px - e, py - f];
    const det = a * d - b * c;
    return [(d * u - c * v) / det, (a * v - b * u) / det];
  }

  /** While the map's own zooming runs, the canvases are scaled with it. */
  _zoom({ zoom, center }) {
    const scale = this.map.getZoomScale(zoom, this.map.getZoom());
    const corner = this.map.layerPointToLatLng(this._topLeft);
    const offset = this.map._latLngToNewLayerPoint(corner, zoom, center);
    for (const { canvas } of Object.values(this.contexts)) L.DomUtil.setTransform(canvas, offset, scale);
  }
}
