// A prediction on the page: what is expected behind open ends, and sampled floors, over the known floor.

import { byId, element, formatShare } from "./elements.js";
import { CHARACTER_PX, shorten } from "./graph_map.js";
import { addHatch } from "./hatch.js";
import { distanceTo } from "./shapes.js";
import { Timeline } from "./timeline.js";

const LAYERS = { ends: "Open ends, predicted", sample: "Sampled floor, predicted (places are drawn, not predicted)" };
// Labels of an end in the texts.
const SHOWN_LABELS = 3;
const LEAST_SHARE = 0.005;

export class Predicted {
  constructor(page, state) {
    this.page = page;
    this.number = state.map;
    this.version = state.version;
    this.ends = state.prediction.ends;
    this.nodes = [];
    this.parts = new Map();
    const { map } = page.floorMap;
    page.floorMap.renderers.doors.addTo(map);
    this.groups = Object.fromEntries(Object.keys(LAYERS).map((name) => [name, L.layerGroup().addTo(map)]));
    this.switches = Object.entries(LAYERS).map(([name, text]) => element("label", { className: "predicted-switch" },
      element("input", { type: "checkbox", name, checked: true, onchange: ({ target }) => this._switch(name, target.checked) }), text));
    byId("layers").append(...this.switches);
    byId("layers-part").open = true;
    this.part = this._makeList(state.prediction);
    byId("side").prepend(this.part);
    this.onZoom = () => this._writeSample();
    map.on("zoomend", this.onZoom);
    this._drawEnds();
    this._makeTimeline(state.prediction);
  }

  // What is predicted at a point of the map frame, as text.
  describe(point) {
    const { map } = this.page.floorMap;
    const node = map.hasLayer(this.groups.sample)
      && this.nodes.find((each) => distanceTo(each.position, point) <= each.radius);
    if (node) return describeNode(node, this.timeline.index);
    const room = this.page.shapes.roomAt(point);
    const end = room && map.hasLayer(this.groups.ends) && this.ends.find((each) => String(each.room) === String(room.id));
    return end ? describeEnd(end) : "";
  }

  remove() {
    this.timeline?.remove();
    this.page.floorMap.map.off("zoomend", this.onZoom);
    this.part.remove();
    for (const each of this.switches) each.remove();
    for (const group of Object.values(this.groups)) group.remove();
  }

  _switch(name, on) {
    if (on) this.groups[name].addTo(this.page.floorMap.map);
    else this.groups[name].remove();
  }

  _makeList({ rooms, area, unknown, ends, building_type: type }) {
    const whole = `${formatSpread(rooms)} rooms${area ? `, ${formatSpread(area)} m²` : ""}`;
    const items = ends.map((end) => {
      const title = element("button", { type: "button", className: "link", disabled: !end.position,
        onclick: () => this._show(end) }, titleOf(end));
      return element("li", {}, title, listShares(end.labels), element("p", { className: "quiet" }, restOf(end)));
    });
    const counts = Object.entries(unknown).map(([label, spread]) => [element("dt", {}, label), element("dd", {}, formatSpread(spread, 1))]);
    return element("details", { open: true, id: "predicted-part" }, element("summary", {}, `Predicted (${type})`),
      element("p", {}, `Whole floor: ${whole}`), element("ol", { id: "ends" }, ...items),
      element("details", {}, element("summary", {}, "Unknown rooms by label"), element("dl", {}, ...counts.flat())),
      element("p", { className: "quiet" }, "8 (2–15): mean, and the interval of four of five samples. Dashed and hatched: predicted, not seen."));
  }

  _show(end) {
    const room = this.page.shapes.byId.get(end.room);
    if (room) this.page.select(room, true);
  }

  _drawEnds() {
    const { renderers } = this.page.floorMap;
    for (const end of this.ends) {
      if (!end.outline) continue;
      const rings = end.outline.map((ring) => ring.map(([x, y]) => [y, x]));
      // Of a corridor that is open at its end the room itself is known.
      const hatched = end.kind === "door" || end.whole;
      L.polygon(rings, { renderer: renderers.doors, pane: "doors", className: "end", interactive: false, fill: hatched,
        fillColor: `url(#${addHatch(renderers.doors._container)})` }).addTo(this.groups.ends);
      const [best] = sortShares(end.labels);
      const label = best ? `${best[0]}? ${formatShare(best[1])}` : "?";
      write(this.groups.ends, end.position, end.kind === "door" ? label : `goes on: ${end.rooms.mean.toFixed(0)} rooms?`, "end-text");
    }
  }

  // The known floor and the first sample, above the timeline.
  _fit() {
    const { map } = this.page.floorMap;
    const points = this.nodes.flatMap(({ position: [x, y], radius }) => [[y - radius, x - radius], [y + radius, x + radius]]);
    for (const { box } of this.page.shapes.rooms) points.push([box[1], box[0]], [box[3], box[2]]);
    if (points.length) map.fitBounds(points, { animate: false, paddingTopLeft: [24, 24], paddingBottomRight: [24, 110] });
  }

  _makeTimeline({ shown, total }) {
    if (!shown) return;
    const texts = Array.from({ length: shown }, (_, index) => `Sample ${index + 1} of ${total}`);
    this.timeline = new Timeline(texts, (index) => this._go(index), { name: "Sampled floor" });
    byId("map-part").append(this.timeline.box);
    this._go(0);
  }

  async _go(index) {
    try {
      const part = this.parts.get(index) ?? await this.page.source.getPart(this.number, index);
      this.parts.set(index, part);
      if (index !== this.timeline.index || !this.page.session) return;
      this._drawSample(part);
      if (!this.fitted) this._fit();
      this.fitted = true;
    } catch (fault) {
      this.timeline.stop();
      this.page.fail(fault);
    }
  }

  _drawSample({ nodes, edges }) {
    this.nodes = nodes;
    const { renderers } = this.page.floorMap;
    const style = { renderer: renderers.doors, pane: "doors", interactive: false };
    this.groups.sample.clearLayers();
    for (const edge of edges) {
      L.polyline(edge.map(([x, y]) => [y, x]), { ...style, className: "sample-edge" }).addTo(this.groups.sample);
    }
    for (const { position: [x, y], radius, colour, corridor } of nodes) {
      const options = { ...style, className: "sample-room",
        fillColor: `url(#${addHatch(renderers.doors._container, colour)})` };
      const side = radius * 0.886;
      const shape = corridor ? L.rectangle([[y - side, x - side], [y + side, x + side]], options)
        : L.circle([y, x], { ...options, radius });
      shape.addTo(this.groups.sample);
    }
    this.texts = L.layerGroup().addTo(this.groups.sample);
    this._writeSample();
  }

  // Labels as far as the rooms have room for them.
  _writeSample() {
    this.texts?.clearLayers();
    const { metresPerPixel } = this.page.floorMap;
    for (const { position, radius, label } of this.nodes) {
      const text = shorten(label ?? "?", Math.floor((2 * radius) / metresPerPixel / CHARACTER_PX));
      if (text) write(this.texts, position, text);
    }
  }
}

function write(group, [x, y], text, className = "") {
  const icon = L.divIcon({ html: element("span", {}, text), className: `mark-text predicted-text ${className}`, iconSize: [0, 0] });
  L.marker([y, x], { icon, interactive: false, keyboard: false, pane: "markerPane" }).addTo(group);
}

export function formatSpread({ mean, low, high }, digits = 0) {
  return `${mean.toFixed(digits)} (${low.toFixed(0)}–${high.toFixed(0)})`;
}

function sortShares(labels) {
  return Object.entries(labels).sort((a, b) => b[1] - a[1]).filter(([, share]) => share >= LEAST_SHARE);
}

function titleOf(end) {
  return end.kind === "door" ? `Behind the door of ${end.near} to ${end.room}` : `Along corridor ${end.room}`;
}

function restOf(end) {
  const area = end.area ? `, ${formatSpread(end.area)} m²` : "";
  return `${formatSpread(end.rooms)} rooms${area}; leads on to unknown corridors: ${formatShare(end.leads_on)}`;
}

function describeEnd(end) {
  const labels = sortShares(end.labels).slice(0, SHOWN_LABELS).map(([label, share]) => `${label} ${formatShare(share)}`);
  return `Predicted. ${titleOf(end)}:\n${labels.join(", ") || "nothing"}\n${restOf(end)}`;
}

function describeNode({ label, area, door }, index) {
  const size = area ? `, ${area.toFixed(1)} m²` : "";
  return `Predicted, sample ${index + 1}: ${label ?? "no label"}${size}${door ? `\nbehind the door to ${door}` : ""}\nIts place is not predicted.`;
}

export function listShares(labels) {
  return element("ul", { className: "bars" }, ...sortShares(labels).slice(0, SHOWN_LABELS).map(([label, share]) =>
    element("li", {}, element("meter", { value: share, min: 0, max: 1, "aria-label": label }),
      element("span", {}, `${label} ${formatShare(share)}`))));
}
