// What is known of the selected room or door, of the building, and of the corrections; with the fields that mend them.

import { byId, element, formatArea, formatShare } from "./elements.js";
import { changeEdit } from "./tools.js";

// Labels of which the probability is shown.
const SHOWN_LABELS = 4;

// Put content into a box, and keep what somebody is typing there.
function refill(box, ...content) {
  const active = box.contains(document.activeElement) ? document.activeElement : null;
  const typed = active?.name ? { name: active.name, value: active.value, dirty: active.value !== active.defaultValue } : null;
  const key = box.dataset.thing;
  box.replaceChildren(...content.filter(Boolean));
  if (!typed || key !== box.dataset.shown) return;
  const field = box.querySelector(`[name="${typed.name}"]`);
  if (field && typed.dirty && field.defaultValue !== typed.value) field.value = typed.value;
  field?.focus();
}

function fact(name, ...value) {
  return [element("dt", {}, name), element("dd", {}, ...value)];
}

function button(text, onclick, more = {}) {
  return element("button", { type: "button", onclick, ...more }, text);
}

// A field whose Enter or button sends its text.
function field({ name, text, value, list, type = "text", send, writable, max = 200 }) {
  const input = element("input", { name, type, defaultValue: value, value, maxLength: max, autocomplete: "off",
    readOnly: !writable, step: "any", min: "0", ...(list ? { list } : {}) });
  return element("form", { className: "field", onsubmit: (event) => {
    event.preventDefault();
    if (input.value !== input.defaultValue) send(input.value);
  } }, element("label", {}, element("span", {}, text), input), writable ? element("button", { type: "submit" }, "Set") : null);
}

function bars(probabilities) {
  const shown = Object.entries(probabilities).sort((a, b) => b[1] - a[1]).slice(0, SHOWN_LABELS);
  return element("ul", { className: "bars" }, ...shown.filter(([, share]) => share >= 0.005).map(([name, share]) =>
    element("li", {}, element("meter", { value: share, min: 0, max: 1, "aria-label": name }),
      element("span", {}, `${name} ${formatShare(share)}`))));
}

// The probabilities of the finest set of labels that is known of a room.
export function finestLabels(room) {
  const sets = Object.entries(room.label_probabilities ?? {});
  const own = sets.filter(([, shares]) => room.label in shares);
  return (own.at(-1) ?? sets.at(-1))?.[1] ?? {};
}

export function describeThing(thing, shapes) {
  if (!thing.rings) {
    const rooms = thing.rooms.map((id) => (id === null ? "outside" : `room ${id}`)).join(" and ");
    return `${thing.kind === "opening" ? "Opening" : "Door"} between ${rooms}, ${thing.width.toFixed(2)} m`;
  }
  const share = finestLabels(thing)[thing.label];
  const label = thing.label ? `${thing.label}${share === undefined ? "" : ` ${formatShare(share)}`}` : "no label";
  const neighbours = thing.neighbours.length ? `, next to ${thing.neighbours.join(", ")}` : "";
  const name = thing.title ? ` “${thing.title}”` : "";
  return `Room ${thing.id}${name}\n${label}\n${formatArea(thing.area, shapes.areas)}, doors: ${shapes.doorsOf(thing).length}${neighbours}`;
}

function roomFacts(room, page) {
  const { shapes } = page;
  const links = (ids) => ids.map((id) => button(String(id), () => page.select(shapes.byId.get(id), true), { className: "link" }));
  const stairs = (page.session?.state?.links ?? []).filter((each) => each.room === room.id);
  const doors = shapes.doorsOf(room).map((door) =>
    button(door.kind === "opening" ? "opening" : "door", () => page.select(door), { className: "link" }));
  return element("dl", {},
    ...fact("Area", formatArea(room.area, shapes.areas)),
    ...fact("Doors", ...(doors.length ? doors : ["none"])),
    ...fact("Neighbours", ...(room.neighbours.length ? links(room.neighbours) : ["none"])),
    ...stairs.flatMap((each) => fact(each.kind === "lift" ? "Lift" : "Stairs", element("a", { className: "link",
      href: `#map=${each.map}&room=${each.to}` }, `${each.storey}, room ${each.to}`))),
    ...(room.probability === null ? [] : fact("One room", `${formatShare(room.probability)} probable`)),
    ...(room.partial ? fact("Partial", room.confidence == null ? "borders on unexplored space"
      : `predicted shape, expected IoU ${room.confidence.toFixed(2)}`) : []));
}

// A doubtful area is no proposal.
function trueArea(room, { areas }) {
  return areas && areas.trust !== "exact" ? "" : room.area.toFixed(1);
}

function roomContent(room, page) {
  const { writable } = page;
  const edit = (members) => page.send({ room: room.id, ...members });
  return [
    element("h2", {}, `Room ${room.id}`),
    field({ name: "name", text: "Name", value: room.name ?? "", writable,
      send: (value) => edit({ kind: "name", name: value.trim() || null }) }),
    field({ name: "number", text: "Number", value: room.number ?? "", writable,
      send: (value) => edit({ kind: "number", number: value.trim() || null }) }),
    field({ name: "label", text: "Label", value: room.label ?? "", list: "label-names", writable,
      send: (value) => edit({ kind: "label", label: value.trim() || null }) }),
    bars(finestLabels(room)),
    roomFacts(room, page),
    writable && field({ name: "area", text: "True area, m²", type: "number", value: trueArea(room, page.shapes), writable,
      send: (value) => edit({ kind: "area", area: Number(value) }) }),
    writable && element("div", { className: "answers" },
      button("Merge with …", () => page.useTool("merge", [room])), button("Split …", () => page.useTool("split")),
      button("Delete", () => edit({ kind: "delete room" })), button("Outside", () => edit({ kind: "outside" }))),
  ];
}

function doorContent(door, page) {
  const rooms = door.rooms.flatMap((id) => (id === null ? ["outside "]
    : [button(String(id), () => page.select(page.shapes.byId.get(id)), { className: "link" })]));
  const other = door.kind === "opening" ? "Make it a door" : "Make it an opening";
  return [
    element("h2", {}, door.kind === "opening" ? "Opening" : "Door"),
    element("dl", {}, ...fact("Rooms", ...rooms), ...fact("Width", `${door.width.toFixed(2)} m`),
      ...(door.probability == null ? [] : fact("Probability", formatShare(door.probability)))),
    page.writable && element("div", { className: "answers" },
      button(other, () => page.send(changeEdit(door))), button("Move …", () => page.useTool("move", [door])),
      button("Delete", () => page.send({ kind: "delete door", position: door.position }))),
  ];
}

export function showSelected(thing, page) {
  const box = byId("selected");
  box.dataset.thing = thing ? `${thing.rings ? "room" : "door"} ${thing.id}` : "";
  const none = element("p", { className: "quiet" }, "Nothing. Pick a room or a door on the map, or a room in the list.");
  refill(box, ...(thing ? (thing.rings ? roomContent(thing, page) : doorContent(thing, page)) : [none]));
  box.dataset.shown = box.dataset.thing;
}

export function showBuilding(state, page) {
  const type = Object.entries(state.building_type).sort((a, b) => b[1] - a[1])[0]?.[0] ?? "";
  const area = page.shapes.rooms.reduce((sum, room) => sum + room.area, 0);
  const openings = page.shapes.doors.filter((door) => door.kind === "opening").length;
  refill(byId("building"),
    element("dl", {}, ...fact("Rooms", String(page.shapes.rooms.length)), ...fact("Area", formatArea(area, page.shapes.areas)),
      ...fact("Doors", `${page.shapes.doors.length - openings}, and ${openings} openings`)),
    field({ name: "type", text: "Type", value: type, list: "type-names", writable: page.writable,
      send: (value) => page.send({ kind: "type", building_type: value.trim() || null }) }),
    bars(state.building_type),
    page.writable && element("div", { className: "answers" },
      button("Scale by a length …", () => page.useTool("length"))));
}

export function showCorrections(state, page) {
  const items = state.corrections.map((correction, index) => element("li", { className: correction.problem ? "problem" : "" },
    element("span", {}, correction.text),
    correction.problem ? element("span", { className: "why" }, `Does not fit: ${correction.problem}`) : null,
    page.writable ? button("Remove", () => page.removeCorrection(index), { title: `Remove: ${correction.text}` }) : null));
  byId("corrections").replaceChildren(...items);
  byId("corrections-count").textContent = `(${items.length})`;
}
