// Curves over time and along the train, drawn by uPlot, which is a global of the page.

import { LINE_COLOURS, styleColour } from "./colours.js";
import { byId, element, seconds } from "./dom.js";
import { LEFT, RIGHT, ticks } from "./heatmap.js";

const TOGETHER = uPlot.sync("time");

function axis(more) {
  return {
    stroke: () => styleColour("muted"),
    grid: { stroke: () => styleColour("grid"), width: 1 },
    ticks: { stroke: () => styleColour("grid"), width: 1, size: 4 },
    font: `11px ${getComputedStyle(document.body).fontFamily}`,
    ...more,
  };
}

// A frame for a chart, with its title and the values of its curves at one instant.
function frame(id, title) {
  const [plot, values] = [element("div", { class: "plot" }), element("div", { class: "values" })];
  byId(id).replaceChildren(element("h2", {}, title), values, plot);
  return { plot, values };
}

class Chart {
  constructor(view, id, title, height) {
    Object.assign(this, { view, height, hovered: null }, frame(id, title));
    this.title = byId(id).querySelector("h2");
    new ResizeObserver(() => this.fit()).observe(this.plot);
  }

  fit() {
    this.uplot?.setSize({ width: this.plot.clientWidth, height: this.height });
    this.place();
  }

  make(options, data) {
    this.uplot?.destroy();
    this.uplot = new uPlot(
      {
        width: this.plot.clientWidth,
        height: this.height,
        legend: { show: false },
        padding: [8, RIGHT, 0, 0],
        ...options,
      },
      data,
      this.plot,
    );
    this.line = element("div", { class: "cursor-line" });
    this.uplot.over.append(this.line);
    this.place();
  }

  place() {}

  // What the curves are worth where the pointer is, else at the cursor.
  showValues(items) {
    const spans = items.map(({ label, colour, dash, text }) => {
      const mark = element("span", { class: dash ? "mark dashed" : "mark" });
      mark.style.setProperty("--colour", styleColour(colour));
      return element("span", { class: "item" }, mark, `${label} `, element("b", {}, text));
    });
    this.values.replaceChildren(...spans);
  }
}

// `curves()`: [{ label, colour, dash, stepped, values, text }] of the run as it is.
export class TimeChart extends Chart {
  constructor(view, id, title, { curves, range, height = 130, renew = [] }) {
    super(view, id, title, height);
    Object.assign(this, { curves, valueRange: range, renew });
    view.add((changed) => this.update(changed));
    this.update(new Set(["data"]));
  }

  update(changed) {
    const { view } = this;
    const renewed = changed.has("data") || changed.has("theme") || this.renew.some((what) => changed.has(what));
    if (renewed) {
      const before = this.shown?.map(({ label, colour }) => label + colour).join();
      this.shown = this.curves();
      this.data = [view.run.instants(), ...this.shown.map(({ values }) => values)];
      const same = before === this.shown.map(({ label, colour }) => label + colour).join();
      if (this.uplot && same && !changed.has("theme")) this.uplot.setData(this.data, false);
      else this.build();
    }
    if (renewed || changed.has("range")) this.uplot.setScale("x", { min: view.range[0], max: view.range[1] });
    if (changed.size) this.place();
  }

  build() {
    const { view } = this;
    const series = this.shown.map(({ label, colour, dash, stepped }) => ({
      label,
      stroke: styleColour(colour),
      width: 1.6,
      dash: dash ? [6, 4] : undefined,
      paths: stepped ? uPlot.paths.stepped({ align: 1 }) : undefined,
      points: { show: false },
    }));
    this.make(
      {
        scales: { x: { time: false, auto: false }, y: { range: this.valueRange } },
        axes: [
          axis({
            size: 26,
            space: 80,
            values: (_, at) => at.map((time) => time.toFixed(ticks(...view.range, 800).digits)),
          }),
          axis({ size: LEFT, space: 26 }),
        ],
        series: [{}, ...series],
        cursor: {
          sync: { key: TOGETHER.key, setSeries: false },
          drag: { x: true, y: false, setScale: false },
          points: { size: 6 },
          y: false,
        },
        hooks: {
          draw: [() => this.place()],
          setSelect: [
            (u) => {
              if (u.select.width < 6) return;
              view.setRange(u.posToVal(u.select.left, "x"), u.posToVal(u.select.left + u.select.width, "x"));
              u.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
            },
          ],
          setCursor: [
            (u) => {
              this.hovered = u.cursor.left >= 0 ? u.cursor.idx : null;
              this.showNow();
            },
          ],
        },
      },
      this.data,
    );
    this.uplot.setScale("x", { min: view.range[0], max: view.range[1] });
    let down = 0;
    this.uplot.over.addEventListener("pointerdown", (event) => (down = event.clientX));
    this.uplot.over.addEventListener("click", (event) => {
      if (Math.abs(event.clientX - down) < 5) view.look(this.uplot.posToVal(event.offsetX, "x"));
    });
    this.uplot.over.addEventListener("dblclick", () => view.reset());
  }

  place() {
    if (!this.uplot) return;
    const x = this.uplot.valToPos(this.view.cursor, "x");
    this.line.hidden = !(x >= 0 && x <= this.uplot.over.clientWidth);
    this.line.style.transform = `translateX(${x}px)`;
    this.showNow();
  }

  showNow() {
    const i = this.hovered ?? this.view.index;
    this.showValues(
      this.shown.map((curve) => ({ ...curve, text: this.view.run.count ? curve.text(curve.values[i]) : "–" })),
    );
  }
}

// Along the train at the cursor's time, between the envelopes.
export class ProfileChart extends Chart {
  constructor(view, id) {
    super(view, id, "", 250);
    view.add((changed) => this.update(changed));
    this.update(new Set(["quantity"]));
  }

  get envelopes() {
    const finite = (value) => (Number.isFinite(value) ? value : 0);
    const { highest, lowest, diverging } = this.view.shown;
    return [
      Array.from(highest, finite),
      Array.from(lowest, (value) => (diverging ? Math.min(0, finite(value)) : finite(value))),
    ];
  }

  update(changed) {
    const { view } = this;
    if (changed.has("quantity") || changed.has("theme")) {
      this.places = Float64Array.from(view.shown.names, (_, k) => k + 1);
      this.build();
    }
    if (["cursor", "data", "quantity", "theme"].some((what) => changed.has(what))) {
      const now = view.run.count ? view.shown.at(view.index) : new Float32Array(view.shown.rows);
      this.uplot.setData([this.places, ...this.envelopes, now]);
      this.title.textContent = `${view.shown.title} [${view.shown.unit}] along the train at ${seconds(view.cursor)}, between its extremes`;
    }
    if (changed.size) this.showNow();
  }

  build() {
    const { view } = this;
    const { shown } = view;
    const colours = shown.diverging ? ["compression", "tension"] : ["line-5", "line-5"];
    const names = shown.diverging ? ["largest compression", "largest tension"] : ["highest", "lowest"];
    this.colours = colours;
    const band = (colour) => ({ stroke: styleColour(colour), width: 1, points: { show: false } });
    this.make(
      {
        scales: {
          x: { time: false, range: [0.5, shown.rows + 0.5] },
          y: { range: (_, low, high) => this.valueRange(low, high) },
        },
        axes: [axis({ size: 26, space: 60 }), axis({ size: LEFT, space: 30 })],
        series: [
          {},
          { label: names[0], ...band(colours[0]) },
          { label: names[1], ...band(colours[1]) },
          { label: "now", stroke: styleColour("text"), width: 2, points: { show: false } },
        ],
        bands: [{ series: [1, 2], fill: styleColour("band") }],
        cursor: { drag: { x: false, y: false }, points: { size: 6 }, y: false },
        hooks: {
          drawClear: [(u) => this.drawLocomotives(u)],
          setCursor: [
            (u) => {
              this.hovered = u.cursor.left >= 0 ? u.cursor.idx : null;
              this.showNow();
            },
          ],
        },
      },
      [this.places, ...this.envelopes, new Float32Array(shown.rows)],
    );
    this.uplot.over.addEventListener("click", () => {
      if (this.hovered !== null && view.shown.names === view.run.couplers) view.choose(this.hovered);
    });
  }

  // The same all through the run, so that the curve alone moves.
  valueRange(low, high) {
    const { diverging, largest } = this.view.shown;
    const room = Math.max(largest, 1) * 0.06;
    return diverging ? [Math.min(low, 0) - room, Math.max(high, 0) + room] : [0, Math.max(largest, 1) + room];
  }

  drawLocomotives(u) {
    const { run, shown } = this.view;
    const { ctx, bbox } = u;
    ctx.save();
    ctx.fillStyle = styleColour("grid");
    for (const { vehicle } of run.located) {
      const x = u.valToPos(vehicle + (shown.names === run.vehicles ? 1 : 0.5), "x", true);
      ctx.fillRect(x - 1.5 * devicePixelRatio, bbox.top, 3 * devicePixelRatio, bbox.height);
    }
    ctx.restore();
  }

  showNow() {
    const { view, uplot } = this;
    const { shown } = view;
    if (this.hovered === null) {
      const text = (value) => (Number.isFinite(value) ? shown.text(value) : "–");
      const now = view.run.count ? Array.from(shown.at(view.index)).filter(Number.isFinite) : [];
      const [most, least] = [Math.max(...now), Math.min(...now)];
      const labels = shown.diverging ? ["most compression now", "most tension now"] : ["highest now", "lowest now"];
      this.showValues([
        { label: labels[0], colour: this.colours[0], text: text(shown.diverging ? Math.max(most, 0) : most) },
        { label: labels[1], colour: this.colours[1], text: text(shown.diverging ? Math.min(least, 0) : least) },
      ]);
      return;
    }
    const [high, low, now] = [1, 2, 3].map((series) => uplot.data[series][this.hovered]);
    this.showValues([
      { label: shown.names[this.hovered], colour: "text", text: shown.text(now) },
      { label: "highest", colour: this.colours[0], text: shown.text(high) },
      { label: "lowest", colour: this.colours[1], text: shown.text(low) },
    ]);
  }
}

// The charts over time that every run has.
export function timeCharts(view) {
  const { run } = view;
  const places = (quantity, digits) =>
    [
      ["head", "line-1", 0],
      ["middle", "line-2", Math.floor((run.vehicles.length - 1) / 2)],
      ["tail", "line-3", run.vehicles.length - 1],
    ].map(([label, colour, row], k) => ({
      label,
      colour,
      dash: k === 2,
      values: quantity.series(quantity.rows === 3 ? k : row, run.count),
      text: (value) => (Number.isFinite(value) ? `${value.toFixed(digits)} ${quantity.unit}` : "–"),
    }));
  const fromZero = (least) => (_, low, high) => [Math.min(0, low ?? 0), Math.max(least, high ?? 0) * 1.05];
  const charts = [
    new TimeChart(view, "chosen-chart", "", {
      height: 190,
      renew: ["chosen", "quantity"],
      range: (_, low, high) => {
        if (low === null || low === undefined) return [-1, 1];
        const room = Math.max(high - low, 1) * 0.06;
        return [low - room, high + room];
      },
      curves: () =>
        view.chosen.map((row, k) => ({
          label: view.shown.names[row],
          colour: LINE_COLOURS[k],
          values: view.shown.series(row, run.count),
          text: (value) => view.shown.text(value),
        })),
    }),
    new TimeChart(view, "speed-chart", "Speed [km/h]", { curves: () => places(run.speed, 2), range: fromZero(1) }),
    new TimeChart(view, "demand-chart", "Brake applied by the locomotives [%]", {
      height: 110,
      range: () => [-4, 104],
      curves: () =>
        run.locomotives.slice(0, 6).map(({ name }, k) => ({
          label: name.replace("_", " "),
          colour: LINE_COLOURS[k],
          dash: k % 2 === 1,
          stepped: true,
          values: run.held(run.applied[name]).map((value) => 100 * value),
          text: (value) => (Number.isFinite(value) ? `${value.toFixed(1)} %` : "–"),
        })),
    }),
    new TimeChart(view, "cylinder-chart", "Brake cylinder pressure [kPa]", {
      curves: () => places(run.quantities.cylinder, 1),
      range: fromZero(50),
    }),
  ];
  if (run.quantities.pipe) {
    charts.push(
      new TimeChart(view, "pipe-chart", "Brake pipe pressure [kPa]", {
        curves: () => places(run.quantities.pipe, 1),
        range: fromZero(50),
      }),
    );
  }
  if (view.live || Object.values(run.effort).some((changes) => changes.some(([, value]) => value))) {
    charts.push(
      new TimeChart(view, "effort-chart", "Traction (above 0) and electric brake (below) [kN]", {
        height: 110,
        range: (_, low, high) => [Math.min(-10, (low ?? 0) * 1.05), Math.max(10, (high ?? 0) * 1.05)],
        curves: () =>
          run.locomotives.slice(0, 6).map(({ name }, k) => ({
            label: name.replace("_", " "),
            colour: LINE_COLOURS[k],
            dash: k % 2 === 1,
            stepped: true,
            values: run.held(run.effort[name]).map((value) => value / 1e3),
            text: (value) => (Number.isFinite(value) ? `${value.toFixed(1)} kN` : "–"),
          })),
      }),
    );
  }
  view.add((changed) => {
    if (changed.has("quantity") || changed.has("chosen")) {
      const { title, unit, names } = view.shown;
      charts[0].title.textContent = `${title} [${unit}] of chosen ${names === run.couplers ? "couplers" : "vehicles"}`;
    }
  });
  return charts;
}
