// The fill of what is predicted: strokes, on the colour of a label if there is one.

const SVG = "http://www.w3.org/2000/svg";
const SIZE = 9;
const NONE = "none";
// A fill is found by its id in the whole page, and a hidden svg gives none: each svg has its own.
const numbers = new WeakMap();
let count = 0;

// The id of the pattern, which is made in the svg when it is needed for the first time.
export function addHatch(svg, colour = NONE) {
  const plain = /^#[0-9a-f]{6}$/i.test(colour) ? colour : NONE;
  if (!numbers.has(svg)) numbers.set(svg, (count += 1));
  const id = `hatch-${numbers.get(svg)}-${plain.replace("#", "")}`;
  if (svg.querySelector(`#${id}`)) return id;
  const pattern = make("pattern", { id, width: SIZE, height: SIZE, patternUnits: "userSpaceOnUse" });
  if (plain !== NONE) pattern.append(make("rect", { width: SIZE, height: SIZE, fill: plain, "fill-opacity": 0.55 }));
  pattern.append(make("path", { d: `M0 0L${SIZE} ${SIZE}M-1 ${SIZE - 1}L1 ${SIZE + 1}M${SIZE - 1} -1L${SIZE + 1} 1`, class: "hatch" }));
  let defs = svg.querySelector("defs");
  if (!defs) svg.prepend((defs = make("defs", {})));
  defs.append(pattern);
  return id;
}

function make(tag, attributes) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}
