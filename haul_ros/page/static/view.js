// What is looked at: time, range, quantity, couplers; parts of the page follow its changes, once a frame.

export const MOST_CHOSEN = 6;
const SHORTEST = 0.1; // seconds of the shortest range

export class View {
  constructor(run, live) {
    Object.assign(this, { run, live });
    this.cursor = run.start;
    this.range = [run.start, Math.max(run.end, run.start + SHORTEST)];
    this.whole = true;
    this.following = live;
    this.playing = false;
    this.quantity = "force";
    this.chosen = [];
    this.parts = [];
    this.changes = new Set();
    this.waiting = false;
  }

  // `update(changed)` gets the names of what has changed: cursor, range, quantity, chosen, data, theme, playing.
  add(update) {
    this.parts.push(update);
  }

  changed(...what) {
    for (const name of what) this.changes.add(name);
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      const changes = this.changes;
      this.changes = new Set();
      for (const update of this.parts) update(changes);
    });
  }

  get shown() {
    return this.run.quantities[this.quantity];
  }

  get index() {
    return this.run.index(this.cursor);
  }

  setCursor(time) {
    this.cursor = Math.max(this.run.start, Math.min(this.run.end, time));
    this.changed("cursor");
  }

  // Somebody looks at another time than the newest.
  look(time) {
    if (this.following) this.follow(false);
    this.setCursor(time);
  }

  follow(following) {
    this.following = following;
    this.changed("playing");
  }

  stepCursor(samples) {
    const index = Math.max(0, Math.min(this.run.count - 1, this.index + samples));
    if (this.run.count) this.look(this.run.time[index]);
  }

  setRange(from, to) {
    const [start, end] = [this.run.start, this.run.end];
    const length = Math.min(Math.max(to - from, SHORTEST), Math.max(end - start, SHORTEST));
    const begin = Math.max(start, Math.min(from, end - length));
    this.range = [begin, begin + length];
    this.whole = length >= end - start;
    this.changed("range");
  }

  zoom(factor, about = (this.range[0] + this.range[1]) / 2) {
    const [from, to] = this.range;
    this.setRange(about - (about - from) * factor, about + (to - about) * factor);
  }

  zoomAtCursor(factor) {
    const [from, to] = this.range;
    this.zoom(factor, this.cursor >= from && this.cursor <= to ? this.cursor : undefined);
  }

  reset() {
    this.setRange(this.run.start, this.run.end);
    this.whole = true;
  }

  setQuantity(key) {
    if (!(key in this.run.quantities)) return;
    this.quantity = key;
    this.changed("quantity", "chosen");
  }

  // A coupler comes to those whose force is drawn over time; the oldest goes where there are too many.
  choose(row) {
    if (row < 0 || row >= this.run.couplers.length || this.chosen.includes(row)) return;
    this.chosen = [...this.chosen, row].slice(-MOST_CHOSEN);
    this.changed("chosen");
  }

  drop(row) {
    this.chosen = this.chosen.filter((other) => other !== row);
    this.changed("chosen");
  }

  replaceNewest(row) {
    if (row < 0 || row >= this.run.couplers.length) return;
    this.chosen = [...this.chosen.slice(0, -1).filter((other) => other !== row), row];
    this.changed("chosen");
  }
}
