// GraphMap: one building of a collection on a Leaflet map, a floor or the layout of a graph.

import { formatArea } from "./elements.js";
import { addHatch } from "./hatch.js";
import { inBox, inRings } from "./shapes.js";
import { boxOfAll, colourOf } from "./small_pictures.js";

const PADDING_PX = 24;
const LINE_PX = 13;
export const CHARACTER_PX = 5.6;
// Characters of a label that is cut.
const LEAST_LENGTH = 5;

export class GraphMap {
  // onHover(node, point of the map on the screen), with null for none.
  constructor(container, onHover) {
    this.map = L.map(container, { crs: L.CRS.Simple, minZoom: -4, maxZoom: 9, zoomSnap: 0.25, attributionControl: false,
      doubleClickZoom: false, boxZoom: false });
    this.map.setView([0, 0], 3);
    this.renderer = L.svg({ padding: 0.3 }).addTo(this.map);
    this.shapes = L.layerGroup().addTo(this.map);
    this.texts = L.layerGroup().addTo(this.map);
    this.nodes = [];
    this.onHover = onHover;
    this.map.on("mousemove", ({ latlng, containerPoint }) => onHover(this._nodeAt([latlng.lng, latlng.lat]), containerPoint));
    this.map.on("mouseout", () => onHover(null));
    this.map.on("zoomend", () => this._write());
    this.sizes = new ResizeObserver(() => this.map.invalidateSize({ animate: false }));
    this.sizes.observe(container);
  }

  remove() {
    this.sizes.disconnect();
    this.map.remove();
  }

  draw({ nodes, edges, metres }) {
    this.nodes = nodes;
    this.shapes.clearLayers();
    this.onHover(null);
    const lines = () => edges.length && this._add(L.polyline(edges.map(flip), this._style(metres ? "door" : "graph-edge")));
    if (!metres) lines();
    for (const node of nodes) {
      const fillColor = node.known ? colourOf(node) : `url(#${addHatch(this.renderer._container, colourOf(node))})`;
      this._add(L.polygon(node.rings.map(flip), { ...this._style(node.known ? "graph-room" : "graph-room sample-room"), fillColor }));
    }
    if (metres) lines();
    this._fit();
    this._write();
  }

  _fit() {
    if (!this.nodes.length) return;
    const [left, bottom, right, top] = boxOfAll(this.nodes);
    this.map.fitBounds([[bottom, left], [top, right]], { animate: false, padding: [PADDING_PX, PADDING_PX] });
  }

  // The label of each node where there is room for it; the id alone in smaller ones.
  _write() {
    this.texts.clearLayers();
    const scale = this.map.getZoomScale(this.map.getZoom(), 0);
    for (const node of this.nodes) {
      const [width, height] = [(node.box[2] - node.box[0]) * scale, (node.box[3] - node.box[1]) * scale];
      const lines = [String(node.id), node.label].map((text) => shorten(text, Math.floor(width / CHARACTER_PX))).filter(Boolean);
      const text = lines.slice(0, Math.floor(height / LINE_PX)).join("\n");
      if (!text) continue;
      const line = document.createElement("span");
      line.textContent = text;
      const icon = L.divIcon({ html: line, className: "mark-text", iconSize: [0, 0] });
      L.marker([node.centre[1], node.centre[0]], { icon, interactive: false, keyboard: false }).addTo(this.texts);
    }
  }

  _nodeAt([x, y]) {
    return this.nodes.find((node) => inBox([x, y], node.box) && inRings([x, y], node.rings)) ?? null;
  }

  _add(shape) {
    shape.addTo(this.shapes);
  }

  _style(className) {
    return { renderer: this.renderer, className, interactive: false, smoothFactor: 0.5 };
  }
}

// A text of a number of characters at most; nothing if it would be no more than its start.
export function shorten(text, length) {
  if (!text || text.length <= length) return text;
  return length < LEAST_LENGTH ? null : `${text.slice(0, length - 1)}…`;
}

function flip(points) {
  return points.map(([x, y]) => [y, x]);
}

export function describeNode({ id, label, area, known, door }) {
  const size = area ? `\n${formatArea(area)}` : "";
  const note = known ? "" : `\npredicted${door ? `, behind the door to ${door}` : ""}`;
  return `Room ${id}\n${label ?? "no label"}${size}${note}`;
}
