// An exploration on the page: the floor and the map at each step, and the ways of the robots until then.

import { byId, element } from "./elements.js";
import { Timeline } from "./timeline.js";

const COLOURS = 4;

export class Explored {
  constructor(page, state) {
    this.page = page;
    this.parts = new Map();
    this.number = state.map;
    this.layer = L.layerGroup().addTo(page.floorMap.map);
    this.version = state.version;
    const texts = state.steps.map((step, index) =>
      `Step ${index + 1} of ${state.steps.length}: ${formatTime(step.time)}, ${step.distance.toFixed(1)} m driven, ` +
      `${Math.round(step.share * 100)} % seen`);
    this.timeline = new Timeline(texts, (index) => this._go(index), { start: texts.length - 1, name: "Step of the exploration" });
    byId("map-part").append(this.timeline.box);
    this.part = element("details", { open: true, id: "about-part" }, element("summary", {}, "Exploration"),
      element("dl", {}, ...facts(state).flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, value)])));
    byId("side").prepend(this.part);
    this._drawTracks(state.tracks);
  }

  describe() {
    return "";
  }

  remove() {
    this.timeline.remove();
    this.part.remove();
    this.layer.remove();
  }

  async _go(index) {
    try {
      const part = this.parts.get(index) ?? await this.page.source.getPart(this.number, index);
      this.parts.set(index, part);
      // A slower answer to an earlier step is not shown.
      if (index !== this.timeline.index || !this.page.session) return;
      this.page.showStep(part);
      this._drawTracks(part.tracks);
    } catch (fault) {
      this.timeline.stop();
      this.page.fail(fault);
    }
  }

  _drawTracks(tracks) {
    this.layer.clearLayers();
    for (const [index, track] of tracks.entries()) {
      if (!track.length) continue;
      const points = track.map(([x, y]) => [y, x]);
      const className = `track track-${index % COLOURS}`;
      const style = { renderer: this.page.floorMap.renderers.marks, pane: "marks", interactive: false };
      L.polyline(points, { ...style, className }).addTo(this.layer);
      L.circleMarker(points[0], { ...style, className: `${className} track-start`, radius: 4 }).addTo(this.layer);
      L.circleMarker(points.at(-1), { ...style, className: `${className} track-robot`, radius: 7 }).addTo(this.layer);
    }
  }
}

function facts({ about, tracks }) {
  return [["World", about.world], ["Policy", about.policy], ["Robots", String(tracks.length)],
    ["Area", `${about.reachable_area.toFixed(1)} m²`], ["End", about.outcome]];
}

function formatTime(seconds) {
  const whole = Math.round(seconds);
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")} min`;
}
