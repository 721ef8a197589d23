// Session: one map, what is on disk, and the corrections of this tab with their undo and redo.

import { Refused } from "./server.js";

const CONFLICT = 409;

function bare({ text, problem, ...correction }) {
  return correction;
}

function same(first, second) {
  return JSON.stringify(first.map(bare)) === JSON.stringify(second.map(bare));
}

export class Session {
  // listeners: {changed(session, reloaded), conflict(session)}
  constructor(source, number, listeners) {
    this.source = source;
    this.number = number;
    this.listeners = listeners;
    this.steps = [];
    this.step = 0;
    // Requests one after the other, so that an edit is made on the answer to the one before.
    this.queue = Promise.resolve();
  }

  get corrections() {
    return this.steps[this.step] ?? [];
  }

  get unsaved() {
    return this.disk !== undefined && !same(this.corrections, this.disk.corrections);
  }

  get canUndo() {
    return this.step > 0;
  }

  get canRedo() {
    return this.step < this.steps.length - 1;
  }

  get writable() {
    return !this.source.readOnly && this.disk.writable;
  }

  async open() {
    this.disk = await this.source.getMap(this.number);
    this.state = this.disk;
    this.steps = [this.disk.corrections.map(bare)];
    this.step = 0;
    await this._restore();
    this.listeners.changed(this, false);
  }

  edit(edit) {
    return this._enqueue(async () => {
      const answer = await this.source.edit(this.number, this.disk.version, this.corrections, edit);
      this.steps.length = this.step + 1;
      this.steps.push(answer.corrections.map(bare));
      this.step += 1;
      this._show(answer);
    });
  }

  // Take one correction out of the list.
  remove(index) {
    return this._enqueue(async () => {
      const list = this.corrections.filter((_, number) => number !== index);
      const answer = await this.source.apply(this.number, this.disk.version, list);
      this.steps.length = this.step + 1;
      this.steps.push(list);
      this.step += 1;
      this._show(answer);
    });
  }

  undo() {
    return this._enqueue(() => this.canUndo && this._go(this.step - 1));
  }

  redo() {
    return this._enqueue(() => this.canRedo && this._go(this.step + 1));
  }

  save() {
    return this._enqueue(async () => {
      this.disk = await this.source.save(this.number, this.disk.version, this.corrections);
      this.steps[this.step] = this.disk.corrections.map(bare);
      this._show(this.disk);
    });
  }

  // Look whether the files have changed; without unsaved corrections show them at once.
  follow() {
    return this._enqueue(async () => {
      const version = await this.source.getVersion(this.number);
      if (version === this.disk.version || version === this.passed) return;
      if (this.unsaved) {
        this.passed = version;
        this.listeners.conflict(this);
        return;
      }
      await this._load();
    });
  }

  // What is on disk. keep: with the corrections of this tab on it, else without.
  reload(keep) {
    return this._enqueue(() => this._load(keep));
  }

  async _load(keep = false) {
    const before = this.disk.corrections.map((each) => JSON.stringify(bare(each)));
    const own = this.corrections.map((each) => JSON.stringify(bare(each)));
    this.disk = await this.source.getMap(this.number);
    this.passed = undefined;
    const list = this.disk.corrections.map(bare);
    this.steps = [list];
    this.step = 0;
    this.state = this.disk;
    if (keep) {
      const removed = new Set(before.filter((each) => !own.includes(each)));
      const texts = list.map((each) => JSON.stringify(each)).filter((each) => !removed.has(each));
      const merged = [...texts, ...own.filter((each) => !before.includes(each) && !texts.includes(each))];
      const rebased = merged.map((each) => JSON.parse(each));
      const answer = await this.source.apply(this.number, this.disk.version, rebased);
      this.steps.push(rebased);
      this.step = 1;
      this.state = { ...this.disk, ...answer };
    }
    this._keep();
    this.listeners.changed(this, true);
  }

  async _go(step) {
    const answer = await this.source.apply(this.number, this.disk.version, this.steps[step]);
    this.step = step;
    this._show(answer);
  }

  _show(answer) {
    this.state = { ...this.disk, ...answer };
    this._keep();
    this.listeners.changed(this, false);
  }

  _enqueue(task) {
    const done = this.queue.then(task).catch((fault) => {
      if (fault instanceof Refused && fault.status === CONFLICT) this.listeners.conflict(this, fault);
      throw fault;
    });
    this.queue = done.catch(() => {});
    return done;
  }

  get _key() {
    return `pianta ${location.pathname} ${this.disk.name}`;
  }

  // Keep undo, redo and unsaved corrections over a reload of the page.
  _keep() {
    if (this.source.readOnly) return;
    const pool = [];
    const known = new Map();
    const steps = this.steps.map((list) => list.map((each) => {
      const text = JSON.stringify(each);
      if (!known.has(text)) known.set(text, pool.push(each) - 1);
      return known.get(text);
    }));
    const kept = { version: this.disk.version, saved: this.disk.corrections.map(bare), pool, steps, step: this.step };
    try {
      sessionStorage.setItem(this._key, JSON.stringify(kept));
    } catch {
      // The store of the browser is full or off: the warning before the page is left remains.
    }
  }

  async _restore() {
    if (this.source.readOnly) return;
    let kept = null;
    try {
      kept = JSON.parse(sessionStorage.getItem(this._key));
    } catch {
      return;
    }
    if (!kept) return;
    const steps = kept.steps.map((list) => list.map((index) => kept.pool[index]));
    const own = steps[kept.step];
    if (kept.version !== this.disk.version) {
      if (same(own, kept.saved)) return;
      // The corrections of this tab are of older files: they are put on the new ones.
      const added = own.filter((each) => !kept.saved.some((old) => same([old], [each])));
      steps.splice(0, steps.length, this.disk.corrections.map(bare), [...this.disk.corrections.map(bare), ...added]);
      kept.step = 1;
    }
    if (same(steps[kept.step], this.disk.corrections)) {
      [this.steps, this.step] = [steps, kept.step];
      return;
    }
    const answer = await this.source.apply(this.number, this.disk.version, steps[kept.step]);
    [this.steps, this.step] = [steps, kept.step];
    this.state = { ...this.disk, ...answer };
  }
}
