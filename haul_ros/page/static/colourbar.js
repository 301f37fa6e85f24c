// The scale of the colours of a heat map.

import { pixels } from "./colours.js";
import { byId } from "./dom.js";

export class ColourBar {
  constructor(view, map) {
    this.canvas = byId("colour-bar");
    view.add((changed) => {
      if (["data", "quantity"].some((what) => changed.has(what))) this.draw(view.shown, map.limit, !map.ofVehicles);
    });
  }

  draw({ diverging, unit, title }, limit, ofCouplers) {
    const { canvas } = this;
    Object.assign(canvas, { width: 180, height: 1 });
    const context = canvas.getContext("2d");
    const image = context.createImageData(180, 1);
    const colour = pixels(diverging, limit);
    const target = new Uint32Array(image.data.buffer);
    for (let x = 0; x < 180; x++) target[x] = colour(diverging ? (x / 89.5 - 1) * limit : (x / 179) * limit);
    context.putImageData(image, 0, 0);
    const shown = limit.toFixed(limit < 10 ? 1 : 0);
    byId("map-title").textContent = `${title} over time [s] and ${ofCouplers ? "couplers" : "vehicles"} from the head`;
    byId("colour-low").textContent = diverging ? `tension ${shown}` : "0";
    byId("colour-high").textContent = diverging ? `${shown} ${unit} compression` : `${shown} ${unit}`;
  }
}
