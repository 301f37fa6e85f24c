// Play, time, zoom, theme and keys.

import { byId, element, seconds } from "./dom.js";

const SLIDER = 10000;

export class Controls {
  constructor(view) {
    this.view = view;
    this.listen();
    view.add((changed) => this.update(changed));
    const options = Object.values(view.run.quantities).map(({ key, label }) =>
      element("option", { value: key }, label),
    );
    byId("quantity").replaceChildren(...options);
  }

  update() {
    const { view } = this;
    const on = view.live ? view.following : view.playing;
    byId("play").textContent = on ? "❚❚" : "▶";
    byId("play").setAttribute("aria-label", view.live ? (on ? "hold" : "follow") : on ? "pause" : "play");
    byId("play").setAttribute("aria-pressed", on);
    byId("time").textContent = seconds(view.cursor);
    const length = view.run.end - view.run.start;
    byId("slider").value = length ? ((view.cursor - view.run.start) / length) * SLIDER : 0;
    byId("slider").setAttribute("aria-valuetext", seconds(view.cursor));
    byId("quantity").value = view.quantity;
  }

  listen() {
    const { view } = this;
    byId("slider").addEventListener("input", (event) => {
      view.look(view.run.start + (event.target.valueAsNumber / SLIDER) * (view.run.end - view.run.start));
    });
    byId("play").addEventListener("click", () => this.toggle());
    byId("quantity").addEventListener("change", (event) => view.setQuantity(event.target.value));
    byId("zoom-in").addEventListener("click", () => view.zoomAtCursor(0.5));
    byId("zoom-out").addEventListener("click", () => view.zoomAtCursor(2));
    byId("zoom-all").addEventListener("click", () => view.reset());
    byId("theme").addEventListener("click", () => this.switchTheme());
    byId("help").addEventListener("click", () => byId("keys").showModal());
    byId("keys").addEventListener("click", () => byId("keys").close());
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => view.changed("theme"));
    document.addEventListener("keydown", (event) => this.key(event));
  }

  switchTheme() {
    const root = document.documentElement;
    const dark = root.dataset.theme
      ? root.dataset.theme === "dark"
      : matchMedia("(prefers-color-scheme: dark)").matches;
    root.dataset.theme = dark ? "light" : "dark";
    this.view.changed("theme");
  }

  toggle() {
    const { view } = this;
    if (view.live) return view.follow(!view.following);
    view.playing = !view.playing;
    if (view.playing && view.cursor >= view.run.end) view.setCursor(view.run.start);
    view.changed("playing");
    if (view.playing) this.play();
    return undefined;
  }

  // Time runs, as many times as fast as chosen.
  play() {
    let before = performance.now();
    const advance = (now) => {
      const { view } = this;
      if (!view.playing) return;
      const elapsed = ((now - before) / 1000) * Number(byId("rate").value);
      before = now;
      view.setCursor(view.cursor + Math.max(elapsed, 0));
      if (view.cursor >= view.run.end) {
        view.playing = false;
        view.changed("playing");
      } else requestAnimationFrame(advance);
    };
    requestAnimationFrame(advance);
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || byId("keys").open) return;
    if (event.target.closest("input, select, textarea")) return; // they have keys of their own
    if (event.key === " " && event.target.closest("button")) return;
    const { view } = this;
    const second = Math.max(1, Math.round((view.run.count - 1) / Math.max(view.run.end - view.run.start, 1e-9)));
    const newest = view.chosen.at(-1) ?? -1;
    const keys = {
      " ": () => this.toggle(),
      ArrowLeft: () => view.stepCursor(event.shiftKey ? -second : -1),
      ArrowRight: () => view.stepCursor(event.shiftKey ? second : 1),
      Home: () => view.look(view.run.start),
      End: () => view.look(view.run.end),
      "+": () => view.zoomAtCursor(0.5),
      "=": () => view.zoomAtCursor(0.5),
      "-": () => view.zoomAtCursor(2),
      0: () => view.reset(),
      "[": () => view.replaceNewest(newest - 1),
      "]": () => view.replaceNewest(newest + 1),
      q: () => {
        const all = Object.keys(view.run.quantities);
        view.setQuantity(all[(all.indexOf(view.quantity) + 1) % all.length]);
      },
      d: () => this.switchTheme(),
      "?": () => byId("keys").showModal(),
    };
    if (!(event.key in keys)) return;
    event.preventDefault();
    keys[event.key]();
  }
}
