// A quantity along the train at one time.

import { axis, Chart } from "./charts.js";
import { styleColour } from "./colours.js";
import { seconds } from "./dom.js";
import { LEFT } from "./scales.js";

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
