// Ids, names and labels of rooms on the map, where there is room for them.

// Pixels of a line of text, and of a character; chosen by hand for the font of view.css.
const LINE_PX = 15;
const CHARACTER_PX = 6.6;
const MARGIN_PX = 4;

export const RoomTexts = L.Layer.extend({
  initialize() {
    this._rooms = [];
    this._texts = new Map();
  },

  setRooms(rooms) {
    this._rooms = rooms;
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
    return { zoomend: this._place, moveend: this._place, viewreset: this._place };
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

  // The lines of a room's text that its box has room for: the id, then the name, then the label.
  _fit(room) {
    const scale = this._map.getZoomScale(this._map.getZoom(), 0);
    const width = (room.box[2] - room.box[0]) * scale - MARGIN_PX;
    const height = (room.box[3] - room.box[1]) * scale - MARGIN_PX;
    const wanted = [String(room.id), room.name, room.label].filter(Boolean);
    const fitting = wanted.filter((text) => text.length * CHARACTER_PX <= width);
    return fitting.slice(0, Math.floor(height / LINE_PX));
  },

  _write(room, lines, point) {
    let text = this._texts.get(room.id);
    if (!text) {
      text = L.DomUtil.create("div", "room-text", this._pane);
      this._texts.set(room.id, text);
    }
    const content = lines.join("\n");
    if (text.textContent !== content) text.textContent = content;
    L.DomUtil.setPosition(text, point.round());
  },

  _remove(room) {
    this._texts.get(room.id)?.remove();
    this._texts.delete(room.id);
  },
});
