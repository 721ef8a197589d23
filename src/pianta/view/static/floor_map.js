// FloorMap: the floor on a Leaflet map in metres, its layers, what is marked, and what is being drawn.

import { Background } from "./background.js";
import { RoomCanvas } from "./room_canvas.js";
import { RoomTexts } from "./room_texts.js";

// Share of the screen around a floor at the start.
const PADDING_PX = 24;
const LAYERS = {
  map: "Map",
  rooms: "Rooms",
  texts: "Ids, numbers, names and labels",
  walls: "Walls",
  doors: "Doors and openings",
  possible: "Possible doors",
  furniture: "Furniture",
  partial: "Partial and predicted shapes",
  graph: "Graph",
};
const OFF_AT_START = ["graph"];

const MarkedScale = L.Control.Scale.extend({
  show(trust) {
    this._trust = trust;
    this.getContainer().hidden = trust === "unknown";
    this._update();
  },

  _updateScale(scale, text, ratio) {
    L.Control.Scale.prototype._updateScale.call(this, scale, this._trust === "rough" ? `≈ ${text}` : text, ratio);
  },
});

function toLatLngs(points) {
  return points.map(([x, y]) => [y, x]);
}

export class FloorMap {
  constructor(container) {
    this.map = L.map(container, {
      crs: L.CRS.Simple, minZoom: -4, maxZoom: 9, zoomSnap: 0.25, wheelPxPerZoomLevel: 90, attributionControl: false,
      doubleClickZoom: false, keyboardPanDelta: 90, boxZoom: false,
    });
    this.map.setView([0, 0], 3);
    for (const [index, name] of ["rooms", "walls", "doors", "marks"].entries()) {
      const pane = this.map.createPane(name);
      pane.style.zIndex = 400 + index * 10;
      pane.style.pointerEvents = "none";
    }
    this.renderers = Object.fromEntries(
      ["walls", "doors", "marks"].map((pane) => [pane, L.svg({ pane, padding: 0.3 })]));
    this.roomCanvas = new RoomCanvas({ pane: "rooms", padding: 0.3 });
    document.addEventListener("themechange", () => this.roomCanvas.repaint());
    this.groups = Object.fromEntries(Object.keys(LAYERS).map((name) => [name, L.layerGroup()]));
    for (const [name, group] of Object.entries(this.groups)) if (!OFF_AT_START.includes(name)) group.addTo(this.map);
    this.texts = new RoomTexts().addTo(this.groups.texts);
    this.marks = L.layerGroup().addTo(this.map);
    this.draft = L.layerGroup().addTo(this.map);
    this.scale = new MarkedScale({ imperial: false, maxWidth: 140 }).addTo(this.map);
    new ResizeObserver(() => this.map.invalidateSize({ animate: false })).observe(container);
  }

  static get layerNames() {
    return LAYERS;
  }

  isOn(name) {
    return this.map.hasLayer(this.groups[name]);
  }

  switchLayer(name, on) {
    if (on) this.groups[name].addTo(this.map);
    else this.groups[name].remove();
  }

  // background: url and corners, or null.
  draw(shapes, background) {
    this._drawBackground(background);
    for (const name of Object.keys(LAYERS)) if (name !== "map" && name !== "texts") this.groups[name].clearLayers();
    this._drawRooms(shapes.rooms);
    this._add("furniture", "walls", shapes.furniture.map((rings) => rings.map(toLatLngs)), "furniture", true);
    this._add("walls", "walls", shapes.walls.map(toLatLngs), "wall");
    for (const kind of new Set(shapes.doors.map((door) => door.kind))) {
      const lines = shapes.doors.filter((door) => door.kind === kind).map((door) => toLatLngs(door.line));
      this._add("doors", "doors", lines, "door-under");
      this._add("doors", "doors", lines, kind === "opening" ? "opening" : "door");
    }
    this._add("possible", "doors", shapes.possibleDoors.map((door) => toLatLngs(door.line)), "possible-door");
    this._add("graph", "doors", shapes.graph.map(toLatLngs), "edge");
    const nodes = new Set(shapes.graph.flatMap((path) => [path[0], path[path.length - 1]]).map(String));
    for (const node of nodes) {
      const [x, y] = node.split(",").map(Number);
      L.circleMarker([y, x], this._style("doors", "node", { radius: 4 })).addTo(this.groups.graph);
    }
    this.texts.setRooms(shapes.rooms);
  }

  // areas: of the state; a rough scale has a mark, an unknown one is hidden.
  showScale(areas) {
    this.scale.show(areas?.trust);
  }

  // Show the whole floor.
  fit(shapes, background) {
    const points = shapes.rooms.flatMap((room) => [[room.box[1], room.box[0]], [room.box[3], room.box[2]]]);
    if (!points.length && background) points.push(...toLatLngs(background.corners));
    if (points.length) this.map.fitBounds(points, { animate: false, padding: [PADDING_PX, PADDING_PX] });
  }

  showRoom(room) {
    const bounds = L.latLngBounds([[room.box[1], room.box[0]], [room.box[3], room.box[2]]]);
    const small = this.map.getBoundsZoom(bounds) - this.map.getZoom() < 0;
    if (small) this.map.fitBounds(bounds, { padding: [PADDING_PX, PADDING_PX] });
    else if (!this.map.getBounds().contains(bounds)) this.map.panTo(bounds.getCenter());
  }

  // things: [{thing, className}] of rooms and doors.
  mark(things) {
    this.marks.clearLayers();
    for (const { thing, className } of things) {
      const shape = thing.rings
        ? L.polygon(thing.rings.map(toLatLngs), this._style("marks", className))
        : L.polyline(toLatLngs(thing.line), this._style("marks", className));
      shape.addTo(this.marks);
    }
  }

  // What is being drawn: points that are set, and the one under the pointer.
  sketch(points, next, closed) {
    this.draft.clearLayers();
    const all = next ? [...points, next] : points;
    if (all.length > 1) {
      const make = closed && all.length > 2 ? L.polygon : L.polyline;
      make(toLatLngs(all), this._style("marks", closed ? "draft draft-area" : "draft")).addTo(this.draft);
    }
    for (const point of points) this._dot(point, "draft-point", 5);
    if (next) this._dot(next, "draft-next", 6);
  }

  get metresPerPixel() {
    return 1 / this.map.getZoomScale(this.map.getZoom(), 0);
  }

  _dot([x, y], className, radius) {
    L.circleMarker([y, x], this._style("marks", className, { radius })).addTo(this.draft);
  }

  _drawBackground(background) {
    if (!background) {
      this.groups.map.clearLayers();
      this._url = undefined;
    } else if (background.url === this._url) {
      this.background.setCorners(background.corners);
    } else {
      // The picture before stays until a newer one of the same map is there.
      if (background.url.split("?")[0] !== this._url?.split("?")[0]) this.groups.map.clearLayers();
      const before = this.background;
      this.background = new Background(background.url, background.corners);
      if (before && this.groups.map.hasLayer(before)) {
        this.background.once("load", () => this.groups.map.removeLayer(before));
      }
      this.groups.map.addLayer(this.background);
      this._url = background.url;
    }
  }

  _drawRooms(rooms) {
    for (const room of rooms) {
      const options = { room, renderer: this.roomCanvas, pane: "rooms", interactive: false, smoothFactor: 0.5 };
      L.polygon(room.rings.map(toLatLngs), options).addTo(this.groups.rooms);
    }
    const partial = rooms.filter((room) => room.partial);
    this._add("partial", "doors", partial.map((room) => room.rings.map(toLatLngs)), "partial", true);
    const predicted = partial.filter((room) => room.predicted).map((room) => room.predicted.map(toLatLngs));
    this._add("partial", "doors", predicted, "predicted", true);
  }

  // Shapes of one look as one path.
  _add(group, pane, lines, className, closed = false) {
    if (!lines.length) return;
    const shape = closed ? L.polygon : L.polyline;
    shape(lines, this._style(pane, className)).addTo(this.groups[group]);
  }

  _style(pane, className, more = {}) {
    return { renderer: this.renderers[pane], pane, className, interactive: false, smoothFactor: 0.5, ...more };
  }
}
