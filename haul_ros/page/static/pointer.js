// What the pointer does on a heat map: looks, sets the time, chooses, zooms, tells values.

import { byId, seconds, tip } from "./dom.js";
import { TOP } from "./heatmap.js";
import { LEFT } from "./scales.js";

export class Pointer {
  constructor(map) {
    Object.assign(this, { map, view: map.view });
    this.listen();
  }

  listen() {
    const { map, view } = this;
    const { canvas } = map;
    const place = (event) => {
      const box = canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    canvas.addEventListener("pointerdown", (event) => {
      const [x, y] = place(event);
      map.drag = { x, now: x, y, touch: event.pointerType !== "mouse" };
      canvas.setPointerCapture(event.pointerId);
      if (map.drag.touch) view.look(map.timeAt(x));
    });
    canvas.addEventListener("pointermove", (event) => {
      const [x, y] = place(event);
      if (map.drag) {
        map.drag.now = Math.max(LEFT, Math.min(LEFT + map.width, x));
        if (map.drag.touch) view.look(map.timeAt(x));
        else map.drag.zooming ||= Math.abs(x - map.drag.x) > 5;
        map.draw();
      }
      this.hover(event, x, y);
    });
    canvas.addEventListener("pointerup", (event) => {
      const { drag } = map;
      map.drag = null;
      if (!drag) return;
      if (drag.zooming) view.setRange(...[map.timeAt(drag.x), map.timeAt(drag.now)].sort((a, b) => a - b));
      else this.click(...place(event));
      map.draw();
    });
    for (const end of ["pointercancel", "pointerleave"]) {
      canvas.addEventListener(end, () => {
        if (end === "pointercancel") map.drag = null;
        tip.hide();
      });
    }
    canvas.addEventListener("dblclick", () => view.reset());
    canvas.addEventListener(
      "wheel",
      (event) => {
        if (!event.ctrlKey && !event.shiftKey) return; // the page scrolls
        event.preventDefault();
        const [from, to] = view.range;
        const turn = Math.sign(event.deltaY || event.deltaX);
        if (event.ctrlKey) view.zoom(turn > 0 ? 1.25 : 0.8, map.timeAt(place(event)[0]));
        else view.setRange(from + 0.1 * turn * (to - from), to + 0.1 * turn * (to - from));
      },
      { passive: false },
    );
    byId("show-lines").addEventListener("change", () => map.draw());
  }

  click(x, y) {
    const { map } = this;
    this.view.look(map.timeAt(x));
    if (y >= TOP && !map.ofVehicles) this.view.choose(map.rowAt(y));
  }

  hover(event, x, y) {
    const { map, view } = this;
    if (x < LEFT || x > LEFT + map.width || !view.run.count) return tip.hide();
    const time = map.timeAt(x);
    if (y < TOP - 2) {
      const near = view.run.events.filter((found) => Math.abs(map.x(found.time) - x) < 5).slice(0, 6);
      return near.length
        ? tip.show(event.clientX, event.clientY, ...near.map((found) => `${seconds(found.time, 3)}  ${found.text}`))
        : tip.hide();
    }
    const [i, row] = [view.run.index(time), map.rowAt(y)];
    const value = view.shown.value(i, row);
    return tip.show(
      event.clientX,
      event.clientY,
      `${view.shown.names[row]} at ${seconds(view.run.time[i])}`,
      `${view.shown.text(value)}${this.word(value)}`,
    );
  }

  word(value) {
    if (!this.view.shown.diverging || !value) return "";
    return value > 0 ? " compression" : " tension";
  }
}
