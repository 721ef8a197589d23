// Tools: what a click, a tap or Enter on the map means, until an edit is complete.

import { ask, element, say } from "./elements.js";
import { distanceTo } from "./shapes.js";

// Pixels within which points snap, doors are hit, and an outline is closed; chosen by hand.
const SNAP_PX = 12;
const HIT_PX = 10;
const CLOSE_PX = 8;
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
  // page: {shapes, submit(edit), select(thing), fail(error), hover(thing, point), writable}
  constructor(floorMap, page) {
    this.floorMap = floorMap;
    this.map = floorMap.map;
    this.page = page;
    this.picked = [];
    this.points = [];
    this.name = "select";
    this.map.on("click", (event) => this.pick(toPoint(event.latlng), event.originalEvent));
    this.map.on("mousemove", (event) => this.point(toPoint(event.latlng), event.originalEvent));
    this.map.on("mouseout", () => this.page.hover(null));
    this.map.getContainer().addEventListener("keydown", (event) => this._onKey(event));
  }

  static get all() {
    return TOOLS;
  }

  get busy() {
    return this.points.length > 0 || this.picked.length > 0;
  }

  choose(name, picked = []) {
    this.name = name;
    this.picked = picked;
    this.points = [];
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
    this._hideCross();
    if (this._wanted() === "point" || this._wanted().includes("outline")) {
      this._sketch(this._snap(point, event));
    }
    this.page.hover(this._thingAt(point), this.map.latLngToContainerPoint([point[1], point[0]]));
  }

  async pick(point, event) {
    const wanted = this._wanted();
    if (this.name === "select") {
      this.page.select(this._thingAt(point));
      return;
    }
    if (wanted === "room or outline" && !this.points.length && this.page.shapes.roomAt(point)) {
      await this._take(this.page.shapes.roomAt(point));
    } else if (wanted.includes("outline")) {
      await this._addCorner(this._snap(point, event));
    } else if (wanted === "point") {
      await this._take(this._snap(point, event));
    } else {
      const thing = wanted === "door" ? this._doorAt(point) : this.page.shapes.roomAt(point);
      if (thing) await this._take(thing);
      else this.page.fail(new Error(`There is no ${wanted} here, pick a ${wanted}.`));
    }
  }

  _wanted() {
    return TOOLS[this.name].take[this.picked.length] ?? "";
  }

  async _addCorner(corner) {
    const near = (other) => other && distanceTo(corner, other) < CLOSE_PX * this.floorMap.metresPerPixel;
    if (this.points.length > 2 && (near(this.points[0]) || near(this.points.at(-1)))) {
      await this._take([...this.points]);
      return;
    }
    if (!near(this.points.at(-1))) this.points.push(corner);
    this._update();
  }

  async _take(what) {
    this.picked.push(what);
    this.points = this.picked.filter(Array.isArray).filter((each) => typeof each[0] === "number");
    const { take, edit } = TOOLS[this.name];
    if (this.picked.length < take.length) {
      this._update();
      return;
    }
    const picked = this.picked;
    this.choose(this.name);
    try {
      const made = await edit(...picked, this.page.shapes);
      if (made) await this.page.submit(made);
    } catch (error) {
      this.page.fail(error);
    }
  }

  _update() {
    const { hints } = TOOLS[this.name];
    say(this.page.writable ? hints[Math.min(this.picked.length, hints.length - 1)] : "");
    this.page.showPicked(this.picked.filter((each) => !Array.isArray(each)));
    this._sketch(this.cross ?? null);
  }

  _sketch(next) {
    this.floorMap.sketch(this.points, this.name === "select" ? null : next, this._wanted().includes("outline"));
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
    } else if (event.key === "Backspace" && this.points.length) {
      this.points.pop();
      if (TOOLS[this.name].take[0] !== "outline" && !this._wanted().includes("outline")) this.picked.pop();
      this._update();
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
    const drawing = this._wanted() === "point" || this._wanted().includes("outline");
    this._sketch(drawing ? this._snap(point) : null);
    this.page.hover(this._thingAt(point), this.map.latLngToContainerPoint(latLng));
  }

  _hideCross() {
    this.crossMark?.remove();
    this.crossMark = this.cross = undefined;
  }
}

function toPoint({ lat, lng }) {
  return [lng, lat];
}
