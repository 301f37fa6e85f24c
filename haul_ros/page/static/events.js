// The chosen couplers, and what happened.

import { styleColour } from "./colours.js";
import { byId, element, seconds } from "./dom.js";

const MOST_EVENTS = 500; // lines shown

export class Chips {
  constructor(view) {
    this.view = view;
    byId("add-coupler").max = view.run.couplers.length;
    byId("add-form").addEventListener("submit", (event) => {
      event.preventDefault();
      view.choose(byId("add-coupler").valueAsNumber - 1);
      byId("add-coupler").value = "";
    });
    view.add((changed) => {
      if (changed.has("chosen") || changed.has("theme")) this.draw();
    });
    this.draw();
  }

  draw() {
    const chips = this.view.chosen.map((row, k) => {
      const name = this.view.run.couplers[row];
      const chip = element(
        "button",
        {
          class: "chip",
          type: "button",
          title: "remove",
          "aria-label": `remove ${name}`,
          onclick: () => this.view.drop(row),
        },
        `${row + 1} ×`,
      );
      chip.style.setProperty("--colour", styleColour(`line-${k + 1}`));
      return chip;
    });
    byId("chips").replaceChildren(...chips);
  }
}

export class Events {
  constructor(view) {
    this.view = view;
    this.drawn = -1;
    this.filter = byId("event-filter");
    this.filter.addEventListener("change", () => this.draw());
    view.add((changed) => {
      if (changed.has("data") && this.drawn !== view.run.events.length + view.run.events.at(-1)?.time) this.draw();
      if (changed.has("cursor")) this.point();
    });
    this.draw();
  }

  draw() {
    const { run } = this.view;
    this.drawn = run.events.length + run.events.at(-1)?.time;
    const kinds = [...new Set(run.events.map(({ kind }) => kind))].sort();
    const chosen = this.filter.value;
    this.filter.replaceChildren(
      element("option", { value: "" }, "all"),
      ...kinds.map((kind) => element("option", { value: kind }, kind.replaceAll("_", " "))),
    );
    this.filter.value = kinds.includes(chosen) ? chosen : "";
    const wanted = run.events.filter(({ kind }) => !this.filter.value || kind === this.filter.value);
    // Live the newest come first, and of a long run not all are shown
    const shown = this.view.live ? wanted.slice(-MOST_EVENTS).reverse() : wanted.slice(0, MOST_EVENTS);
    const rows = shown.map((found) => {
      const row = element(
        "button",
        { type: "button", class: "event", title: found.text, onclick: () => this.go(found) },
        element("time", {}, seconds(found.time, 3)),
        element("span", { class: "kind" }, found.kind.replaceAll("_", " ")),
        element("span", {}, found.text),
      );
      row.dataset.time = found.time;
      return element("li", {}, row);
    });
    if (wanted.length > shown.length)
      rows.push(element("li", { class: "note" }, `and ${wanted.length - shown.length} more`));
    if (!rows.length) rows.push(element("li", { class: "note" }, "none"));
    byId("events").replaceChildren(...rows);
    this.point();
  }

  point() {
    for (const row of byId("events").querySelectorAll(".event")) {
      row.classList.toggle("near", Math.abs(Number(row.dataset.time) - this.view.cursor) < 0.25);
    }
  }

  // To its time, and to the coupler that it begins with.
  go({ time, text }) {
    this.view.look(time);
    const row = this.view.run.couplers.findIndex((name) => text.startsWith(`${name}:`) || text.startsWith(`${name} `));
    if (row >= 0) this.view.choose(row);
  }
}
