// Colours of values and of lines, safe for colour-blind readers.

// ColorBrewer RdBu (C. Brewer), 11 classes: tension blue, nothing white, compression red.
const DIVERGING = [
  "#053061",
  "#2166ac",
  "#4393c3",
  "#92c5de",
  "#d1e5f0",
  "#ffffff",
  "#fddbc7",
  "#f4a582",
  "#d6604d",
  "#b2182b",
  "#67001f",
];
// Cividis (Nunez, Anderton, Renslow 2018), nine of its colours.
const SEQUENTIAL = [
  "#00224e",
  "#123570",
  "#3b496c",
  "#575d6d",
  "#707173",
  "#8a8678",
  "#a59c74",
  "#c3b369",
  "#e1cc55",
  "#fee838",
];
const STEPS = 511;

function channels(colour) {
  return [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
}

function table(colours) {
  const found = new Uint32Array(STEPS);
  for (let i = 0; i < STEPS; i++) {
    const place = (i / (STEPS - 1)) * (colours.length - 1);
    const first = Math.min(Math.floor(place), colours.length - 2);
    const [a, b] = [channels(colours[first]), channels(colours[first + 1])];
    const [red, green, blue] = a.map((value, k) => Math.round(value + (b[k] - value) * (place - first)));
    found[i] = (255 << 24) | (blue << 16) | (green << 8) | red; // bytes of a pixel, little endian
  }
  return found;
}

const TABLES = { diverging: table(DIVERGING), sequential: table(SEQUENTIAL) };

// A function from values to pixels: of both signs -limit..limit, else 0..limit. What is no number has no colour.
export function pixels(diverging, limit) {
  const colours = diverging ? TABLES.diverging : TABLES.sequential;
  const [offset, factor] = diverging ? [(STEPS - 1) / 2, (STEPS - 1) / 2 / limit] : [0, (STEPS - 1) / limit];
  return (value) => {
    if (Number.isNaN(value)) return 0;
    return colours[Math.max(0, Math.min(STEPS - 1, Math.round(offset + value * factor)))];
  };
}

// A colour of the style sheet by the name of its variable.
export function styleColour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

export const LINE_COLOURS = ["line-1", "line-2", "line-3", "line-4", "line-5", "line-6"];
