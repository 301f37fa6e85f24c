// What a brake does along the train, found in cylinder pressures: where it begins to apply, and to release.

const LEAST = 0.015; // of the largest pressure: less is no application
const STILL = 2; // seconds without rise after which a further rise is a new one
const APART = 1.5; // seconds between neighbours of one front

// When each vehicle's pressure begins to rise or to fall: [time, +1 or -1] for each vehicle.
function onsets(pressure, time, count, row) {
  const least = Math.max(LEAST * pressure.largest, 3);
  const found = [];
  let [low, high, since] = [pressure.value(0, row), pressure.value(0, row), time[0]];
  let [rising, before] = [false, low];
  for (let i = 1; i < count; i++) {
    const value = pressure.value(i, row);
    const crossing = (level) => time[i - 1] + ((level - before) / (value - before)) * (time[i] - time[i - 1]);
    if (rising) {
      if (value > high + least / 10) [high, since] = [value, time[i]];
      if (time[i] - since > STILL) [rising, low] = [false, high];
    }
    if (!rising && value > low + least) {
      found.push([crossing(low + least), 1]);
      [rising, high, since] = [true, value, time[i]];
    } else if (value < high - least) {
      if (!found.length || found.at(-1)[1] > 0) found.push([crossing(high - least), -1]);
      [rising, high, low] = [false, value, value];
    }
    if (!rising) low = Math.min(low, value);
    if (!rising && value > high) high = value;
    before = value;
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
        (front) =>
          front.direction === direction && Math.abs(front.points.at(-1)[0] - at) < APART && !continued.includes(front),
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

const STRAIGHT = 0.08; // seconds by which a front may depart from a straight line
const SHORTEST_LEG = 1 / 8; // of the train

// Indices at which a line of points has to be kept, so that no point lies further beside it (Ramer 1972).
function corners(points, from, to) {
  let [worst, at] = [STRAIGHT, -1];
  const [[t0, v0], [t1, v1]] = [points[from], points[to]];
  for (let k = from + 1; k < to; k++) {
    const [time, vehicle] = points[k];
    const away = Math.abs(time - (t0 + ((vehicle - v0) / (v1 - v0)) * (t1 - t0)));
    if (away > worst) [worst, at] = [away, k];
  }
  return at < 0 ? [to] : [...corners(points, from, at), ...corners(points, at, to)];
}

// Of the straight line of least squares through points (x, y).
function slope(points) {
  const mean = (k) => points.reduce((sum, point) => sum + point[k], 0) / points.length;
  const [x, y] = [mean(0), mean(1)];
  const sum = (of) => points.reduce((total, point) => total + of(point), 0);
  return sum((point) => (point[0] - x) * (point[1] - y)) / sum((point) => (point[0] - x) ** 2);
}

// The straight parts of fronts, each a wave that runs one way: when and where it begins and ends, and how fast it is [m/s].
export function brakeWaves(fronts, places, vehicles) {
  const found = [];
  for (const { direction, points } of fronts) {
    let from = 0;
    for (const to of corners(points, 0, points.length - 1)) {
      const [begin, end] = [points[from], points[to]].sort((a, b) => a[0] - b[0]);
      const leg = points.slice(from, to + 1).map(([time, vehicle]) => [time, places[vehicle]]);
      from = to;
      if (Math.abs(begin[1] - end[1]) < SHORTEST_LEG * vehicles || end[0] - begin[0] < STRAIGHT) continue;
      found.push({ direction, begin, end, speed: places.length ? Math.abs(slope(leg)) : Number.NaN });
    }
  }
  return found.sort((a, b) => a.begin[0] - b.begin[0]);
}

// Commands and when they took effect at the slaves: [sent, from vehicle, arrived, to vehicle] in seconds.
export function radioArrivals(run) {
  const vehicle = Object.fromEntries(run.located.map((locomotive) => [locomotive.name, locomotive.vehicle]));
  const found = [];
  for (const { name } of run.located) {
    if (name === "master" || !("master" in vehicle)) continue;
    const asked = run.commands.filter(
      ({ kind, locomotive }) =>
        (kind === "brake" || kind === "emergency") && (locomotive === "master" || locomotive === name),
    );
    for (const [arrived, value] of run.applied[name]) {
      // Commands of no effect change nothing, so the value tells which it was
      const sent = asked.findLast((command) => command.time <= arrived && Math.abs(command.value - value) < 1e-6);
      if (sent) found.push({ sent: sent.time, from: vehicle.master, arrived, to: vehicle[name], name });
    }
  }
  return found.sort((a, b) => a.arrived - b.arrived);
}
