// Buildings of a collection as shapes, of floors or of graphs, and small drawings of them.

import { addHatch } from "./hatch.js";
import { Shapes } from "./shapes.js";

const SVG = "http://www.w3.org/2000/svg";
const NEUTRAL = "#cfd4da";
// Radius of a room of a graph, and half the side of a corridor of the same area; the shortest edges have length 1.
const RADIUS = 0.36;
const HALF_SIDE = 0.32;
const ROUND_STEPS = 24;

// {nodes: [{id, label, colour, corridor, rings, box, centre, known, area}], edges: [[point, …]], metres}
export function readShapes(part) {
  return part.nodes ? readGraph(part) : readFloor(part);
}

function readGraph({ nodes, edges }) {
  const predicts = nodes.some((node) => node.room !== null);
  return {
    metres: false,
    nodes: nodes.map((node) => ({ ...node, name: null, known: !predicts || node.room !== null, rings: [outline(node)],
      centre: node.position, box: boxAround(node.position) })),
    edges: edges.map((ends) => ends.map((index) => nodes[index].position)),
  };
}

function readFloor(part) {
  const { rooms, doors } = new Shapes(part);
  return { metres: true, nodes: rooms.map((room) => ({ ...room, known: true, corridor: false })), edges: doors.map((door) => door.line) };
}

function outline({ position: [x, y], corridor }) {
  if (corridor) return [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => [x + a * HALF_SIDE, y + b * HALF_SIDE]);
  return Array.from({ length: ROUND_STEPS }, (_, step) => {
    const angle = (2 * Math.PI * step) / ROUND_STEPS;
    return [x + RADIUS * Math.cos(angle), y + RADIUS * Math.sin(angle)];
  });
}

// The texts of a node may be wider than it.
function boxAround([x, y]) {
  return [x - 0.5, y - 0.5, x + 0.5, y + 0.5];
}

export function boxOfAll(nodes) {
  const sides = [0, 1, 2, 3].map((side) => nodes.map((node) => node.box[side]));
  return [Math.min(...sides[0]), Math.min(...sides[1]), Math.max(...sides[2]), Math.max(...sides[3])];
}

export function colourOf({ colour }) {
  return /^#[0-9a-f]{6}$/i.test(colour ?? "") ? colour : NEUTRAL;
}

export function drawSmallGraph({ nodes, edges, metres }) {
  if (!nodes.length) return make("svg", { role: "img" });
  const [left, bottom, right, top] = boxOfAll(nodes);
  const svg = make("svg", { viewBox: `${left} ${-top} ${right - left || 1} ${top - bottom || 1}`, role: "img" });
  const lines = edges.map((edge) => make("path", { d: pathOf([edge], false), class: metres ? "small-door" : "small-edge" }));
  const shapes = nodes.map((node) => make("path", { d: pathOf(node.rings, true), "fill-rule": "evenodd",
    fill: node.known ? colourOf(node) : `url(#${addHatch(svg, colourOf(node))})`, class: node.known ? "small-room" : "small-room small-predicted" }));
  // Doors lie on the borders of rooms, edges between the middles of nodes.
  svg.append(...(metres ? [...shapes, ...lines] : [...lines, ...shapes]));
  return svg;
}

function pathOf(lines, closed) {
  return lines.map((line) => `M${line.map(([x, y]) => `${x.toFixed(2)} ${(-y).toFixed(2)}`).join("L")}${closed ? "Z" : ""}`).join("");
}

function make(tag, attributes) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}
