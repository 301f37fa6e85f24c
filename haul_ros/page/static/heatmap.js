// A quantity over time and place as colours, with commands, radio and brake waves drawn in.

import { pixels, styleColour } from "./colours.js";
import { byId, seconds } from "./dom.js";
import { brakeFronts, brakeWaves, radioArrivals } from "./fronts.js";
import { LEFT, RIGHT, ticks } from "./scales.js";

export const TOP = 20;
const BOTTOM = 24;
const LEAST_LIMIT = { force: 50, stroke: 2, cylinder: 50, pipe: 50 }; // of the colours, so that no noise is shown as more
const EVENT_COLOURS = {
  emergency: "line-2",
  brake_wave: "line-1",
  radio: "line-4",
  stopped: "line-3",
  slack: "line-6",
};
const FRONTS_PERIOD = 1000; // ms between two searches for brake waves, live

export class HeatMap {
  constructor(view) {
    this.view = view;
    this.canvas = byId("heatmap");
    this.context = this.canvas.getContext("2d");
    this.image = document.createElement("canvas");
    this.fronts = [];
    this.waves = [];
    this.arrivals = [];
    this.searched = Number.NEGATIVE_INFINITY;
    this.drag = null; // { x, now, y, touch, zooming } while the pointer is down
    view.add((changed) => this.update(changed));
    new ResizeObserver(() => this.update(new Set(["data"]))).observe(this.canvas);
  }

  update(changed) {
    const { view } = this;
    if (changed.has("data") && performance.now() - this.searched > (view.live ? FRONTS_PERIOD : 0)) {
      this.searched = performance.now();
      this.fronts = brakeFronts(view.run.quantities.cylinder, view.run.time, view.run.count);
      this.waves = brakeWaves(this.fronts, view.run.places, view.run.vehicles.length);
      this.arrivals = radioArrivals(view.run);
    }
    if (["data", "range", "quantity", "theme"].some((what) => changed.has(what))) this.paint();
    if (changed.size) this.draw();
  }

  get limit() {
    return Math.max(this.view.shown.largest, LEAST_LIMIT[this.view.quantity]);
  }

  measure() {
    const { clientWidth, clientHeight } = this.canvas;
    this.ratio = devicePixelRatio || 1;
    this.width = Math.max(clientWidth - LEFT - RIGHT, 10);
    this.height = Math.max(clientHeight - TOP - BOTTOM, 10);
    const [width, height] = [clientWidth, clientHeight].map((size) => Math.round(size * this.ratio));
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
  }

  // The colours, one pixel wide for each instant that can be shown; of several in one the value of largest magnitude.
  paint() {
    this.measure();
    const { run, shown, range } = this.view;
    const { rows, data } = shown;
    const width = Math.round(this.width * this.ratio);
    Object.assign(this.image, { width, height: rows });
    if (!run.count || !rows) return;
    const context = this.image.getContext("2d");
    const image = context.createImageData(width, rows);
    const target = new Uint32Array(image.data.buffer);
    const colour = pixels(shown.diverging, this.limit);
    const step = (range[1] - range[0]) / width;
    let begin = run.index(range[0]);
    for (let x = 0; x < width; x++) {
      const until = range[0] + (x + 1) * step;
      if (until < run.start || range[0] + x * step > run.end) continue;
      const end = Math.max(begin, run.index(until));
      for (let r = 0; r < rows; r++) {
        let value = data[begin * rows + r];
        for (let i = begin + 1; i <= end; i++) {
          const other = data[i * rows + r];
          if (Math.abs(other) > Math.abs(value)) value = other;
        }
        target[r * width + x] = colour(value);
      }
      begin = end;
    }
    context.putImageData(image, 0, 0);
  }

  x(time) {
    const [from, to] = this.view.range;
    return LEFT + ((time - from) / (to - from)) * this.width;
  }

  timeAt(x) {
    const [from, to] = this.view.range;
    return from + ((x - LEFT) / this.width) * (to - from);
  }

  get ofVehicles() {
    return this.view.shown.names === this.view.run.vehicles;
  }

  // Vehicle v stands between couplers v - 1 and v.
  vehicleY(vehicle) {
    return TOP + ((vehicle + (this.ofVehicles ? 0.5 : 0)) / this.view.shown.rows) * this.height;
  }

  rowAt(y) {
    return Math.max(
      0,
      Math.min(this.view.shown.rows - 1, Math.floor(((y - TOP) / this.height) * this.view.shown.rows)),
    );
  }

  draw() {
    this.measure();
    const { context, view } = this;
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    context.clearRect(0, 0, this.canvas.clientWidth, this.canvas.clientHeight);
    context.imageSmoothingEnabled = false;
    context.fillStyle = styleColour("nothing");
    context.fillRect(LEFT, TOP, this.width, this.height);
    if (this.image.width && this.image.height) context.drawImage(this.image, LEFT, TOP, this.width, this.height);
    this.drawAxes();
    context.save();
    context.beginPath();
    context.rect(LEFT - 7, 0, this.width + 14, TOP + this.height + 6);
    context.clip();
    this.drawEvents();
    if (byId("show-lines").checked) this.drawLines();
    this.drawCursor();
    context.restore();
    if (this.drag?.zooming) {
      context.fillStyle = styleColour("selection");
      context.fillRect(Math.min(this.drag.x, this.drag.now), TOP, Math.abs(this.drag.now - this.drag.x), this.height);
    }
    this.canvas.setAttribute("aria-label", `${view.shown.label} over time and place, ${seconds(view.cursor)}`);
  }

  drawAxes() {
    const { context, view } = this;
    const bottom = TOP + this.height;
    context.fillStyle = context.strokeStyle = styleColour("muted");
    context.font = `11px ${getComputedStyle(document.body).fontFamily}`;
    context.textAlign = "center";
    context.textBaseline = "top";
    const { found, digits } = ticks(...view.range, this.width);
    for (const time of found) {
      context.fillRect(this.x(time), bottom, 1, 4);
      context.fillText(time.toFixed(digits), this.x(time), bottom + 7);
    }
    context.textAlign = "right";
    context.textBaseline = "middle";
    const taken = view.run.located.map(({ vehicle }) => this.vehicleY(vehicle));
    for (const row of ticks(1, view.shown.rows, this.height, 46).found) {
      const y = TOP + ((row - 0.5) / view.shown.rows) * this.height;
      if (row >= 1 && taken.every((other) => Math.abs(other - y) > 12)) context.fillText(row.toFixed(0), LEFT - 9, y);
    }
    context.fillStyle = styleColour("text");
    let above = Number.NEGATIVE_INFINITY;
    for (const { name, vehicle } of view.run.located) {
      const y = this.vehicleY(vehicle);
      context.fillRect(LEFT - 6, y - 1.5, 5, 3);
      if (y - above > 11) context.fillText(name.replace("_", " "), LEFT - 9, y);
      if (y - above > 11) above = y;
    }
  }

  drawEvents() {
    const { context, view } = this;
    for (const { time, kind } of view.run.events) {
      context.fillStyle = styleColour(EVENT_COLOURS[kind] ?? "line-5");
      const x = this.x(time);
      context.beginPath();
      context.moveTo(x - 4, TOP - 12);
      context.lineTo(x + 4, TOP - 12);
      context.lineTo(x, TOP - 4);
      context.fill();
    }
  }

  // A line twice: dark on a light seam, so that it shows on every colour.
  path(points, dash, width) {
    const { context } = this;
    for (const [colour, wide] of [
      ["rgba(255, 255, 255, 0.85)", width + 2],
      ["#111", width],
    ]) {
      context.beginPath();
      for (const [k, [time, vehicle]] of points.entries()) {
        if (k) context.lineTo(this.x(time), this.vehicleY(vehicle));
        else context.moveTo(this.x(time), this.vehicleY(vehicle));
      }
      context.setLineDash(colour === "#111" ? dash : []);
      Object.assign(context, { strokeStyle: colour, lineWidth: wide, lineJoin: "round" });
      context.stroke();
    }
    context.setLineDash([]);
  }

  mark(time, vehicle, shape) {
    const { context } = this;
    const [x, y] = [this.x(time), this.vehicleY(vehicle)];
    context.beginPath();
    if (shape === "command") {
      context.moveTo(x - 4, y - 6);
      context.lineTo(x + 6, y);
      context.lineTo(x - 4, y + 6);
      context.closePath();
    } else context.arc(x, y, 4, 0, 2 * Math.PI);
    Object.assign(context, {
      fillStyle: shape === "command" ? "#111" : "#fff",
      strokeStyle: shape === "command" ? "#fff" : "#111",
      lineWidth: 1.5,
    });
    context.fill();
    context.stroke();
  }

  drawLines() {
    const { run } = this.view;
    for (const { direction, points } of this.fronts) this.path(points, direction > 0 ? [] : [7, 4], 1.3);
    for (const { sent, from, arrived, to } of this.arrivals)
      this.path(
        [
          [sent, from],
          [arrived, to],
        ],
        [2, 3],
        1.3,
      );
    for (const { arrived, to } of this.arrivals) this.mark(arrived, to, "arrival");
    const vehicle = Object.fromEntries(run.located.map((locomotive) => [locomotive.name, locomotive.vehicle]));
    for (const { time, locomotive } of run.commands)
      if (locomotive in vehicle) this.mark(time, vehicle[locomotive], "command");
  }

  drawCursor() {
    const { context, view } = this;
    const x = this.x(view.cursor);
    context.fillStyle = "rgba(255, 255, 255, 0.8)";
    context.fillRect(x - 1.5, TOP, 3, this.height);
    context.fillStyle = styleColour("cursor");
    context.fillRect(x - 0.75, TOP - 4, 1.5, this.height + 8);
    for (const [k, row] of view.chosen.entries()) {
      context.fillStyle = styleColour(`line-${k + 1}`);
      const y = TOP + ((row + 0.5) / view.shown.rows) * this.height;
      context.beginPath();
      context.moveTo(x + 2, y);
      context.lineTo(x + 9, y - 4);
      context.lineTo(x + 9, y + 4);
      context.fill();
    }
  }
}
