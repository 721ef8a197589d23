// Timeline: a slider over steps, with a button that plays them. Arrow keys move it.

import { element } from "./elements.js";

// A step while it plays, milliseconds.
const PLAY_MS = 700;
const MOVES = { ArrowLeft: -1, ArrowRight: 1 };

export class Timeline {
  // texts: of the steps. onStep(index) may give a promise; the next step waits for it. name: what a step is called.
  constructor(texts, onStep, { start = 0, name = "Step" } = {}) {
    this.texts = texts;
    this.onStep = onStep;
    this.index = start;
    this.slider = element("input", { type: "range", min: "0", max: String(texts.length - 1), step: "1",
      value: String(start), "aria-label": name, oninput: () => this.go(Number(this.slider.value)) });
    this.button = element("button", { type: "button", onclick: () => (this.playing ? this.stop() : this.play()) }, "Play");
    this.text = element("output", {}, "");
    this.box = element("div", { id: "timeline", role: "group", "aria-label": name }, this.button, this.slider, this.text);
    this.listener = (event) => this._onKey(event);
    document.addEventListener("keydown", this.listener);
    this._tell();
  }

  async go(index) {
    const wanted = Math.max(0, Math.min(this.texts.length - 1, index));
    if (wanted === this.index) return;
    this.index = wanted;
    this._tell();
    await this.onStep(wanted);
  }

  // From the start, if it is at the end.
  async play() {
    this.playing = true;
    this._tell();
    if (this.index === this.texts.length - 1) await this.go(0);
    while (this.playing && this.index < this.texts.length - 1) {
      await new Promise((resolve) => setTimeout(resolve, PLAY_MS));
      if (this.playing) await this.go(this.index + 1);
    }
    this.stop();
  }

  stop() {
    this.playing = false;
    this._tell();
  }

  remove() {
    this.playing = false;
    document.removeEventListener("keydown", this.listener);
    this.box.remove();
  }

  _tell() {
    this.slider.value = String(this.index);
    this.slider.setAttribute("aria-valuetext", this.texts[this.index]);
    this.text.textContent = this.texts[this.index];
    this.button.textContent = this.playing ? "Pause" : "Play";
  }

  // The slider has arrow keys of its own; on the map they move the map, and in the list the selection.
  _onKey(event) {
    const own = event.target === document.body || this.box.contains(event.target);
    if (!own || event.target === this.slider || event.ctrlKey || event.altKey || event.metaKey) return;
    if (!(event.key in MOVES)) return;
    event.preventDefault();
    this.stop();
    this.go(this.index + MOVES[event.key]);
  }
}
