// Charts as SVG: curves, marks and levels in one pane, with a mark that moves along.

import { svg } from "./dom.js";
import { tickTexts, ticks } from "./plane.js";

const EDGE = { left: 52, right: 14, top: 8, bottom: 34 };

export const COLOURS = ["var(--a)", "var(--b)", "var(--c)", "var(--d)"];

// The least and largest of numbers, without spreading them over arguments: a run has many.
export function extent(numbers) {
  let [least, most] = [Infinity, -Infinity];
  for (const v of numbers) {
    if (v < least) least = v;
    if (v > most) most = v;
  }
  return [least, most];
}

function room([from, to]) {
  if (!(to >= from)) return [0, 1];
  const wide = to - from || Math.abs(to) || 1;
  return [from - 0.05 * wide, to + 0.05 * wide];
}

// `areas`: { upper, lower, colour }; `lines`: { points, colour, dash, width }; `dots`: { points, colour, hollow, size }; `levels`: heights of dashed lines; `equal`: one unit is as
// long along both axes; `circle`: the unit circle; `key`: names of colours.
export function chart(target, { label, x, y, areas = [], lines = [], dots = [], levels = [], equal = false, circle = false, key = [], height = 190 }) {
  const width = 400;
  const all = [...lines, ...dots].flatMap((part) => part.points);
  const spread = (axis) => {
    const numbers = all.map((point) => point[axis]);
    if (axis === 1) numbers.push(...levels);
    if (circle) numbers.push(-1, 1);
    return numbers;
  };
  let xs = x.range ?? room(extent(spread(0)));
  let ys = y.range ?? room(extent(spread(1)));
  const top = EDGE.top + (key.length ? 18 : 0);
  const [inner, tall] = [width - EDGE.left - EDGE.right, height - top - EDGE.bottom];
  if (equal) {
    const unit = Math.max((xs[1] - xs[0]) / inner, (ys[1] - ys[0]) / tall);
    const widen = ([from, to], size) => [(from + to - unit * size) / 2, (from + to + unit * size) / 2];
    [xs, ys] = [widen(xs, inner), widen(ys, tall)];
  }
  const px = (v) => EDGE.left + ((v - xs[0]) / (xs[1] - xs[0])) * inner;
  const py = (v) => top + (1 - (v - ys[0]) / (ys[1] - ys[0])) * tall;
  const parts = [];
  const horizontal = ticks(...xs, 5);
  const under = tickTexts(horizontal);
  horizontal.list.forEach((v, i) => {
    parts.push(svg("path", { d: `M${px(v)},${top}v${tall}`, stroke: "var(--grid)" }));
    parts.push(svg("text", { x: px(v), y: top + tall + 14, "text-anchor": "middle" }, under.texts[i]));
  });
  const vertical = ticks(...ys, 5);
  const beside = tickTexts(vertical);
  vertical.list.forEach((v, i) => {
    parts.push(svg("path", { d: `M${EDGE.left},${py(v)}h${inner}`, stroke: "var(--grid)" }));
    parts.push(svg("text", { x: EDGE.left - 5, y: py(v) + 4, "text-anchor": "end" }, beside.texts[i]));
  });
  for (const level of levels) parts.push(svg("path", { d: `M${EDGE.left},${py(level)}h${inner}`, stroke: "var(--quiet)", "stroke-dasharray": "5 4" }));
  if (circle) parts.push(svg("ellipse", { cx: px(0), cy: py(0), rx: px(1) - px(0), ry: py(0) - py(1), fill: "none", stroke: "var(--quiet)" }));
  for (const { upper, lower, colour } of areas) {
    const d = [...upper, ...lower.toReversed()].map(([a, b], i) => `${i ? "L" : "M"}${px(a).toFixed(2)},${py(b).toFixed(2)}`).join("");
    parts.push(svg("path", { d: `${d}Z`, fill: colour, "fill-opacity": 0.35 }));
  }
  for (const { points, colour, dash, width: thick = 1.6 } of lines) {
    if (points.length < 2) continue;
    const d = points.map(([a, b], i) => `${i ? "L" : "M"}${px(a).toFixed(2)},${py(b).toFixed(2)}`).join("");
    parts.push(svg("path", { d, fill: "none", stroke: colour, "stroke-width": thick, "stroke-linejoin": "round", ...(dash ? { "stroke-dasharray": dash } : {}) }));
  }
  for (const { points, colour, hollow, size = 3 } of dots) {
    const paint = hollow ? { fill: "var(--ground)", stroke: colour, "stroke-width": 1.4 } : { fill: colour };
    for (const [a, b] of points) parts.push(svg("circle", { cx: px(a).toFixed(2), cy: py(b).toFixed(2), r: size, ...paint }));
  }
  parts.push(svg("rect", { x: EDGE.left, y: top, width: inner, height: tall, fill: "none", stroke: "var(--quiet)" }));
  parts.push(svg("text", { x: EDGE.left + inner / 2, y: height - 4, "text-anchor": "middle" }, under.base ? `${x.label} = ${under.base}` : x.label));
  const turned = { x: 0, y: 0, "text-anchor": "middle", transform: `translate(12 ${top + tall / 2}) rotate(-90)` };
  parts.push(svg("text", turned, beside.base ? `${y.label} = ${beside.base}` : y.label));
  let at = EDGE.left;
  for (const [name, colour] of key) {
    parts.push(svg("path", { d: `M${at},12h16`, stroke: colour, "stroke-width": 3 }), svg("text", { x: at + 20, y: 16 }, name));
    at += 30 + 6.6 * name.length;
  }
  const mark = svg("circle", { r: 4.5, fill: "var(--mark)", stroke: "var(--ground)", "stroke-width": 1.5, visibility: "hidden" });
  parts.push(mark);
  target.setAttribute("viewBox", `0 0 ${width} ${height}`);
  target.setAttribute("aria-label", label);
  target.replaceChildren(...parts);
  return (a, b) => {
    if (Number.isFinite(a + b) && a >= xs[0] && a <= xs[1]) {
      mark.setAttribute("cx", px(a));
      mark.setAttribute("cy", py(b));
      mark.setAttribute("visibility", "visible");
    } else {
      mark.setAttribute("visibility", "hidden");
    }
  };
}

// A table of numbers, as the program writes it: the names of its columns, and its rows.
export function table(text) {
  const lines = text.trimEnd().split("\n");
  return { names: lines[0].split(","), rows: lines.slice(1).map((line) => line.split(",")) };
}
