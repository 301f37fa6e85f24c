// What a brake does along the train, found in cylinder pressures: where it begins to apply, and to release.

const LEAST = 0.015; // of the largest pressure: less is no application
const STILL = 0.5; // seconds without rise after which a further rise is a new one
const APART = 1.5; // seconds between neighbours of one front

// When each vehicle's pressure begins to rise or to fall: [time, +1 or -1] for each vehicle.
function onsets(pressure, time, count, row) {
  const least = Math.max(LEAST * pressure.largest, 3);
  const found = [];
  let [low, high, since] = [pressure.value(0, row), pressure.value(0, row), time[0]];
  let rising = false;
  for (let i = 1; i < count; i++) {
    const value = pressure.value(i, row);
    if (rising) {
      if (value > high + least / 10) [high, since] = [value, time[i]];
      if (time[i] - since > STILL) [rising, low] = [false, high];
    }
    if (!rising && value > low + least) {
      found.push([time[i], 1]);
      [rising, high, since] = [true, value, time[i]];
    } else if (value < high - least) {
      if (!found.length || found.at(-1)[1] > 0) found.push([time[i], -1]);
      [rising, high, low] = [false, value, value];
    }
    if (!rising) low = Math.min(low, value);
    if (!rising && value > high) high = value;
  }
  return found;
}

// Lines of [time, vehicle] along which the brake applies (+1) or releases (-1).
export function brakeFronts(pressure, time, count) {
  if (!count) return [];
  const fronts = [];
  let open = [];
  for (let row = 0; row < pressure.rows; row++) {
    const continued = [];
    for (const [at, direction] of onsets(pressure, time, count, row)) {
      const candidates = open.filter(
        (front) => front.direction === direction && Math.abs(front.points.at(-1)[0] - at) < APART && !continued.includes(front),
      );
      const distance = (front) => Math.abs(front.points.at(-1)[0] - at);
      let front = candidates.sort((a, b) => distance(a) - distance(b))[0];
      if (!front) fronts.push((front = { direction, points: [] }));
      front.points.push([at, row]);
      continued.push(front);
    }
    open = continued;
  }
  return fronts.filter((front) => front.points.length > 1);
}

// Commands and when they took effect at the slaves: [sent, from vehicle, arrived, to vehicle] in seconds.
export function radioArrivals(run) {
  const vehicle = Object.fromEntries(run.located.map((locomotive) => [locomotive.name, locomotive.vehicle]));
  const found = [];
  for (const { name } of run.located) {
    if (name === "master" || !("master" in vehicle)) continue;
    const asked = run.commands.filter(
      ({ kind, locomotive }) => (kind === "brake" || kind === "emergency") && (locomotive === "master" || locomotive === name),
    );
    for (const [arrived, value] of run.applied[name]) {
      // Commands of no effect change nothing, so the value tells which it was
      const sent = asked.findLast((command) => command.time <= arrived && Math.abs(command.value - value) < 1e-6);
      if (sent) found.push({ sent: sent.time, from: vehicle.master, arrived, to: vehicle[name], name });
    }
  }
  return found.sort((a, b) => a.arrived - b.arrived);
}
