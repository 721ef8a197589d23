// A collection on the page: buildings with their figures, sorted by one of them, and one of them large beside the list.

import { byId, element } from "./elements.js";
import { GraphMap, describeNode } from "./graph_map.js";
import { drawSmallGraph, readShapes } from "./small_pictures.js";

const words = new Intl.Collator(undefined, { numeric: true, sensitivity: "base" });
const MOVES = { ArrowDown: 1, ArrowUp: -1, PageDown: 5, PageUp: -5, Home: -Infinity, End: Infinity };
const FOLLOW_MS = 1000;

export async function drawSmallPart(picture, source, map, part) {
  picture.replaceChildren(drawSmallGraph(readShapes(await source.getPart(map, part))));
}

export class Collection {
  constructor(box, source, state) {
    this.box = box;
    this.source = source;
    this.column = "name";
    this.down = false;
    this.selected = 0;
    this._build(state);
    this._show(state);
    this.timer = setTimeout(() => this._follow(), FOLLOW_MS);
  }

  close() {
    clearTimeout(this.timer);
    this.closed = true;
    this.watcher?.disconnect();
    this.graphMap.remove();
    this.box.replaceChildren();
  }

  sort(column) {
    // Figures from the largest, names from the first.
    this.down = this.column === column ? !this.down : column !== "name";
    this.column = column;
    this._fill();
  }

  async select(index) {
    this.selected = index;
    for (const row of this.body.rows) {
      const own = Number(row.dataset.item) === index;
      row.setAttribute("aria-selected", String(own));
      row.tabIndex = own ? 0 : -1;
    }
    const item = this.state.items[index];
    this.heading.textContent = item.name;
    this.texts.replaceChildren(...(item.texts ?? []).map((text) => element("li", {}, text)));
    try {
      const part = await this.source.getPart(this.state.map, index);
      if (index === this.selected && !this.closed) this.graphMap.draw(readShapes(part));
    } catch (fault) {
      this.heading.textContent = fault.message;
    }
  }

  _build(state) {
    this.head = element("tr");
    this.body = element("tbody", { role: "rowgroup" });
    this.body.addEventListener("click", (event) => this._pick(event.target.closest("tr")));
    this.body.addEventListener("keydown", (event) => this._onKey(event));
    this.heading = element("h2");
    this.texts = element("ul", { id: "item-texts" });
    const map = element("div", { id: "graph-map", tabIndex: 0, "aria-label": "The building: arrow keys move it, + and - zoom" });
    this.tip = element("div", { id: "graph-tip", hidden: true });
    const table = element("table", { id: "items" }, element("thead", {}, this.head), this.body);
    const notes = state.prediction ? [element("p", { className: "quiet" }, "Samples of a prediction; dashed rooms are predicted, others known.")] : [];
    this.box.replaceChildren(
      element("section", { className: "items", "aria-label": "Buildings" }, ...notes, table),
      element("section", { className: "item", "aria-label": "Building" }, this.heading,
        element("div", { className: "graph-part" }, map, this.tip), this.texts));
    this.graphMap = new GraphMap(map, (node, at) => this._showTip(node, at));
  }

  _show(state) {
    this.state = state;
    byId("title").textContent = state.name;
    document.title = `${state.name}, pianta`;
    byId("history").hidden = true;
    const rest = state.total > state.items.length ? `, the first of ${state.total}` : "";
    byId("summary").textContent = `${state.heading}${rest}`;
    this._fill();
    this.select(Math.min(this.selected, state.items.length - 1));
  }

  _fill() {
    // Columns without a figure are left out, such as areas of buildings that have none.
    const known = ([name]) => this.state.items.some(({ figures }) => figures[name] !== undefined && figures[name] !== null);
    const own = Object.fromEntries(Object.entries(this.state.columns).filter(known));
    const columns = { name: "name", ...own };
    this.head.replaceChildren(element("th", { scope: "col" }, ""), ...Object.entries(columns).map(([name, text]) => {
      const order = this.column !== name ? "none" : this.down ? "descending" : "ascending";
      return element("th", { scope: "col", "aria-sort": order }, element("button", { type: "button", value: name,
        onclick: () => this.sort(name) }, text));
    }));
    const order = this.state.items.map((_, index) => index).sort((a, b) => this._compare(a, b));
    this.body.replaceChildren(...order.map((index) => this._makeRow(index, Object.keys(own))));
    this._watch();
  }

  // Items without a figure are last, either way.
  _compare(a, b) {
    const values = [a, b].map((index) => this._value(this.state.items[index]));
    if (values[0] === null || values[1] === null) return (values[0] === null) - (values[1] === null) || a - b;
    const order = typeof values[0] === "number" ? values[0] - values[1] : words.compare(...values);
    return (this.down ? -order : order) || a - b;
  }

  _value(item) {
    return this.column === "name" ? item.name : item.figures[this.column] ?? null;
  }

  _makeRow(index, columns) {
    const item = this.state.items[index];
    const figures = columns.map((name) => element("td", {}, formatFigure(item.figures[name])));
    const row = element("tr", {}, element("td", { className: "small" }), element("td", { title: item.name }, item.name), ...figures);
    row.dataset.item = index;
    row.tabIndex = index === this.selected ? 0 : -1;
    row.setAttribute("aria-selected", String(index === this.selected));
    return row;
  }

  // A picture is drawn when its row comes into view.
  _watch() {
    this.watcher?.disconnect();
    this.watcher = new IntersectionObserver((seen) => {
      for (const { target, isIntersecting } of seen) {
        if (!isIntersecting) continue;
        this.watcher.unobserve(target);
        drawSmallPart(target.cells[0], this.source, this.state.map, Number(target.dataset.item)).catch((fault) => {
          target.cells[0].textContent = fault.message;
        });
      }
    });
    for (const row of this.body.rows) this.watcher.observe(row);
  }

  _pick(row) {
    if (row?.dataset.item !== undefined) this.select(Number(row.dataset.item));
  }

  _onKey(event) {
    if (!(event.key in MOVES)) return;
    const rows = [...this.body.rows];
    const index = rows.indexOf(event.target.closest("tr")) + MOVES[event.key];
    const row = rows[Math.max(0, Math.min(rows.length - 1, index))];
    this._pick(row);
    row.focus();
    event.preventDefault();
  }

  _showTip(node, at) {
    this.tip.hidden = !node;
    if (!node) return;
    this.tip.textContent = describeNode(node);
    this.tip.style.left = `${at.x + 14}px`;
    this.tip.style.top = `${at.y + 14}px`;
  }

  async _follow() {
    if (!this.source.readOnly && !document.hidden) {
      try {
        if (await this.source.getVersion(this.state.map) !== this.state.version) {
          const state = await this.source.getMap(this.state.map);
          if (!this.closed) this._show(state);
        }
      } catch (fault) {
        if (!this.closed) byId("summary").textContent = fault.message;
      }
    }
    if (!this.closed) this.timer = setTimeout(() => this._follow(), FOLLOW_MS);
  }
}

function formatFigure(value) {
  if (value === undefined || value === null) return "";
  return Number.isInteger(value) ? String(value) : value.toFixed(Math.abs(value) >= 100 ? 0 : 2);
}
