// Margins and ticks that all parts with an axis of time have in common.

export const LEFT = 62; // pixels
export const RIGHT = 14;

// Round times for an axis of so many pixels.
export function ticks(from, to, width, apart = 80) {
  const rough = ((to - from) * apart) / width;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((size) => size >= rough) ?? rough;
  const found = [];
  for (let k = Math.ceil(from / step - 1e-9); k * step <= to + 1e-9; k++) found.push(k * step);
  return { found, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
}
