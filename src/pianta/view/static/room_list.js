// The list of rooms: it sorts by a column and finds by id, number, name or label; arrow keys move in it.

import { byId, element, formatArea } from "./elements.js";
import { showFill } from "./patterns.js";

const COLUMNS = {
  id: { text: "Id", value: (room) => room.id },
  number: { text: "No.", value: (room) => room.number ?? "" },
  name: { text: "Name", value: (room) => room.name ?? "" },
  label: { text: "Label", value: (room) => room.label ?? "" },
  // As shown, so that rooms of one area stay in the order of their ids.
  area: { text: "Area", value: (room) => Math.round(room.area * 10) },
};
const MOVES = { ArrowDown: 1, ArrowUp: -1, PageDown: 10, PageUp: -10, Home: -Infinity, End: Infinity };
const words = new Intl.Collator(undefined, { numeric: true, sensitivity: "base" });

export class RoomList {
  // onSelect(room, focus), onHover(room)
  constructor(onSelect, onHover) {
    this.onSelect = onSelect;
    this.onHover = onHover;
    this.rooms = [];
    this.column = "id";
    this.down = false;
    this.body = byId("rooms").tBodies[0];
    const head = byId("rooms").tHead.rows[0];
    head.replaceChildren(...Object.entries(COLUMNS).map(([name, { text }]) =>
      element("th", { scope: "col", id: `sort-${name}`, className: name },
        element("button", { type: "button", onclick: () => this.sort(name) }, text))));
    byId("find").addEventListener("input", () => this.show());
    byId("find").addEventListener("keydown", (event) => this._onFindKey(event));
    this.body.addEventListener("keydown", (event) => this._onKey(event));
    this.body.addEventListener("click", (event) => this._pick(event.target.closest("tr"), false));
    this.body.addEventListener("mouseover", (event) => this.onHover(this._roomOf(event.target.closest("tr"))));
    this.body.addEventListener("mouseleave", () => this.onHover(null));
    this._markSort();
  }

  sort(column) {
    this.down = this.column === column ? !this.down : false;
    this.column = column;
    this._markSort();
    this.show();
  }

  // areas: of the state of the floor.
  setRooms(rooms, selected, areas) {
    this.rooms = rooms;
    // A column that most floors would leave empty.
    byId("rooms").classList.toggle("numbered", rooms.some((room) => room.number));
    this.areas = areas;
    byId("areas-note").textContent = areas?.note ?? "";
    byId("areas-note").hidden = !areas?.note;
    this.selected = selected;
    this.show();
  }

  select(id) {
    this.selected = id;
    for (const row of this.body.rows) this._markRow(row);
    this._setStop();
    this.body.querySelector("[aria-selected=true]")?.scrollIntoView({ block: "nearest" });
  }

  show() {
    const focused = document.activeElement?.closest?.("#rooms tbody tr")?.dataset.room;
    const found = this._find(byId("find").value);
    const { value } = COLUMNS[this.column];
    found.sort((a, b) => {
      const [first, second] = [value(a), value(b)];
      const order = typeof first === "number" ? first - second : words.compare(first, second);
      return (this.down ? -order : order) || a.id - b.id;
    });
    this.body.replaceChildren(...found.map((room) => this._makeRow(room)));
    if (!found.length) this.body.append(element("tr", {}, element("td", { colSpan: Object.keys(COLUMNS).length }, "No room")));
    this._setStop();
    if (focused) this.body.querySelector(`[data-room="${focused}"]`)?.focus();
  }

  _find(text) {
    const wanted = text.trim().toLowerCase();
    return this.rooms.filter((room) =>
      !wanted || String(room.id) === wanted || `${room.title ?? ""}\n${room.label ?? ""}`.toLowerCase().includes(wanted));
  }

  _makeRow(room) {
    const colour = element("span", { className: "colour" });
    showFill(colour, room);
    const cell = (className, text, ...before) => element("td", { className, title: text }, ...before, text);
    const row = element("tr", {}, cell("id", String(room.id), colour), cell("number", room.number ?? ""),
      cell("name", room.name ?? ""), cell("label", room.label ?? ""), cell("area", formatArea(room.area, this.areas)));
    row.dataset.room = room.id;
    this._markRow(row);
    return row;
  }

  _markRow(row) {
    row.setAttribute("aria-selected", String(Number(row.dataset.room) === this.selected));
  }

  // Tab stops at one row: the selected one, else the first.
  _setStop() {
    for (const row of this.body.rows) row.tabIndex = -1;
    const stop = this.body.querySelector("[aria-selected=true]") ?? this.body.querySelector("[data-room]");
    if (stop) stop.tabIndex = 0;
  }

  _onKey(event) {
    const row = event.target.closest("tr");
    if (event.key === "Enter" || event.key === " ") {
      this._pick(row, event.key === "Enter");
    } else if (event.key in MOVES) {
      const rows = [...this.body.rows];
      const index = Math.max(0, Math.min(rows.length - 1, rows.indexOf(row) + MOVES[event.key]));
      rows[index].focus();
      this.onHover(this._roomOf(rows[index]));
    } else {
      return;
    }
    event.preventDefault();
  }

  _onFindKey(event) {
    const first = this.body.querySelector("[data-room]");
    if (event.key === "Enter") this._pick(first, false);
    else if (event.key === "ArrowDown") first?.focus();
    else if (event.key === "Escape" && event.target.value) {
      event.target.value = "";
      this.show();
      event.stopPropagation();
    } else return;
    event.preventDefault();
  }

  _pick(row, focus) {
    const room = this._roomOf(row);
    if (room) this.onSelect(room, focus);
  }

  _roomOf(row) {
    return this.rooms.find((room) => String(room.id) === row?.dataset.room) ?? null;
  }

  _markSort() {
    for (const name of Object.keys(COLUMNS)) {
      const order = this.down ? "descending" : "ascending";
      byId(`sort-${name}`).setAttribute("aria-sort", name === this.column ? order : "none");
    }
  }
}
