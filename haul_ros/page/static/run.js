// A run as data: instants, and quantities along the train at each of them.

const GROWTH = 600;

// A quantity at each instant and place: `value(i, r)` in its unit, rows from the head.
export class Quantity {
  constructor({ key, label, unit, names, diverging, digits }) {
    Object.assign(this, { key, label, unit, names, diverging, digits });
    this.rows = names.length;
    this.data = new Float32Array(0);
    this.clear();
  }

  clear() {
    this.highest = new Float64Array(this.rows).fill(Number.NEGATIVE_INFINITY);
    this.lowest = new Float64Array(this.rows).fill(Number.POSITIVE_INFINITY);
    this.largest = 0;
  }

  // All of it at once, an instant behind the other.
  fill(data) {
    this.data = data;
    for (let at = 0; at < data.length; at += this.rows) this.widen(data.subarray(at, at + this.rows));
  }

  put(i, values) {
    if ((i + 1) * this.rows > this.data.length) {
      const larger = new Float32Array((i + 1 + GROWTH) * this.rows);
      larger.set(this.data);
      this.data = larger;
    }
    this.data.set(values, i * this.rows);
    this.widen(values);
  }

  drop(instants) {
    this.data.copyWithin(0, instants * this.rows);
  }

  // Envelopes that hold these values too; those of a recording are of every time step.
  widen(values) {
    for (let r = 0; r < this.rows; r++) {
      const value = values[r];
      if (value > this.highest[r]) this.highest[r] = value;
      if (value < this.lowest[r]) this.lowest[r] = value;
      if (Math.abs(value) > this.largest) this.largest = Math.abs(value);
    }
  }

  value(i, r) {
    return this.data[i * this.rows + r];
  }

  at(i) {
    return this.data.subarray(i * this.rows, (i + 1) * this.rows);
  }

  // One place over time.
  series(r, count) {
    const found = new Float32Array(count);
    for (let i = 0, at = r; i < count; i++, at += this.rows) found[i] = this.data[at];
    return found;
  }

  get title() {
    return this.label[0].toUpperCase() + this.label.slice(1);
  }

  text(value) {
    return Number.isFinite(value) ? `${value.toFixed(this.digits)} ${this.unit}` : "–";
  }
}

export class Run {
  constructor({ couplers, vehicles, locomotives, places, pneumatic }) {
    Object.assign(this, { couplers, vehicles, locomotives, places }); // places of vehicles: m behind the head
    const along = (key, label, unit, names, diverging, digits) =>
      new Quantity({ key, label, unit, names, diverging, digits });
    const quantities = [
      along("force", "coupler force", "kN", couplers, true, 1),
      along("stroke", "draft gear stroke", "mm", couplers, true, 2),
      along("cylinder", "brake cylinder pressure", "kPa", vehicles, false, 1),
    ];
    if (pneumatic) quantities.push(along("pipe", "brake pipe pressure", "kPa", vehicles, false, 1));
    this.quantities = Object.fromEntries(quantities.map((quantity) => [quantity.key, quantity]));
    this.speed = new Quantity({
      key: "speed",
      label: "speed",
      unit: "km/h",
      names: ["head", "middle", "tail"],
      digits: 2,
    });
    this.time = new Float64Array(0);
    this.clear();
  }

  clear() {
    this.count = 0;
    this.events = []; // { time, kind, text }
    this.commands = []; // { time, locomotive, kind, value }
    this.applied = Object.fromEntries(this.locomotives.map(({ name }) => [name, []])); // [time, 0..1]
    this.effort = Object.fromEntries(this.locomotives.map(({ name }) => [name, []])); // [time, N]
    this.peaks = null;
    for (const quantity of this.all()) quantity.clear();
  }

  // Locomotives whose place in the train is known.
  get located() {
    return this.locomotives.filter(({ vehicle }) => vehicle !== null);
  }

  all() {
    return [...Object.values(this.quantities), this.speed];
  }

  get start() {
    return this.count ? this.time[0] : 0;
  }

  get end() {
    return this.count ? this.time[this.count - 1] : 0;
  }

  // Of the instant nearest to a time.
  index(time) {
    let [low, high] = [0, this.count - 1];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.time[middle] < time) low = middle + 1;
      else high = middle;
    }
    return low > 0 && time - this.time[low - 1] < this.time[low] - time ? low - 1 : Math.max(low, 0);
  }

  instants() {
    return this.time.subarray(0, this.count);
  }

  // One more instant; the oldest are let go where there are more than `most`.
  append(time, values, most) {
    if (this.count >= most) {
      const surplus = this.count >> 1;
      this.time.copyWithin(0, surplus);
      for (const quantity of this.all()) quantity.drop(surplus);
      this.count -= surplus;
    }
    if (this.count === this.time.length) {
      const longer = new Float64Array(this.count + GROWTH);
      longer.set(this.time);
      this.time = longer;
    }
    this.time[this.count] = time;
    for (const quantity of this.all()) quantity.put(this.count, values[quantity.key]);
    this.count += 1;
  }

  // Largest forces and strokes of every time step, as magnitudes in kN and mm.
  setPeaks(peaks) {
    this.peaks = peaks;
    const negative = (values) => values.map((value) => -value);
    this.quantities.force.widen(peaks.compression);
    this.quantities.force.widen(negative(peaks.tension));
    this.quantities.stroke.widen(peaks.compression_stroke);
    this.quantities.stroke.widen(negative(peaks.tension_stroke));
  }

  // Values that hold until they change, at every instant.
  held(changes) {
    const found = new Float32Array(this.count);
    let [k, value] = [0, 0];
    for (let i = 0; i < this.count; i++) {
      while (k < changes.length && changes[k][0] <= this.time[i] + 1e-9) value = changes[k++][1];
      found[i] = value;
    }
    return found;
  }
}
