// The page: a run from its own data, or one that comes over a socket.

import { ColourBar } from "./colourbar.js";
import { Controls } from "./controls.js";
import { timeCharts } from "./curves.js";
import { byId, element } from "./dom.js";
import { Chips, Events } from "./events.js";
import { HeatMap } from "./heatmap.js";
import { connect } from "./live.js";
import { Pointer } from "./pointer.js";
import { ProfileChart } from "./profile.js";
import { Arrivals, NumberTables, Peaks, showSummary, Waves } from "./tables.js";
import { unpackedRun } from "./unpacking.js";
import { View } from "./view.js";

// All parts of the page for a run, which they show from now on.
export function show(run, live) {
  const view = new View(run, live);
  byId("main").hidden = false;
  byId("toolbar").hidden = false;
  byId("pipe-chart").hidden = !run.quantities.pipe;
  const map = new HeatMap(view);
  const parts = {
    colours: new ColourBar(view, map),
    pointer: new Pointer(map),
    charts: timeCharts(view),
    profile: new ProfileChart(view, "profile-chart"),
    chips: new Chips(view),
    events: new Events(view),
    peaks: new Peaks(view),
    arrivals: new Arrivals(view, map),
    waves: new Waves(view, map),
    controls: new Controls(view),
  };
  view.parts.push(() => document.body.setAttribute("data-ready", ""));
  view.changed("data", "range", "cursor", "quantity", "chosen", "playing");
  return { view, map, ...parts };
}

// The couplers of the largest forces are those to look at first.
function firstChoice(view, { compression, tension }) {
  const place = (values) => values.indexOf(Math.max(...values));
  if (!compression.length) return;
  view.choose(place(tension));
  view.choose(place(compression));
  view.setCursor(view.run.peaks.compression_time[place(compression)]);
}

async function start() {
  const contents = JSON.parse(byId("contents").textContent);
  byId("title").textContent = contents.title;
  byId("description").textContent = contents.description;
  if (contents.live) {
    connect(contents, show);
    return;
  }
  const run = await unpackedRun(contents);
  showSummary(contents.summary);
  byId("notes").replaceChildren(...contents.notes.map((note) => element("p", {}, note)));
  const { view } = show(run, false);
  new NumberTables(view, contents.tables);
  firstChoice(view, run.peaks);
}

start().catch((error) => {
  byId("status").textContent = `This page cannot be shown: ${error.message}. It needs a browser of 2023 or newer.`;
  byId("status").hidden = false;
  throw error;
});
