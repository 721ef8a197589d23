// Fills of rooms: a colour, and a pattern by which those who see colours differently tell labels apart.

const SVG = "http://www.w3.org/2000/svg";
const SIZE = 10;
// Strokes of a tile of SIZE by SIZE pixels, by the coarse label of a room.
const STROKES = {
  CONNECTION: "M0 10L10 0M-2 2L2 -2M8 12L12 8",
  CORRIDOR: "M0 10L10 0M-2 2L2 -2M8 12L12 8",
  ENTRANCE: "M0 5H10M5 0V10",
  SERVICE: "M2 5h1M7 0h1M7 10h1",
};
const NEUTRAL = "#cfd4da";

export function kindOf(room) {
  const labels = [room.labels?.["F/C/E/S"], room.label, room.labels?.["R/C"]];
  return labels.find((label) => label in STROKES) ?? "";
}

// The value of `fill` of a room; its pattern is made in the svg when it is needed for the first time.
export function fillOf(room, svg) {
  const colour = /^#[0-9a-f]{6}$/i.test(room.colour ?? "") ? room.colour : NEUTRAL;
  const kind = kindOf(room);
  if (!kind) return colour;
  const id = `fill-${kind}-${colour.slice(1)}`;
  if (!document.getElementById(id)) addPattern(svg, id, colour, kind);
  return `url(#${id})`;
}

function addPattern(svg, id, colour, kind) {
  const pattern = svgElement("pattern", { id, width: SIZE, height: SIZE, patternUnits: "userSpaceOnUse" });
  pattern.append(
    svgElement("rect", { width: SIZE, height: SIZE, fill: colour }),
    svgElement("path", { d: STROKES[kind], class: "pattern", fill: "none" }),
  );
  let defs = svg.querySelector("defs");
  if (!defs) svg.prepend((defs = svgElement("defs", {})));
  defs.append(pattern);
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
    const fill = /^#[0-9a-f]{6}$/i.test(room.colour ?? "") ? room.colour : NEUTRAL;
    svg.append(svgElement("path", { d: d.join(""), fill, "fill-rule": "evenodd", class: "small-room" }));
  }
  return svg;
}
