// The floor as the page needs it: rooms and doors by id, what is at a point, and points to snap to. Metres.

export class Shapes {
  constructor(state) {
    const of = (name) => state.floor.features.filter((feature) => feature.properties.class === name);
    this.rooms = of("room").map(readRoom);
    this.byId = new Map(this.rooms.map((room) => [room.id, room]));
    this.doors = of("door").map(readDoor);
    this.possibleDoors = of("possible_door").map(readDoor);
    this.walls = of("wall").map((feature) => feature.geometry.coordinates);
    this.furniture = of("furniture").map((feature) => feature.geometry.coordinates);
    this.graph = state.graph;
    this.areas = state.areas;
  }

  roomAt(point) {
    return this.rooms.find((room) => inBox(point, room.box) && inRings(point, room.rings)) ?? null;
  }

  // The nearest door within a distance, metres.
  doorAt(point, distance) {
    let best = null;
    let least = distance;
    for (const door of this.doors) {
      const gap = distanceTo(point, nearestOn(point, ...door.line));
      if (gap <= least) [best, least] = [door, gap];
    }
    return best;
  }

  // The room of which a line has most; null if it is in none.
  roomAlong(line) {
    const counts = new Map();
    for (let step = 1; step < LINE_STEPS; step += 1) {
      const room = this.roomAt(between(...line, step / LINE_STEPS));
      if (room) counts.set(room, (counts.get(room) ?? 0) + 1);
    }
    return [...counts].sort((a, b) => b[1] - a[1])[0]?.[0] ?? null;
  }

  doorsOf(room) {
    return this.doors.filter((door) => door.rooms.includes(room.id));
  }

  // The corner within a distance, else the nearest point of a wall or a border; null if all are farther.
  snap(point, distance) {
    let corner = null;
    let side = null;
    let [toCorner, toSide] = [distance, distance];
    for (const line of this._linesNear(point, distance)) {
      for (let index = 0; index < line.length; index += 1) {
        const gap = distanceTo(point, line[index]);
        if (gap < toCorner) [corner, toCorner] = [line[index], gap];
        if (index === 0) continue;
        const near = nearestOn(point, line[index - 1], line[index]);
        const sideGap = distanceTo(point, near);
        if (sideGap < toSide) [side, toSide] = [near, sideGap];
      }
    }
    return corner ?? side;
  }

  *_linesNear(point, distance) {
    for (const room of this.rooms) if (inBox(point, room.box, distance)) yield* room.rings;
    yield* this.walls;
  }
}

// Points along a line at which its rooms are looked up.
const LINE_STEPS = 60;

function readRoom(feature) {
  const { room: id, predicted, ...properties } = feature.properties;
  const rings = feature.geometry.coordinates;
  return { ...properties, id, rings, box: boxOf(rings[0]), predicted: predicted?.coordinates ?? null };
}

function readDoor(feature) {
  const line = feature.geometry.coordinates;
  const ends = [line[0], line[line.length - 1]];
  return { ...feature.properties, id: feature.id, line: ends, position: between(...ends, 0.5) };
}

function boxOf(ring) {
  const xs = ring.map(([x]) => x);
  const ys = ring.map(([, y]) => y);
  return [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
}

export function inBox([x, y], [left, bottom, right, top], margin = 0) {
  return x >= left - margin && x <= right + margin && y >= bottom - margin && y <= top + margin;
}

// By the number of borders that a ray to the right crosses.
export function inRings([x, y], rings) {
  let inside = false;
  for (const ring of rings) {
    for (let index = 1; index < ring.length; index += 1) {
      const [[x1, y1], [x2, y2]] = [ring[index - 1], ring[index]];
      if (y1 > y !== y2 > y && x < x1 + ((y - y1) / (y2 - y1)) * (x2 - x1)) inside = !inside;
    }
  }
  return inside;
}

export function between([x1, y1], [x2, y2], share) {
  return [x1 + (x2 - x1) * share, y1 + (y2 - y1) * share];
}

export function distanceTo([x1, y1], [x2, y2]) {
  return Math.hypot(x2 - x1, y2 - y1);
}

function nearestOn(point, start, end) {
  const square = distanceTo(start, end) ** 2;
  if (square === 0) return start;
  const along = (point[0] - start[0]) * (end[0] - start[0]) + (point[1] - start[1]) * (end[1] - start[1]);
  return between(start, end, Math.min(1, Math.max(0, along / square)));
}
