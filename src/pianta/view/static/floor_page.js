// FloorPage: the parts of the page for one map, and what goes on between them.

import { keepDraft, readDraft } from "./drafts.js";
import { ask, byId, element, warn } from "./elements.js";
import { Explored } from "./explored.js";
import { FloorMap } from "./floor_map.js";
import { listFunctions } from "./patterns.js";
import { Predicted } from "./predicted.js";
import { RoomList } from "./room_list.js";
import { describeThing, showBuilding, showCorrections, showSelected } from "./selected.js";
import { Session } from "./session.js";
import { Shapes, distanceTo } from "./shapes.js";
import { Tools } from "./tools.js";

// How often the folder is looked at, milliseconds.
const FOLLOW_MS = 1000;
// A door after an edit is the one before it if it is no farther from it; metres, chosen by hand.
const SAME_DOOR = 0.3;
// Pixels between a point and the reason beside it; a finger on the point does not hide it.
const REASON_GAP_PX = 28;

export class FloorPage {
  constructor(source) {
    this.source = source;
    this.selected = null;
    this.floorMap = new FloorMap(byId("map"));
    this.list = new RoomList((room, focus) => this.select(room, true, focus), (room) => this._mark(room));
    this.tools = new Tools(this.floorMap, this);
    this._makeTools();
    this._makeLayers();
    for (const name of ["undo", "redo", "save"]) byId(name).onclick = () => this[name]();
    byId("take-back").onclick = () => this.tools.takeBack();
    byId("finish").onclick = () => this.tools.finish();
    byId("stop").onclick = () => this.cancel();
    this.floorMap.map.on("move zoom resize", () => this._placeReason());
    window.addEventListener("beforeunload", (event) => {
      if (this.session?.unsaved) event.preventDefault();
    });
    // In sight of the page alone; the next look is one period after the answer.
    const follow = async () => {
      if (this.session && !this.source.readOnly && !document.hidden) await this._follow();
      setTimeout(follow, FOLLOW_MS);
    };
    setTimeout(follow, FOLLOW_MS);
  }

  get writable() {
    return this.session?.state !== undefined && this.session.writable;
  }

  // Show a map; where a fault hinders it, say so.
  async open(number) {
    this.close();
    const session = new Session(this.source, number, {
      changed: (each, reloaded) => each === this.session && this._show(reloaded),
      conflict: (each, fault) => each === this.session && this._askAboutConflict(fault),
    });
    this.session = session;
    this.fitted = false;
    try {
      await session.open();
      const draft = session === this.session && this.writable && readDraft(session);
      if (draft) this.tools.resume(draft);
    } catch (fault) {
      if (session === this.session) this.fail(fault);
    }
  }

  close() {
    this.session = null;
    this.selected = null;
    this.results?.remove();
    this.results = null;
    // The draft of the map that is left stays in the store.
    this.tools.choose("select");
    this.fail(null);
  }

  // The tools draw on it.
  get shapes() {
    return this._shapes ?? EMPTY;
  }

  select(thing, show = false, focus = false) {
    this.selected = thing;
    this.list.select(thing?.rings ? thing.id : null);
    showSelected(thing, this);
    this._mark();
    if (thing?.rings && show) this.floorMap.showRoom(thing);
    if (focus) byId("selected").querySelector("input, button")?.focus();
  }

  hover(thing, at) {
    const tip = byId("tip");
    const latLng = at && this.floorMap.map.containerPointToLatLng(at);
    const texts = [thing && describeThing(thing, this.shapes), at && this.results?.describe([latLng.lng, latLng.lat])];
    tip.hidden = !at || !texts.some(Boolean);
    if (!tip.hidden) {
      tip.textContent = texts.filter(Boolean).join("\n\n");
      const { x, y } = this.floorMap.map.getSize();
      tip.style.left = `${Math.max(4, Math.min(at.x + 16, x - tip.offsetWidth - 8))}px`;
      tip.style.top = `${Math.max(4, Math.min(at.y + 16, y - tip.offsetHeight - 8))}px`;
    }
    if (thing !== this.hovered) this._mark(thing);
  }

  // Buttons for those who draw without keys.
  showDraft(tools) {
    byId("draft").hidden = !tools.busy;
    byId("finish").disabled = !tools.canFinish;
    byId("finish").textContent = tools.reason === null ? "Finish" : "Try again";
  }

  keepDraft(draft) {
    if (this.session?.disk) keepDraft(this.session, draft);
  }

  showPicked(things) {
    this.picked = things;
    this._mark();
  }

  toolChanged(name) {
    for (const button of byId("tools").children) {
      button.setAttribute("aria-pressed", String(button.dataset.tool === name));
    }
    byId("map").classList.toggle("drawing", name !== "select");
  }

  useTool(name, picked = []) {
    if (!this.writable) return;
    this.tools.choose(name, picked);
    byId("map").focus({ preventScroll: true });
  }

  async submit(edit) {
    await this.session.edit(edit);
    this.fail(null);
  }

  async send(edit) {
    await this._try(() => this.submit(edit));
  }

  async removeCorrection(index) {
    await this._try(() => this.session.remove(index));
  }

  async undo() {
    await this._try(() => this.session.undo());
  }

  async redo() {
    await this._try(() => this.session.redo());
  }

  async save() {
    if (!this.writable || !this.session.unsaved) return;
    await this._try(() => this.session.save(), "Saved.");
  }

  fit() {
    this.floorMap.fit(this.shapes, this.session.state.background);
  }

  cancel() {
    this.tools.cancel();
  }

  // fault: null when there is none any more. point: of the map, beside which the reason stands.
  fail(fault, point = null) {
    warn(fault?.message ?? "");
    this.faultAt = point;
    this._placeReason();
  }

  _placeReason() {
    const box = byId("alert");
    const { map } = this.floorMap;
    box.classList.toggle("beside", this.faultAt !== null);
    box.style.left = box.style.top = "";
    if (this.faultAt === null) return;
    const at = map.latLngToContainerPoint([this.faultAt[1], this.faultAt[0]]);
    const { x, y } = map.getSize();
    const top = at.y + REASON_GAP_PX + box.offsetHeight < y ? at.y + REASON_GAP_PX : at.y - REASON_GAP_PX - box.offsetHeight;
    box.style.left = `${Math.max(8, Math.min(at.x - box.offsetWidth / 2, x - box.offsetWidth - 8))}px`;
    box.style.top = `${Math.max(8, Math.min(top, y - box.offsetHeight - 8))}px`;
  }

  async _try(task, done = "") {
    try {
      await task();
      this.fail(null);
      if (done) byId("hint").textContent = done;
    } catch (fault) {
      this.fail(fault);
    }
  }

  _show(reloaded) {
    const { state } = this.session;
    this._shapes = new Shapes(state);
    this.floorMap.draw(this.shapes, state.background);
    this.floorMap.showScale(state.areas);
    if (!this.fitted) this.fit();
    this.fitted = true;
    this.list.setRooms(this.shapes.rooms, null, state.areas);
    this.select(this._findAgain(this.selected));
    byId("legend").replaceChildren(...listFunctions(this.shapes.rooms));
    showBuilding(state, this);
    showCorrections(state, this);
    this._showNames(state);
    this._showHeader(state);
    this._showResults();
    if (reloaded) {
      this.fail(null);
      byId("hint").textContent = "The files have changed; this is the new floor.";
    }
  }

  _showHeader(state) {
    const { session, writable } = this;
    byId("title").textContent = state.name;
    document.title = `${session.unsaved ? "• " : ""}${state.name}, pianta`;
    byId("summary").textContent = state.problem && !this.source.readOnly ? `Read-only: ${state.problem}`
      : session.unsaved ? "Not saved" : "";
    const isResult = Boolean(session.disk.kind);
    byId("history").hidden = this.source.readOnly || isResult;
    byId("corrections-part").hidden = isResult;
    byId("undo").disabled = !session.canUndo;
    byId("redo").disabled = !session.canRedo;
    byId("save").disabled = !writable || !session.unsaved;
    byId("tools").hidden = !writable;
    byId("layers-part").open ||= this.source.readOnly;
  }

  // A prediction or an exploration has more than a floor; a step of it stays as long as its files are the same.
  _showResults() {
    const { disk } = this.session;
    if (this.results?.version === disk.version) return;
    this.results?.remove();
    const kinds = { prediction: Predicted, exploration: Explored };
    this.results = disk.kind in kinds ? new kinds[disk.kind](this, disk) : null;
  }

  // The floor of another step of the results; the view stays.
  showStep(part) {
    this.session.state = { ...this.session.disk, ...part };
    this._show(false);
  }

  _showNames(state) {
    const labels = new Map(state.labels.map(({ label, schema }) => [label, schema]).reverse());
    byId("label-names").replaceChildren(
      ...[...labels].reverse().map(([label, schema]) => element("option", { value: label, label: `${label} (${schema})` })));
    byId("type-names").replaceChildren(
      ...[...new Set(state.labels.map((each) => each.schema))].map((value) => element("option", { value })));
  }

  _findAgain(thing) {
    if (!thing) return null;
    if (thing.rings) return this.shapes.byId.get(thing.id) ?? null;
    return this.shapes.doors.find((door) => distanceTo(door.position, thing.position) < SAME_DOOR) ?? null;
  }

  _mark(hovered = null) {
    this.hovered = hovered;
    const marks = (this.picked ?? []).map((thing) => ({ thing, className: "mark mark-picked" }));
    if (this.selected) marks.push({ thing: this.selected, className: "mark mark-selected" });
    if (hovered) marks.push({ thing: hovered, className: "mark mark-hovered" });
    this.floorMap.mark(marks);
  }

  async _follow() {
    const { session } = this;
    try {
      await session.follow();
      if (this.lost) this.fail(null);
      this.lost = false;
    } catch (fault) {
      if (session === this.session && !this.lost) this.fail(fault);
      this.lost = true;
    }
  }

  async _askAboutConflict(fault) {
    if (byId("dialog").open) return;
    const { session } = this;
    const text = `The files of ${session.disk.name} have changed on disk, and this tab has corrections that are not saved.`;
    const answer = await ask(text, [
      { text: "Load the new floor with my corrections", value: "keep", main: true },
      { text: "Load it without them", value: "drop" },
      { text: "Stay with the old floor", value: null },
    ]);
    if (answer) await this._try(() => session.reload(answer === "keep"));
    else this.fail(fault ?? new Error("The files have changed on disk. Saving will ask again."));
  }

  _makeTools() {
    byId("tools").replaceChildren(...Object.entries(Tools.all).map(([name, { text, key, hints }]) => {
      const button = element("button", { type: "button", title: `${hints[0]} (${key.toUpperCase()})`,
        onclick: () => this.useTool(name) }, text);
      button.dataset.tool = name;
      return button;
    }));
    this.toolChanged("select");
  }

  _makeLayers() {
    byId("layers").replaceChildren(...Object.entries(FloorMap.layerNames).map(([name, text]) =>
      element("label", {}, element("input", { type: "checkbox", name, checked: this.floorMap.isOn(name),
        onchange: (event) => this.floorMap.switchLayer(name, event.target.checked) }), text)));
  }
}

const EMPTY = new Shapes({ floor: { features: [] }, graph: [] });
