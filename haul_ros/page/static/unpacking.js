// Arrays of a page as Python has packed them (packing.py), and the run of a report made of them.

import { Run } from "./run.js";

async function inflated(text) {
  const bytes = Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

// float64 as they are.
async function numbers(text) {
  return new Float64Array(await inflated(text));
}

// Whole multiples of a step in 16 bit, differences from one instant to the next; -32768 stands for no number.
async function multiples({ step, rows, packed }) {
  const bytes = new Uint8Array(await inflated(packed));
  const count = bytes.length >> 1;
  const values = new Float32Array(count);
  const whole = new Int16Array(count);
  for (let i = 0; i < count; i++) {
    whole[i] = (bytes[i] | (bytes[count + i] << 8)) + (i >= rows ? whole[i - rows] : 0);
    values[i] = whole[i] === -32768 ? Number.NaN : whole[i] * step;
  }
  return values;
}

export async function unpackedRun(contents) {
  const run = new Run(contents.train);
  run.time = await numbers(contents.time);
  run.count = run.time.length;
  const filled = run.all().map(async (quantity) => quantity.fill(await multiples(contents.quantities[quantity.key])));
  await Promise.all(filled);
  run.setPeaks(contents.peaks);
  run.events = contents.events;
  run.commands = contents.commands;
  Object.assign(run.applied, contents.applied);
  Object.assign(run.effort, contents.effort);
  return run;
}
