// Charts, and those over time, drawn by uPlot, which is a global of the page.

import { styleColour } from "./colours.js";
import { byId, element } from "./dom.js";
import { LEFT, RIGHT, ticks } from "./scales.js";

const TOGETHER = uPlot.sync("time");

export function axis(more) {
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

export class Chart {
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
