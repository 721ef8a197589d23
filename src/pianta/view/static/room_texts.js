// Ids, numbers with names, and labels of rooms on the map, where there is room for them.

import { inRings } from "./shapes.js";

// Pixels of a line of text and of the space at both sides of it, as in view.css.
const LINE_PX = 15;
const MARGIN_PX = 6;

function makeRuler() {
  const ruler = document.createElement("canvas").getContext("2d");
  ruler.font = `600 11px ${getComputedStyle(document.body).fontFamily}`;
  return ruler;
}

export const RoomTexts = L.Layer.extend({
  initialize() {
    this._rooms = [];
    this._texts = new Map();
    this._widths = new Map();
    this._lines = new Map();
  },

  setRooms(rooms) {
    this._rooms = rooms;
    this._lines.clear();
    for (const text of this._texts.values()) text.remove();
    this._texts.clear();
    if (this._map) this._place();
  },

  onAdd(map) {
    this._pane = L.DomUtil.create("div", "room-texts leaflet-zoom-hide");
    map.getPane("markerPane").appendChild(this._pane);
    this._place();
  },

  onRemove() {
    this._pane.remove();
    this._texts.clear();
  },

  getEvents() {
    // It follows each end of a zoom too.
    return { moveend: this._place };
  },

  _place() {
    const seen = this._map.getPixelBounds().pad(0.2);
    const origin = this._map.getPixelOrigin();
    for (const room of this._rooms) {
      const point = this._map.project(L.latLng(room.centre[1], room.centre[0]));
      const lines = seen.contains(point) ? this._fit(room) : [];
      if (lines.length) this._write(room, lines, point.subtract(origin));
      else this._remove(room);
    }
  },

  // The lines of a room's text: its id if the box of the room is large enough, and as much of its title and its label
  // as stays inside the room.
  _fit(room) {
    const zoom = this._map.getZoom();
    if (this._zoom !== zoom) this._lines.clear();
    this._zoom = zoom;
    if (!this._lines.has(room)) this._lines.set(room, this._findLines(room, this._map.getZoomScale(zoom, 0)));
    return this._lines.get(room);
  },

  _findLines(room, scale) {
    const [left, bottom, right, top] = room.box;
    const id = String(room.id);
    if ((right - left) * scale < this._widthOf(id) || (top - bottom) * scale < LINE_PX) return [];
    const more = [room.title, room.label].filter(Boolean);
    const sets = [[id, ...more], ...more.map((text) => [id, text]).reverse()];
    return sets.find((lines) => this._isInside(room, lines, scale)) ?? [id];
  },

  // Whether the box of the lines is inside a room; looked up at points of its border, half a line from each other.
  _isInside(room, lines, scale) {
    const width = Math.max(...lines.map((text) => this._widthOf(text))) / 2;
    const height = (lines.length * LINE_PX) / 2;
    const [x, y] = room.centre;
    const inside = (right, down) => inRings([x + right / scale, y - down / scale], room.rings);
    for (let right = -width; right < width + LINE_PX; right += LINE_PX / 2) {
      const at = Math.min(right, width);
      if (!inside(at, -height) || !inside(at, height)) return false;
    }
    for (let down = -height; down < height; down += LINE_PX / 2) {
      if (!inside(-width, down) || !inside(width, down)) return false;
    }
    return true;
  },

  _widthOf(text) {
    if (!this._widths.has(text)) {
      this._ruler ??= makeRuler();
      this._widths.set(text, this._ruler.measureText(text).width + MARGIN_PX);
    }
    return this._widths.get(text);
  },

  _write(room, lines, point) {
    let text = this._texts.get(room.id);
    if (!text) {
      text = L.DomUtil.create("div", "room-text", this._pane);
      this._texts.set(room.id, text);
    }
    const content = lines.join("\n");
    if (text.textContent !== content) text.textContent = content;
    const { x, y } = point.round();
    // Not by a transform in three dimensions, which would make a layer of each text: hundreds of them stop the browser.
    text.style.left = `${x}px`;
    text.style.top = `${y}px`;
  },

  _remove(room) {
    this._texts.get(room.id)?.remove();
    this._texts.delete(room.id);
  },
});
