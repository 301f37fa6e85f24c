// The driver's desk: handles, what the locomotives do, and the radio links.

import { byId, element } from "./dom.js";

const REST = 100; // ms between two demands while a handle moves
const MOST_EFFORT = 800; // kN

// Calls the newest of many at most so often.
function spaced(action) {
  let [timer, due] = [null, null];
  return (...what) => {
    due = what;
    if (timer) return;
    action(...due);
    due = null;
    timer = setTimeout(() => {
      timer = null;
      if (due) action(...due);
    }, REST);
  };
}

function handle(label, { id, most, unit, step, set }) {
  const shown = element("output", { for: id }, `0 ${unit}`);
  const slider = element("input", { id, type: "range", min: 0, max: most, step, value: 0, "aria-label": label });
  const send = spaced(set);
  slider.addEventListener("input", () => {
    shown.textContent = `${slider.value} ${unit}`;
    send(slider.valueAsNumber);
  });
  return {
    slider,
    row: element("div", { class: "handle" }, element("label", { for: id }, label), slider, shown),
    put(value) {
      slider.value = value;
      shown.textContent = `${value} ${unit}`;
    },
  };
}

function button(id, text, press) {
  return element("button", { id, type: "button", onclick: press }, text);
}

export class Desk {
  constructor(run, ask) {
    this.ask = ask;
    this.slaves = {};
    const names = run.locomotives.map(({ name }) => name);
    this.target = element(
      "select",
      { id: "target", "aria-label": "locomotive" },
      ...names.map((name) =>
        element(
          "option",
          { value: name },
          name === "master" ? "master, and by radio all slaves" : `${name.replace("_", " ")} alone`,
        ),
      ),
    );
    this.brake = handle("brake", {
      id: "brake",
      most: 100,
      unit: "%",
      step: 1,
      set: (value) => this.command("brake", value / 100),
    });
    this.traction = handle("traction", {
      id: "traction",
      most: MOST_EFFORT,
      unit: "kN",
      step: 10,
      set: (value) => this.effort("traction", value),
    });
    this.electric = handle("electric brake", {
      id: "electric",
      most: MOST_EFFORT,
      unit: "kN",
      step: 10,
      set: (value) => this.effort("electric_brake", value),
    });
    this.shownSpeed = element("b", { id: "desk-speed" }, "–");
    this.pause = button("pause", "pause", () => ask({ do: "pause", value: this.pause.textContent === "pause" }));
    const driving = element(
      "fieldset",
      {},
      element("legend", {}, "Handles of ", this.target),
      this.brake.row,
      this.traction.row,
      this.electric.row,
    );
    const stopping = element(
      "fieldset",
      {},
      element("legend", {}, "Head ", this.shownSpeed),
      button("emergency", "EMERGENCY", () => this.command("emergency", 1)),
      button("release-emergency", "end emergency, at standstill", () => this.endEmergency()),
      element(
        "div",
        { class: "row" },
        this.pause,
        button("step", "step", () => ask({ do: "step" })),
        button("reset", "reset", () => this.reset()),
      ),
    );
    const links = element(
      "fieldset",
      {},
      element("legend", {}, "Radio links: up, delay in s, and what the slave does"),
      ...names.filter((name) => name !== "master").map((name) => this.slave(name)),
    );
    this.told = element("p", { id: "answer", role: "status" });
    byId("desk").replaceChildren(
      element("h2", {}, "Driver's desk"),
      element("div", { class: "desk-grid" }, driving, stopping, links),
      this.told,
    );
    byId("desk").hidden = false;
  }

  slave(name) {
    const up = element("input", { type: "checkbox", id: `${name}-up`, "aria-label": `link to ${name}` });
    const delay = element("input", {
      type: "number",
      id: `${name}-delay`,
      min: 0,
      max: 3600,
      step: "any",
      "aria-label": `delay of ${name} in s`,
    });
    const does = element("output", {}, "–");
    up.addEventListener("change", () => this.ask({ do: "link", slave: name, connected: up.checked }));
    delay.addEventListener(
      "change",
      () => delay.reportValidity() && delay.value && this.ask({ do: "link", slave: name, delay: delay.valueAsNumber }),
    );
    this.slaves[name] = { up, delay, does, applied: 0, effort: 0 };
    return element("div", { class: "slave" }, element("span", {}, name.replace("_", " ")), up, delay, does);
  }

  command(kind, value) {
    this.ask({ do: "command", locomotive: this.target.value, kind, value });
  }

  // The newer of the two counts at the locomotive, so the other handle goes back.
  effort(kind, value) {
    (kind === "traction" ? this.electric : this.traction).put(0);
    this.command(kind, value * 1000);
  }

  endEmergency() {
    this.brake.put(0);
    this.command("emergency", 0);
  }

  reset() {
    for (const one of [this.brake, this.traction, this.electric]) one.put(0);
    this.ask({ do: "reset" });
  }

  answer({ done, text }) {
    this.told.textContent = text;
    this.told.classList.toggle("lost", !done);
  }

  speed(value) {
    this.shownSpeed.textContent = `${value.toFixed(1)} km/h`;
  }

  acts({ is, locomotive, value }) {
    if (is === "applied" && locomotive === "master" && document.activeElement !== this.brake.slider)
      this.brake.put(Math.round(100 * value));
    const slave = this.slaves[locomotive];
    if (!slave) return;
    slave[is] = value;
    this.showSlave(slave);
  }

  showSlave(slave) {
    const heard = slave.heard === false ? ", hears nothing" : "";
    slave.does.textContent = `brake ${(100 * slave.applied).toFixed(0)} %, ${(slave.effort / 1000).toFixed(0)} kN${heard}`;
    slave.does.classList.toggle("lost", slave.heard === false || slave.up.checked === false);
  }

  state({ links = {}, pace }) {
    this.pause.textContent = pace === "paused" ? "go on" : "pause";
    for (const [name, { delay, connected, heard }] of Object.entries(links)) {
      const slave = this.slaves[name];
      if (!slave) continue;
      if (connected !== undefined) slave.up.checked = connected;
      if (delay !== undefined && document.activeElement !== slave.delay) slave.delay.value = delay;
      slave.heard = heard;
      this.showSlave(slave);
    }
  }
}
