// The plane that is flown over, in units of its window: (0, 0) is the window's lower left corner, (1, 1) its upper right one. The window fills
// the map at zoom 0; each further zoom halves what is seen. All formulas for values are those of the program, in the same order of operations, so that
// a cell that is clicked on is, to the bit, the point that was computed.

export const CELLS = 64;
export const BESIDE = 1;

const step = ([from, to], z) => (to - from) / (CELLS * 2 ** z);

// Value of cell `i` of tile `number` along an axis.
export function value(limits, z, number, i) {
  const at = (cell) => limits[0] + (number * CELLS + cell + 0.5) * step(limits, z);
  const [first, last] = [at(0), at(CELLS - 1)];
  return i === CELLS - 1 ? last : first + (i * (last - first)) / (CELLS - 1);
}

// The cell at a place of the plane: its tile along an axis, and its number there.
export function cellAt(part, z) {
  const cell = Math.floor(part * CELLS * 2 ** z);
  const tile = Math.floor(cell / CELLS);
  return [tile, cell - tile * CELLS];
}

export const span = (zoom) => 2 ** -zoom;
export const within = (z, number) => number >= -BESIDE * 2 ** z && number < (1 + BESIDE) * 2 ** z;
export const toPart = ([from, to], v) => (v - from) / (to - from);
export const toValue = ([from, to], part) => from + part * (to - from);

// The level whose cells are nearest to a pixel, of a map that is `pixels` wide.
export function level(zoom, pixels, deepest) {
  return Math.max(0, Math.min(deepest, Math.floor(zoom + Math.log2(pixels / CELLS) + 0.5)));
}

// Round numbers between two, about `count` of them, and two at least: one alone is no scale.
export function ticks(from, to, count) {
  const rough = (to - from) / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  const within = (step) => {
    const first = Math.ceil(from / step - 1e-9);
    const list = [];
    for (let k = 0; k < 50 && (first + k) * step <= to + 1e-9 * step; k += 1) list.push((first + k) * step);
    return { step, list };
  };
  const steps = [10, 5, 2, 1, 0.5, 0.2].map((n) => n * power);
  const start = steps.findLastIndex((step) => step >= rough * 0.999);
  return steps.slice(Math.max(0, start)).map(within).find(({ list }) => list.length > 1) ?? within(steps.at(-1));
}

// How ticks are written: by digits, or, where these would be too many, as what comes on top of one of them.
export function tickTexts({ step, list }) {
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  if (decimals <= 6) return { base: "", texts: list.map((v) => v.toFixed(decimals).replace("-", "−")) };
  const middle = list[Math.floor(list.length / 2)] ?? 0;
  const power = Math.floor(Math.log10(step) + 1e-9);
  const texts = list.map((v) => {
    const steps = Math.round((v - middle) / 10 ** power);
    return steps === 0 ? "0" : `${steps > 0 ? "+" : "−"}${Math.abs(steps)}`;
  });
  return { base: `${middle.toFixed(Math.min(17, decimals))} + 10${raised(power)} ×`, texts };
}

const raised = (power) => String(power).replace("-", "⁻").replace(/\d/g, (d) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[d]);

// A number for people.
export function short(v) {
  if (v === null || v === undefined || Number.isNaN(v)) return "–";
  const text = Math.abs(v) !== 0 && (Math.abs(v) < 1e-3 || Math.abs(v) >= 1e6) ? v.toExponential(4) : String(Number(v.toPrecision(8)));
  return text.replace("-", "−");
}

// What a number is near 1: the distance is what matters.
export function shortRadius(v) {
  return v > 1 && v < 1.0001 ? `1 + ${(v - 1).toExponential(2).replace("-", "−")}` : short(v);
}
