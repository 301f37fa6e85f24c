// Which curves over time the page has.

import { TimeChart } from "./charts.js";
import { LINE_COLOURS } from "./colours.js";

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
