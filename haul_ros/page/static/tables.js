// Tables of peaks, radio, brake waves and all numbers, and the figures of the whole run.

import { byId, element } from "./dom.js";

const MOST_ROWS = 1000; // of a table

const COLUMNS = [
  { title: "coupler", value: (peaks, row) => row + 1, digits: 0 },
  { title: "buff kN", value: (peaks, row) => peaks.compression[row], digits: 1 },
  {
    title: "at s",
    value: (peaks, row) => (peaks.compression[row] > 0 ? peaks.compression_time[row] : Number.NaN),
    digits: 3,
  },
  { title: "draft kN", value: (peaks, row) => peaks.tension[row], digits: 1 },
  { title: "at s", value: (peaks, row) => (peaks.tension[row] > 0 ? peaks.tension_time[row] : Number.NaN), digits: 3 },
  { title: "in mm", value: (peaks, row) => peaks.compression_stroke[row], digits: 2 },
  { title: "out mm", value: (peaks, row) => peaks.tension_stroke[row], digits: 2 },
];

export class Peaks {
  constructor(view) {
    this.view = view;
    this.order = { column: 1, falling: true };
    this.drawn = null;
    view.add((changed) => {
      if (changed.has("data") && this.drawn !== view.run.peaks) this.draw();
    });
    this.draw();
  }

  sortBy(column) {
    const falling = column === this.order.column ? !this.order.falling : column !== 0;
    this.order = { column, falling };
    this.draw();
  }

  draw() {
    const { view, order } = this;
    const { peaks, couplers, vehicles } = view.run;
    this.drawn = peaks;
    const heads = COLUMNS.map(({ title }, k) => {
      const sorted = k === order.column ? (order.falling ? "descending" : "ascending") : false;
      return element(
        "th",
        { scope: "col", "aria-sort": sorted },
        element("button", { type: "button", onclick: () => this.sortBy(k) }, title),
      );
    });
    byId("peaks-head").replaceChildren(element("tr", {}, ...heads));
    if (!peaks) return byId("peaks-body").replaceChildren();
    const key = (row) => COLUMNS[order.column].value(peaks, row);
    const sign = order.falling ? -1 : 1;
    const rows = couplers.map((_, row) => row).sort((a, b) => sign * ((key(a) || 0) - (key(b) || 0)) || a - b);
    return byId("peaks-body").replaceChildren(
      ...rows.map((row) => {
        const cells = COLUMNS.map(({ value, digits }, k) => {
          const found = value(peaks, row);
          return element("td", {}, Number.isFinite(found) ? found.toFixed(digits) : "–");
        });
        return element(
          "tr",
          { title: `${couplers[row]}, between ${vehicles[row]} and ${vehicles[row + 1]}`, onclick: () => this.go(row) },
          ...cells,
        );
      }),
    );
  }

  go(row) {
    const { peaks } = this.view.run;
    this.view.choose(row);
    const compressed = peaks.compression[row] >= peaks.tension[row];
    this.view.look((compressed ? peaks.compression_time : peaks.tension_time)[row]);
  }
}

// When commands reached the slaves.
export class Arrivals {
  constructor(view, map) {
    view.add((changed) => {
      if (!changed.has("data")) return;
      const rows = map.arrivals
        .slice(-200)
        .map(({ name, sent, arrived }) =>
          element(
            "tr",
            { onclick: () => view.look(arrived) },
            ...[name, sent.toFixed(3), arrived.toFixed(3), (arrived - sent).toFixed(3)].map((text) =>
              element("td", {}, text),
            ),
          ),
        );
      byId("arrivals-body").replaceChildren(...rows);
      byId("arrivals").hidden = !rows.length;
    });
  }
}

// Where and how fast the brake runs along the train.
export class Waves {
  constructor(view, map) {
    view.add((changed) => {
      if (!changed.has("data")) return;
      const rows = map.waves.slice(-200).map(({ direction, begin, end, speed }) => {
        const what = direction > 0 ? "applies" : "releases";
        const cells = [
          what,
          begin[1] + 1,
          begin[0].toFixed(2),
          end[1] + 1,
          end[0].toFixed(2),
          Number.isNaN(speed) ? "–" : speed.toFixed(0),
        ];
        return element(
          "tr",
          { onclick: () => view.look(begin[0]) },
          ...cells.map((text) => element("td", {}, String(text))),
        );
      });
      byId("waves-body").replaceChildren(...rows);
      byId("waves").hidden = !rows.length;
    });
  }
}

// The numbers of haul analyze, a table at a time.
export class NumberTables {
  constructor(view, tables) {
    Object.assign(this, { view, tables, order: null });
    const names = Object.keys(tables);
    byId("tables").hidden = !names.length;
    byId("table-name").replaceChildren(
      ...names.map((name) => element("option", { value: name }, name.replaceAll("_", " "))),
    );
    byId("table-name").addEventListener("change", () => {
      this.order = null;
      this.draw();
    });
    if (names.length) this.draw();
  }

  sortBy(column) {
    const falling = this.order?.column === column ? !this.order.falling : true;
    this.order = { column, falling };
    this.draw();
  }

  draw() {
    const { columns, rows, count } = this.tables[byId("table-name").value];
    const { order } = this;
    const heads = columns.map((name, k) => {
      const sorted = k === order?.column ? (order.falling ? "descending" : "ascending") : false;
      return element(
        "th",
        { scope: "col", "aria-sort": sorted },
        element("button", { type: "button", onclick: () => this.sortBy(k) }, name.replaceAll("_", " ")),
      );
    });
    byId("table-head").replaceChildren(element("tr", {}, ...heads));
    const shown = order
      ? [...rows].sort((a, b) => (order.falling ? -1 : 1) * compared(a[order.column], b[order.column]))
      : rows;
    const lines = shown
      .slice(0, MOST_ROWS)
      .map((row) =>
        element(
          "tr",
          { onclick: () => this.go(columns, row) },
          ...row.map((value) => element("td", {}, value === null ? "–" : String(value))),
        ),
      );
    byId("table-body").replaceChildren(...lines);
    byId("table-note").textContent = count > lines.length ? `${lines.length} of ${count} rows` : "";
  }

  // To the coupler that a row is of, and to its time.
  go(columns, row) {
    const { view } = this;
    const coupler = row.find((value) => typeof value === "string" && view.run.couplers.includes(value));
    if (coupler) view.choose(view.run.couplers.indexOf(coupler));
    const time = row[columns.findIndex((name) => name.endsWith("time_s") || name.endsWith("begin_s"))];
    if (typeof time === "number") view.look(time);
  }
}

function compared(a, b) {
  if (typeof a === "string" || typeof b === "string")
    return String(b ?? "").localeCompare(String(a ?? ""), "en", { numeric: true });
  return (a ?? Number.NEGATIVE_INFINITY) - (b ?? Number.NEGATIVE_INFINITY) || 0;
}

// Figures of the whole run, each a label, a value and where or when.
export function showSummary(items) {
  byId("summary").replaceChildren(
    ...items.map(({ label, value, more }) =>
      element(
        "div",
        { class: "figure" },
        element("span", {}, label),
        element("b", {}, value),
        element("small", {}, more ?? ""),
      ),
    ),
  );
}
