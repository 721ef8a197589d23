// Tools: what a click, a tap or Enter on the map means, until an edit is complete.

import { ask, element, say } from "./elements.js";
import { distanceTo } from "./shapes.js";

// Pixels within which points snap, doors are hit, and an outline is closed; chosen by hand.
const SNAP_PX = 12;
const HIT_PX = 10;
const CLOSE_PX = 8;
// How far from a point of a line a finger may be that moves it.
const GRIP_PX = 22;
// Pixels by which an arrow key moves the cross-hair, and with Shift.
const STEP_PX = 12;
const FINE_STEP_PX = 1;
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

// take: what is picked on the map, one after the other. edit: of what was picked.
const TOOLS = {
  select: { text: "Select", key: "v", take: [], hints: ["Select a room or a door."] },
  merge: {
    text: "Merge", key: "m", take: ["room", "room"], hints: ["Merge: pick the first room.", "Pick the second room."],
    edit: (first, second) => ({ kind: "merge", rooms: [first.id, second.id] }),
  },
  split: {
    text: "Split", key: "s", take: ["point", "point"],
    hints: ["Split: set the start of the line at a wall.", "Set the end at the opposite wall."],
    edit: (start, end, shapes) => splitEdit([start, end], shapes),
  },
  draw: {
    text: "Draw room", key: "r", take: ["outline"],
    hints: ["Draw room: set its corners; pick the last corner again to finish."],
    edit: (outline) => ({ kind: "draw room", outline }),
  },
  remove: {
    text: "Delete room", key: "x", take: ["room"], hints: ["Delete room: pick it."],
    edit: (room) => ({ kind: "delete room", room: room.id }),
  },
  outside: {
    text: "Outside", key: "o", take: ["room or outline"],
    hints: ["Outside: pick a room, or set corners around an area; pick the last corner again to finish."],
    edit: (what) => (Array.isArray(what) ? { kind: "outside", outline: what } : { kind: "outside", room: what.id }),
  },
  door: {
    text: "Door", key: "d", take: ["point", "point"], hints: ["Door: set one jamb.", "Set the other jamb."],
    edit: (start, end) => ({ kind: "draw door", line: [start, end], door: "door" }),
  },
  opening: {
    text: "Opening", key: "p", take: ["point", "point"], hints: ["Opening: set one end.", "Set the other end."],
    edit: (start, end) => ({ kind: "draw door", line: [start, end], door: "opening" }),
  },
  move: {
    text: "Move door", key: "g", take: ["door", "point", "point"],
    hints: ["Move door: pick it.", "Set one jamb at its new place.", "Set the other jamb."],
    edit: (door, start, end) => ({ kind: "move door", position: door.position, line: [start, end] }),
  },
  change: {
    text: "Door ↔ opening", key: "c", take: ["door"], hints: ["Pick a door to make it an opening, or the reverse."],
    edit: changeEdit,
  },
  erase: {
    text: "Delete door", key: "e", take: ["door"], hints: ["Delete door: pick a door or an opening."],
    edit: (door) => ({ kind: "delete door", position: door.position }),
  },
  length: {
    text: "Set length", key: "l", take: ["point", "point"],
    hints: ["Scale: set the start of a line whose length you know.", "Set its end."], edit: askLength,
  },
};

export function changeEdit(door) {
  return { kind: "change door", position: door.position, door: door.kind === "opening" ? "door" : "opening" };
}

function splitEdit(line, shapes) {
  const room = shapes.roomAlong(line);
  if (!room) throw new Error("The line crosses no room, draw it from wall to wall of one.");
  return { kind: "split", room: room.id, line };
}

async function askLength(start, end) {
  const now = distanceTo(start, end).toFixed(2);
  const input = element("input", { type: "number", min: "0.01", step: "any", value: now, required: true,
    "aria-label": "Length in metres" });
  const answer = await ask(`The line is ${now} m long. What is its true length in metres? The whole floor is scaled.`,
    [{ text: "Cancel", value: null }, { text: "Scale", value: "", main: true }], input);
  return answer ? { kind: "length", line: [start, end], length: Number(answer) } : null;
}

export class Tools {
  // page: {shapes, submit(edit), select(thing), fail(error, point), hover(thing, point), writable, keepDraft(draft),
  // showDraft(draft), toolChanged(name), showPicked(things)}
  constructor(floorMap, page) {
    this.floorMap = floorMap;
    this.map = floorMap.map;
    this.page = page;
    this._start("select");
    this.map.on("click", (event) => this.pick(toPoint(event.latlng), event.originalEvent));
    this.map.on("mousemove", (event) => this.point(toPoint(event.latlng), event.originalEvent));
    this.map.on("mouseout", () => this.page.hover(null));
    const container = this.map.getContainer();
    container.addEventListener("keydown", (event) => this._onKey(event));
    container.addEventListener("pointerdown", (event) => this._grip(event), true);
  }

  static get all() {
    return TOOLS;
  }

  get busy() {
    return this.points.length > 0 || this.picked.length > 0;
  }

  choose(name, picked = []) {
    this._start(name, picked);
    if (name === "select") this._hideCross();
    this._update();
    this.page.toolChanged(name);
  }

  // Esc: first what is being drawn, then the tool.
  cancel() {
    if (this.busy) this.choose(this.name);
    else if (this.name !== "select") this.choose("select");
    else this.page.select(null);
  }

  point(point, event) {
    if (this.gripped) return;
    this._hideCross();
    this._aim(point, event);
    this.page.hover(this._thingAt(point), this.map.latLngToContainerPoint([point[1], point[0]]));
  }

  async pick(point, event) {
    if (this.name === "select") {
      this.page.select(this._thingAt(point));
    } else if (this.held !== null) {
      await this._put(this._snap(point, event));
    } else if (this.reason !== null && this._pointAt(point, GRIP_PX) !== null) {
      this.held = this._pointAt(point, GRIP_PX);
      this._update();
    } else {
      // A click elsewhere starts another line.
      if (this.reason !== null) this.choose(this.name);
      await this._pickNext(point, event);
    }
  }

  // The last point or room that was picked, taken back.
  takeBack() {
    if (this.points.length) this.points.pop();
    else this.picked.pop();
    this._change();
  }

  // An outline with three corners or more, or a line that was refused.
  get canFinish() {
    return this.reason !== null || (this._outlined && this.points.length > 2);
  }

  async finish() {
    if (this.canFinish) await this._send();
  }

  // What was being drawn before the page was loaded. draft: as given to keepDraft.
  resume({ name, picked, points, reason }) {
    const { shapes } = this.page;
    const found = picked.map(({ room, door }) =>
      (room === undefined ? shapes.doorAt(door, HIT_PX * this.floorMap.metresPerPixel) : shapes.byId.get(room)));
    if (!(name in TOOLS) || found.some((thing) => !thing)) return;
    this._start(name, found, points, reason);
    this._update();
    this.page.toolChanged(name);
    if (reason) this._showReason();
  }

  _start(name, picked = [], points = [], reason = null) {
    this.name = name;
    this.picked = picked;
    this.points = points;
    // Why what is drawn was refused; its points can be moved until it fits.
    this.reason = reason;
    // The number of a point that was picked up.
    this.held = null;
  }

  get _outlined() {
    return TOOLS[this.name].take.at(-1)?.includes("outline") ?? false;
  }

  _wanted() {
    const { take } = TOOLS[this.name];
    return take[this.picked.length + (this._outlined ? 0 : this.points.length)] ?? "";
  }

  get _draws() {
    return this.held !== null || (this.reason === null && /point|outline/.test(this._wanted()));
  }

  async _pickNext(point, event) {
    const wanted = this._wanted();
    const room = this.page.shapes.roomAt(point);
    if (wanted === "point") {
      this.points.push(this._snap(point, event));
    } else if (wanted.includes("outline") && (this.points.length || wanted === "outline" || !room)) {
      await this._addCorner(this._snap(point, event));
      return;
    } else {
      const thing = wanted === "door" ? this._doorAt(point) : room;
      if (!thing) {
        this.page.fail(new Error(`There is no ${wanted} here, pick a ${wanted}.`));
        return;
      }
      this.picked.push(thing);
    }
    if (this._wanted()) this._update();
    else await this._send();
  }

  async _addCorner(corner) {
    const near = (other) => other && distanceTo(corner, other) < CLOSE_PX * this.floorMap.metresPerPixel;
    if (this.points.length > 2 && (near(this.points[0]) || near(this.points.at(-1)))) {
      await this._send();
      return;
    }
    if (!near(this.points.at(-1))) this.points.push(corner);
    this._update();
  }

  async _send() {
    const { name, picked, points } = this;
    const drawn = points.length ? (this._outlined ? [points] : points) : [];
    // The next line can be started while the answer is on its way.
    this.choose(name);
    try {
      const edit = await TOOLS[name].edit(...picked, ...drawn, this.page.shapes);
      if (edit) await this.page.submit(edit);
    } catch (error) {
      if (!points.length || this.busy || this.name !== name) {
        this.page.fail(error);
        return;
      }
      this._start(name, picked, points, error.message);
      this._update();
      this._showReason();
    }
  }

  // The reason stands beside the last point.
  _showReason() {
    this.page.fail(new Error(this.reason), this.points.at(-1));
  }

  // Points were taken back or moved: what was refused is no longer there.
  _change() {
    if (this.reason !== null) this.page.fail(null);
    this.reason = this.held = null;
    this._update();
  }

  async _put(point) {
    const again = this.reason !== null;
    this.points[this.held] = point;
    this._change();
    if (again) await this._send();
  }

  _update() {
    const { hints } = TOOLS[this.name];
    const step = Math.min(this.picked.length + (this._outlined ? 0 : this.points.length), hints.length - 1);
    const hint = this.held !== null ? "Set the point at its new place."
      : this.reason !== null ? "Move a point: drag it, or pick it and set it again. Or draw another line." : hints[step];
    say(this.page.writable ? hint : "");
    this.page.showPicked(this.picked);
    this.page.showDraft(this);
    this.page.keepDraft(this.busy ? { name: this.name, picked: this.picked.map(refer), points: this.points,
      reason: this.reason } : null);
    this._sketch(this._draws ? this.cross ?? null : null);
  }

  // The point to be set next goes with the pointer or the cross-hair.
  _aim(point, event) {
    this._sketch(this._draws ? this._snap(point, event) : null);
  }

  _sketch(next) {
    const shown = this.name === "select" ? null : next;
    const moved = this.held !== null && shown;
    const points = moved ? this.points.with(this.held, shown) : this.points;
    this.floorMap.sketch(points, moved ? null : shown, this._outlined);
  }

  // A point of the line goes with the finger or the mouse that is put on it.
  _grip(event) {
    const from = this.map.mouseEventToContainerPoint(event);
    const index = event.isPrimary && event.button === 0
      ? this._pointAt(toPoint(this.map.containerPointToLatLng(from)), GRIP_PX) : null;
    if (index === null || this.held !== null) return;
    this.map.dragging.disable();
    const at = (each) => this._snap(toPoint(this.map.mouseEventToLatLng(each)), each);
    const far = (each) => this.map.mouseEventToContainerPoint(each).distanceTo(from) > CLOSE_PX;
    const move = (each) => {
      if (!this.gripped && !far(each)) return;
      this.gripped = true;
      this.held = index;
      this._sketch(at(each));
    };
    const drop = (each) => {
      for (const [name, listener] of Object.entries(listeners)) window.removeEventListener(name, listener);
      this.map.dragging.enable();
      if (!this.gripped) return;
      // The click that ends a drag is none.
      window.addEventListener("click", stop, { capture: true, once: true });
      setTimeout(() => window.removeEventListener("click", stop, { capture: true }));
      this.gripped = false;
      if (each.type === "pointerup") this._put(at(each));
      else this._change();
    };
    const listeners = { pointermove: move, pointerup: drop, pointercancel: drop };
    for (const [name, listener] of Object.entries(listeners)) window.addEventListener(name, listener);
  }

  // The number of the point of the line within some pixels; null if none is.
  _pointAt(point, pixels) {
    const gaps = this.points.map((each) => distanceTo(each, point));
    const index = gaps.indexOf(Math.min(...gaps));
    return gaps[index] <= pixels * this.floorMap.metresPerPixel ? index : null;
  }

  _thingAt(point) {
    return this._doorAt(point) ?? this.page.shapes.roomAt(point);
  }

  _doorAt(point) {
    return this.page.shapes.doorAt(point, HIT_PX * this.floorMap.metresPerPixel);
  }

  // With Alt a point stays where it is.
  _snap(point, event) {
    return event?.altKey ? point : this.page.shapes.snap(point, SNAP_PX * this.floorMap.metresPerPixel) ?? point;
  }

  // The cross-hair of the keyboard: arrow keys move it, Enter picks what is below.
  _onKey(event) {
    if (event.ctrlKey || event.metaKey) return;
    const arrow = ARROWS[event.key];
    if (this.name !== "select" && arrow) {
      this._moveCross(arrow, event.shiftKey ? FINE_STEP_PX : STEP_PX);
    } else if (event.key === "Enter") {
      const point = this.cross ?? toPoint(this.map.getCenter());
      this.pick(point, event);
      if (this.name !== "select") this._showCross(point);
    } else if (event.key === "Backspace" && this.busy) {
      this.takeBack();
    } else {
      return;
    }
    event.preventDefault();
    event.stopPropagation();
  }

  _moveCross([right, down], step) {
    const from = this.cross ? L.latLng(this.cross[1], this.cross[0]) : this.map.getCenter();
    const to = this.map.containerPointToLatLng(this.map.latLngToContainerPoint(from).add([right * step, down * step]));
    if (!this.map.getBounds().pad(-0.05).contains(to)) this.map.panInside(to, { padding: [60, 60], animate: false });
    this._showCross(toPoint(to));
  }

  _showCross(point) {
    this.cross = point;
    const latLng = [point[1], point[0]];
    if (!this.crossMark) {
      const icon = L.divIcon({ className: "cross-hair", iconSize: [31, 31] });
      this.crossMark = L.marker(latLng, { icon, interactive: false, keyboard: false }).addTo(this.map);
    }
    this.crossMark.setLatLng(latLng);
    this._aim(point);
    this.page.hover(this._thingAt(point), this.map.latLngToContainerPoint(latLng));
  }

  _hideCross() {
    this.crossMark?.remove();
    this.crossMark = this.cross = undefined;
  }
}

function refer(thing) {
  return thing.rings ? { room: thing.id } : { door: thing.position };
}

function stop(event) {
  event.stopPropagation();
}

function toPoint({ lat, lng }) {
  return [lng, lat];
}
