// The run as it comes over the socket; connects again by itself, for as long as the page is there.

import { byId, element } from "./dom.js";
import { Desk } from "./desk.js";
import { Run } from "./run.js";

const AGAIN = 1000; // ms until the next try
const SILENCE = 1500; // ms without a frame after which the page says so
const MOST_INSTANTS = 6000; // ten minutes at 10 frames a second
const MOST_KEPT = 2000;
const SHOWN = 60; // seconds of the newest that are shown at first

export function connect(contents, show) {
  const live = new Live(show);
  live.open();
}

class Live {
  constructor(show) {
    this.show = show;
    this.parts = null;
    this.state = {};
    this.last = performance.now();
    this.paused = false;
    setInterval(() => this.tellStatus(), 500);
    byId("node").addEventListener("change", (event) => this.ask({ do: "watch", node: event.target.value }));
  }

  open() {
    const token = new URLSearchParams(location.search).get("token") ?? "";
    this.socket = new WebSocket(`ws://${location.host}/live?token=${encodeURIComponent(token)}`);
    this.socket.binaryType = "arraybuffer";
    this.socket.addEventListener("message", ({ data }) =>
      typeof data === "string" ? this.take(JSON.parse(data)) : this.frame(data),
    );
    this.socket.addEventListener("close", () => {
      this.tellStatus();
      setTimeout(() => this.open(), AGAIN);
    });
  }

  get connected() {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  ask(what) {
    if (this.connected) this.socket.send(JSON.stringify(what));
    else this.desk?.answer({ done: false, text: "haul view is not there" });
  }

  take(message) {
    const view = this.parts?.view;
    const takers = {
      hello: () => this.hello(message),
      state: () => this.takeState(message),
      answer: () => this.desk?.answer(message),
      event: () => view && (view.run.events = [...view.run.events, message].slice(-MOST_KEPT)),
      command: () => view?.run.commands.push(message),
      applied: () => view?.run.applied[message.locomotive]?.push([message.time, message.value]),
      effort: () => view?.run.effort[message.locomotive]?.push([message.time, message.value]),
      peaks: () => view?.run.setPeaks(message),
    };
    takers[message.is]?.();
    if (message.is === "applied" || message.is === "effort") this.desk?.acts(message);
  }

  // The beginning of a run, or of what is known of it. A page has one train: for another it starts anew.
  hello({ train, node, nodes, drive }) {
    this.showNodes(nodes, node);
    byId("title").textContent = node ?? "haul view";
    document.title = `${node ?? "haul"} – live`;
    if (!train) return;
    const key = JSON.stringify([node, train]);
    if (this.parts && this.key !== key) {
      location.reload();
      return;
    }
    if (this.parts) this.parts.view.run.clear();
    else this.begin(new Run(train), drive);
    this.key = key;
    this.parts.view.follow(true);
    this.parts.view.changed("data", "chosen", "cursor");
  }

  begin(run, drive) {
    byId("main").hidden = false; // so that it has a size
    if (drive) this.desk = new Desk(run, (what) => this.ask(what));
    this.parts = this.show(run, true);
    for (const name of ["rate"]) byId(name).hidden = true;
    const middle = Math.floor(run.couplers.length / 2);
    for (const row of [Math.floor(middle / 2), middle, Math.floor((3 * middle) / 2)]) this.parts.view.choose(row);
    this.desk?.state(this.state);
  }

  frame(data) {
    if (!this.parts) return;
    const { view } = this.parts;
    const { run } = view;
    const time = new DataView(data).getFloat64(0, true);
    const numbers = new Float32Array(data, 8);
    const values = {};
    let at = 0;
    for (const quantity of [run.speed, ...Object.values(run.quantities)]) {
      values[quantity.key] = numbers.subarray(at, at + quantity.rows);
      at += quantity.rows;
    }
    const whole = view.whole && view.following && view.range[1] - view.range[0] < SHOWN - 1;
    run.append(time, values, MOST_INSTANTS);
    this.last = performance.now();
    this.desk?.speed(run.speed.value(run.count - 1, 0));
    if (view.following) {
      const length =
        whole || run.count < 3 ? Math.min(SHOWN, Math.max(run.end - run.start, 5)) : view.range[1] - view.range[0];
      view.range = [Math.max(run.start, run.end - length), Math.max(run.end, run.start + length)];
      view.whole = length < SHOWN;
      view.cursor = run.end;
      view.changed("range", "cursor");
    }
    view.changed("data");
  }

  takeState(message) {
    Object.assign(this.state, message);
    if (message.nodes) this.showNodes(message.nodes, byId("node").value);
    this.desk?.state(this.state);
    this.tellStatus();
  }

  showNodes(nodes, chosen) {
    byId("node").replaceChildren(...nodes.map((name) => element("option", { value: name }, name)));
    byId("node").value = chosen;
    byId("node").hidden = nodes.length < 2;
  }

  tellStatus() {
    const { present, pace, scenario, factor } = this.state;
    const silent = performance.now() - this.last > SILENCE;
    const waiting = pace?.startsWith("starting") ? pace : "waiting for a node with a train on this ROS domain";
    let text = "";
    if (!this.connected) text = "haul view is not there; trying again";
    else if (!present) text = this.parts ? "the node has gone; waiting for it" : waiting;
    else if (silent && pace === "paused") text = "paused";
    else if (silent) text = this.parts ? "no samples come" : waiting;
    byId("status").textContent = text;
    byId("status").hidden = !text;
    byId("description").textContent = [scenario, pace, factor === undefined ? "" : `${factor.toFixed(2)} × real time`]
      .filter(Boolean)
      .join(" · ");
  }
}
