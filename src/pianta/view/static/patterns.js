// Fills of rooms: the colour of their function, and a pattern, so that nobody has to tell them apart by colour alone.

import { element } from "./elements.js";

const SVG = "http://www.w3.org/2000/svg";
const SIZE = 12;
const DARK_INK = "rgb(16 22 31 / 45%)";
const LIGHT_INK = "rgb(255 255 255 / 60%)";
// Of each function: its name in the legend, the strokes of a tile of SIZE by SIZE pixels, and their colour.
const FUNCTIONS = {
  FUNCTIONAL: { text: "Functional, or a room of any use", strokes: "M4.8 6H7.2", ink: DARK_INK },
  CONNECTION: { text: "Connection: corridor, hall, lobby", strokes: "M0 12L12 0M-2 2L2 -2M10 14L14 10", ink: DARK_INK },
  ENTRANCE: { text: "Entrance, stairs, elevator", strokes: "M0 6H12M6 0V12", ink: LIGHT_INK },
  SERVICE: { text: "Service", strokes: "M1 3L4 0L7 3M7 9L10 6L13 9M-5 9L-2 6L1 9", ink: DARK_INK },
  UNKNOWN: { text: "Unknown: no label, or one of no schema", strokes: "M2 6H10", ink: DARK_INK },
};
const NEUTRAL = "#cfd4da";
// Tiles and their addresses, by colour and function.
const tiles = new Map();

export function colourOf(room) {
  return /^#[0-9a-f]{6}$/i.test(room.colour ?? "") ? room.colour : NEUTRAL;
}

// What a canvas fills a room with.
export function fillOf(room, context) {
  const tile = tileOf(room);
  return tile ? context.createPattern(tile.canvas, "repeat") : colourOf(room);
}

// A small field with the fill of a room, for the list and the legend.
export function showFill(field, room) {
  field.style.backgroundColor = colourOf(room);
  const tile = tileOf(room);
  if (tile) field.style.backgroundImage = `url(${(tile.url ??= tile.canvas.toDataURL())})`;
}

// What the fills of rooms mean, as items of a list.
export function listFunctions(rooms) {
  return Object.keys(FUNCTIONS).flatMap((name) => {
    const room = rooms.find((each) => each.function === name);
    if (!room) return [];
    const field = element("span", { className: "colour" });
    showFill(field, room);
    return element("li", {}, field, FUNCTIONS[name].text);
  });
}

// The tile of a room with a function; null without one, where no room of the floor has a label.
function tileOf(room) {
  if (!(room.function in FUNCTIONS)) return null;
  const key = `${colourOf(room)} ${room.function}`;
  if (!tiles.has(key)) tiles.set(key, { canvas: drawTile(colourOf(room), FUNCTIONS[room.function]) });
  return tiles.get(key);
}

function drawTile(colour, { strokes, ink }) {
  const tile = document.createElement("canvas");
  tile.width = tile.height = SIZE;
  const context = tile.getContext("2d");
  context.fillStyle = colour;
  context.fillRect(0, 0, SIZE, SIZE);
  context.strokeStyle = ink;
  context.lineWidth = 1.2;
  context.stroke(new Path2D(strokes));
  return tile;
}

function svgElement(tag, attributes) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}

// A small drawing of the rooms of a floor, for the gallery.
export function drawSmall(rooms) {
  const boxes = rooms.map((room) => room.box);
  const [left, bottom] = [0, 1].map((side) => Math.min(...boxes.map((box) => box[side])));
  const [right, top] = [2, 3].map((side) => Math.max(...boxes.map((box) => box[side])));
  const svg = svgElement("svg", { viewBox: `${left} ${-top} ${right - left || 1} ${top - bottom || 1}`, role: "img" });
  for (const room of rooms) {
    const d = room.rings.map((ring) => `M${ring.map(([x, y]) => `${x.toFixed(2)} ${(-y).toFixed(2)}`).join("L")}Z`);
    svg.append(svgElement("path", { d: d.join(""), fill: colourOf(room), "fill-rule": "evenodd", class: "small-room" }));
  }
  return svg;
}
