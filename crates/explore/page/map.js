// The map: cells on a canvas at the pixels of the screen, axes and lines over it; moved by mouse, touch, wheel and keys.

import { $, svg } from "./dom.js";
import { CELLS, cellAt, level, short, shortRadius, span, tickTexts, ticks, toPart, toValue, value, within } from "./plane.js";
import { LETTERS, NAMES, axes, limits, remember, state } from "./state.js";
import { NONE, Tiles } from "./tiles.js";

const EDGE = { left: 88, right: 14, top: 10, bottom: 46 }; // room for axes
const COARSER = 3; // levels by which the first look at a place is coarser: a 64th of the work
const FARTHEST = -1;
const CLICK = 4; // pixels that a hand may shake
const MOST_PIXELS = 4e6; // of the canvas: a larger screen shows each cell as several
const SOON = 200; // milliseconds after which computing is worth a word
const PAUSE = 350; // milliseconds of rest before the cell under the cross is spoken

export class MapView {
  constructor({ colours, chosen, left, failed }) {
    this.colours = colours;
    this.chosen = chosen;
    this.left = left;
    this.box = $("map");
    this.canvas = $("cells");
    this.over = $("over");
    this.hint = $("under").textContent; // what a mouse or fingers can do here
    this.paint = this.canvas.getContext("2d", { alpha: false });
    this.tiles = new Tiles(() => this.redraw(), failed);
    this.deepest = 0;
    this.lines = [];
    this.scale = null; // of numbers, where they colour the map
    this.pointer = null; // where the mouse is, over the map
    this.begun = null; // since when cells are computed
    this.firstMap = null; // when every pixel of the map first had a cell
    this.table();
    this.listen();
    new ResizeObserver(() => this.resize()).observe(this.box);
  }

  // Pixels of each pair of class and mechanism, and of what is outside the model.
  table() {
    const { tiles, period } = this.colours;
    const size = period * period;
    const { scale, below } = this.colours;
    this.lut = new Uint32Array((tiles.length + 3 + scale.length) * size);
    const pixel = (rgb) => 0xff000000 | ((rgb & 255) << 16) | (rgb & 0xff00) | (rgb >> 16);
    tiles.forEach((tile, kind) => this.lut.set(tile.pixels.map(pixel), kind * size));
    this.outside = tiles.length;
    this.pending = tiles.length + 1;
    // Numbers: below the scale, then its steps; where there is none, as classes have it.
    this.below = tiles.length + 2;
    [below, ...scale].forEach((rgb, i) => this.lut.fill(pixel(rgb), (this.below + i) * size, (this.below + i + 1) * size));
    const plain = (name) => tiles.findIndex((tile) => tile.class === name && tile.mechanism === null);
    [this.unknown, this.nothing] = [plain(null), plain("none")];
    for (let y = 0; y < period; y += 1) {
      for (let x = 0; x < period; x += 1) {
        const at = y * period + x;
        this.lut[this.outside * size + at] = pixel((x + period - y) % 6 === 0 ? 0x8a929a : 0xb9c0c7);
        this.lut[this.pending * size + at] = pixel((x >> 1) % 6 === 0 && (y >> 1) % 6 === 0 ? 0x9aa3ac : 0xd3d8dd);
      }
    }
  }

  // Which pixels each cell of a tile has.
  kinds(tile) {
    const scale = this.scale?.is ?? null;
    if (tile.kinds && tile.scale === scale) return tile.kinds;
    tile.scale = scale;
    if (scale) {
      tile.kinds = Uint16Array.from(tile.class, (code, i) => {
        if (tile.status[i] === NONE) return this.outside;
        const step = this.scale.step(tile, i);
        if (step !== null) return this.below + 1 + step;
        return code !== NONE && this.colours.classes[code] === "none" ? this.nothing : this.unknown;
      });
      return tile.kinds;
    }
    const across = this.colours.mechanisms.length + 1;
    const next = (code) => (code === NONE ? 0 : code + 1);
    tile.kinds = tile.class.map((code, i) =>
      tile.status[i] === NONE ? this.outside : next(code) * across + next(tile.mechanism[i]));
    return tile.kinds;
  }

  // Another scene.
  reset(deepest) {
    this.deepest = deepest;
    this.tiles.reset(state.scene);
    this.lines = [];
    this.moved();
  }

  resize() {
    const box = this.box.getBoundingClientRect();
    const width = Math.max(64, Math.floor(box.width - EDGE.left - EDGE.right));
    const height = Math.max(64, Math.floor(box.height - EDGE.top - EDGE.bottom));
    const ratio = Math.min(window.devicePixelRatio || 1, Math.sqrt(MOST_PIXELS / (width * height)));
    Object.assign(this.canvas.style, { left: `${EDGE.left}px`, top: `${EDGE.top}px`, width: `${width}px`, height: `${height}px` });
    [this.width, this.height] = [width, height];
    [this.canvas.width, this.canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    this.image = this.paint.createImageData(this.canvas.width, this.canvas.height);
    this.pixels = new Uint32Array(this.image.data.buffer);
    this.painted = false;
    this.moved();
  }

  get z() {
    return level(state.zoom, this.canvas.width, this.deepest);
  }

  // The closest zoom: some pixels a cell of the deepest level.
  get closest() {
    return this.deepest - Math.log2(this.canvas.width / CELLS) + 3;
  }

  // What is seen: from, to along x and y, in units of the window.
  get seen() {
    const half = span(state.zoom) / 2;
    return [[state.u - half, state.u + half], [state.v - half, state.v + half]];
  }

  // Ask for what is seen now, and draw what is there.
  moved() {
    if (!this.image || !this.tiles.scene) return;
    state.zoom = Math.min(this.closest, Math.max(FARTHEST, state.zoom));
    state.u = Math.min(1.5, Math.max(-0.5, state.u));
    state.v = Math.min(1.5, Math.max(-0.5, state.v));
    const levels = [...new Set([0, Math.max(0, this.z - COARSER), this.z])];
    this.tiles.want(levels.flatMap((z) => this.visible(z)));
    this.scale?.moved();
    remember();
    this.redraw();
    clearTimeout(this.rest);
    this.rest = setTimeout(() => this.speak(), PAUSE);
  }

  // The tiles of a level that are seen, the middle first.
  visible(z) {
    const [xs, ys] = this.seen.map(([from, to], axis) => {
      const [first, last] = [cellAt(from, z)[0], cellAt(to, z)[0]];
      const middle = [state.u, state.v][axis] * 2 ** z - 0.5;
      const list = [];
      for (let n = first; n <= last; n += 1) if (within(z, n)) list.push([n, Math.abs(n - middle)]);
      return list;
    });
    const all = xs.flatMap(([x, far]) => ys.map(([y, off]) => [z, x, y, Math.max(far, off)]));
    return all.sort((one, other) => one[3] - other[3]);
  }

  redraw() {
    if (this.drawing) return;
    this.drawing = requestAnimationFrame(() => {
      this.drawing = 0;
      this.draw();
    });
  }

  // Runs of pixels of one tile along an axis: the pixels, the tile, the cells in it.
  runs(from, size, scale, z) {
    const runs = [];
    for (let i = 0; i < size; i += 1) {
      const [tile, cell] = cellAt(from + ((i + 0.5) / size) * scale, z);
      const last = runs.at(-1);
      if (last?.tile === tile) last.cells.push(cell);
      else runs.push({ tile, start: i, cells: [cell] });
    }
    return runs;
  }

  draw() {
    if (!this.image || !this.tiles.scene) return;
    // Of another scene nothing is there yet: what was drawn stays until something is.
    if (this.painted && this.tiles.kept.size === 0) return;
    this.painted = true;
    const { pixels, lut } = this;
    const [W, H, z, s] = [this.canvas.width, this.canvas.height, this.z, span(state.zoom)];
    const [[left], [bottom]] = this.seen;
    const period = this.colours.period;
    const size = period * period;
    const thick = Math.max(1, Math.round(W / this.width));
    // Textures hold on to the plane.
    const start = [Math.floor((left / s) * W), Math.floor((bottom / s) * H)];
    const phase = (i, axis) => (((Math.floor((start[axis] + i) / thick) % period) + period) % period);
    const phases = Uint8Array.from({ length: W }, (_, i) => phase(i, 0));
    const [columns, rows] = [this.runs(left, W, s, z), this.runs(bottom, H, s, z)];
    let missing = 0;
    for (const row of rows) {
      for (const column of columns) {
        const found = within(z, column.tile) && within(z, row.tile) ? this.tiles.best(z, column.tile, row.tile) : null;
        const kinds = found && this.kinds(found.tile);
        const fold = found ? 2 ** found.up : 1;
        const cell = (run, i) => Math.floor((run.tile * CELLS + run.cells[i]) / fold) - Math.floor(run.tile / fold) * CELLS;
        const across = column.cells.map((_, i) => cell(column, i));
        if (!found && within(z, column.tile) && within(z, row.tile)) missing += 1;
        for (let j = 0; j < row.cells.length; j += 1) {
          const up = row.start + j;
          const texture = ((period - phase(up, 1)) % period) * period;
          const line = found ? cell(row, j) * CELLS : 0;
          let at = (H - 1 - up) * W + column.start;
          for (let i = 0; i < across.length; i += 1, at += 1) {
            const kind = found ? kinds[line + across[i]] : this.pending;
            pixels[at] = lut[kind * size + texture + phases[column.start + i]];
          }
        }
      }
    }
    this.paint.putImageData(this.image, 0, 0);
    this.tellBusy();
    this.tellUnder();
    if (missing === 0 && this.firstMap === null) this.firstMap = performance.now();
    this.drawOver();
  }

  // From the plane to the box, in units of CSS.
  place(u, v) {
    const [[left], [bottom]] = this.seen;
    const s = span(state.zoom);
    return [EDGE.left + ((u - left) / s) * this.width, EDGE.top + (1 - (v - bottom) / s) * this.height];
  }

  drawOver() {
    const [width, height] = [this.width, this.height];
    const [right, low] = [EDGE.left + width, EDGE.top + height];
    const parts = [svg("clipPath", { id: "inside" })];
    parts[0].append(svg("rect", { x: EDGE.left, y: EDGE.top, width, height }));
    const lines = svg("g", { "clip-path": "url(#inside)", fill: "none", "stroke-linejoin": "round" });
    for (const { points, kind, faint } of this.lines) {
      const d = this.path(points);
      if (!d) continue;
      lines.append(svg("path", { d, stroke: "#ffffff", "stroke-opacity": 0.6, "stroke-width": 3 }));
      lines.append(svg("path", { d, stroke: kind, "stroke-width": 1.3, "stroke-opacity": faint ? 0.5 : 1 }));
    }
    if (state.at) {
      const [x, y] = this.place(...limits().map((limit, axis) => toPart(limit, state.at[axis])));
      if (Number.isFinite(x + y) && Math.abs(x) < 1e5 && Math.abs(y) < 1e5) {
        lines.append(svg("circle", { cx: x, cy: y, r: 7, stroke: "#ffffff", "stroke-width": 5 }));
        lines.append(svg("circle", { cx: x, cy: y, r: 7, stroke: "#b3141e", "stroke-width": 2.5 }));
      }
    }
    const [cx, cy] = [EDGE.left + width / 2, EDGE.top + height / 2];
    const cross = `M${cx - 12},${cy}h8m8,0h8M${cx},${cy - 12}v8m0,8v8`;
    lines.append(svg("path", { d: cross, stroke: "#ffffff", "stroke-width": 4 }), svg("path", { d: cross, stroke: "#000000", "stroke-width": 1.5 }));
    parts.push(lines, svg("rect", { x: EDGE.left, y: EDGE.top, width, height, fill: "none", stroke: "var(--quiet)" }));
    const [xs, ys] = this.seen.map((range, axis) => range.map((part) => toValue(limits()[axis], part)));
    const [x, y] = axes();
    const across = ticks(...xs, Math.max(2, width / 110));
    const along = tickTexts(across);
    across.list.forEach((v, i) => {
      const [at] = this.place(toPart(limits()[0], v), 0);
      if (at < EDGE.left - 0.5 || at > right + 0.5) return;
      parts.push(svg("path", { d: `M${at},${low}v5`, stroke: "var(--quiet)" }));
      parts.push(svg("text", { x: at, y: low + 18, "text-anchor": "middle" }, along.texts[i]));
    });
    const name = (axis, base) => (base ? `${NAMES[axis.parameter]} = ${base}` : NAMES[axis.parameter]);
    parts.push(svg("text", { x: EDGE.left + width / 2, y: low + 38, "text-anchor": "middle" }, name(x, along.base)));
    const upward = ticks(...ys, Math.max(2, height / 70));
    const beside = tickTexts(upward);
    upward.list.forEach((v, i) => {
      const [, at] = this.place(0, toPart(limits()[1], v));
      if (at < EDGE.top - 0.5 || at > low + 0.5) return;
      parts.push(svg("path", { d: `M${EDGE.left},${at}h-5`, stroke: "var(--quiet)" }));
      parts.push(svg("text", { x: EDGE.left - 8, y: at + 4, "text-anchor": "end" }, beside.texts[i]));
    });
    const middle = EDGE.top + height / 2;
    const turned = { x: 0, y: 0, "text-anchor": "middle", transform: `translate(14 ${middle}) rotate(-90)` };
    parts.push(svg("text", turned, name(y, beside.base)));
    this.over.replaceChildren(...parts);
  }

  // A line of the plane in the box; what is far outside is left out, so that no number grows without bound.
  path(points) {
    const far = 4 * Math.max(this.width, this.height);
    let [d, down, before] = ["", false, null];
    const within = ([x, y]) => Math.abs(x) < far && Math.abs(y) < far;
    for (const point of points) {
      const at = this.place(...limits().map((limit, axis) => toPart(limit, point[axis])));
      // A long piece may cross what is seen though it ends far away: its ends are drawn in towards it.
      const here = within(at) || (before && within(before));
      if (here && !down && before) d += `M${before.map((v) => Math.max(-far, Math.min(far, v)).toFixed(2))}`;
      else if (here && !down) d += `M${at.map((v) => v.toFixed(2))}`;
      if (here && (down || before)) d += `L${at.map((v) => Math.max(-far, Math.min(far, v)).toFixed(2))}`;
      down = here && within(at);
      before = at;
    }
    return d;
  }

  // The cell at a place of the plane: its values, and what is known of it.
  cell(u, v) {
    const z = this.z;
    const [[x, i], [y, j]] = [cellAt(u, z), cellAt(v, z)];
    if (!within(z, x) || !within(z, y)) return null;
    const values = [value(limits()[0], z, x, i), value(limits()[1], z, y, j)];
    const found = this.tiles.best(z, x, y);
    if (!found) return { values, text: "computing" };
    const fold = 2 ** found.up;
    const fine = (tile, cell) => Math.floor((tile * CELLS + cell) / fold) - Math.floor(tile / fold) * CELLS;
    return { values, text: this.words(found.tile, fine(y, j) * CELLS + fine(x, i)) };
  }

  words(tile, i) {
    const { classes, mechanisms, statuses } = this.colours;
    if (tile.status[i] === NONE) return "outside the model: a parameter is out of range";
    const words = [tile.class[i] === NONE ? "class not known" : className(classes[tile.class[i]])];
    if (tile.mechanism[i] !== NONE) words.push(mechanismName(mechanisms[tile.mechanism[i]]));
    if (!Number.isNaN(tile.radius[i])) words.push(`largest |\u2060μ| ${shortRadius(tile.radius[i])}`);
    if (!Number.isNaN(tile.margin[i])) words.push(`margin ${short(tile.margin[i])}`);
    if (tile.solutions[i] > 1) words.push(`${tile.solutions[i]} breathers`);
    if (statuses[tile.status[i]] !== "ok") words.push(`status ${statuses[tile.status[i]]}`);
    return words.join(", ");
  }

  told({ values, text }) {
    const [x, y] = axes();
    const [one, other] = values.map((v) => String(v).replace("-", "−"));
    return `${LETTERS[x.parameter]} = ${one}, ${LETTERS[y.parameter]} = ${other}: ${text}`;
  }

  // What is under the pointer now: it, the map or what is known of the cell may have changed.
  tellUnder() {
    const cell = this.pointer ? this.cell(...this.under(this.pointer)) : null;
    const text = cell ? `Under the pointer: ${this.told(cell)}` : this.hint;
    if ($("under").textContent !== text) $("under").textContent = text;
  }

  // That cells are computed, where it takes long enough to be seen.
  tellBusy() {
    const { busy } = this.tiles;
    this.box.setAttribute("aria-busy", String(busy > 0));
    if (busy === 0) this.begun = null;
    this.begun ??= busy > 0 ? performance.now() : null;
    const shown = this.begun !== null && performance.now() - this.begun > SOON;
    $("busy").hidden = !shown;
    if (shown) $("busy").textContent = `computing, ${busy} ${busy === 1 ? "tile" : "tiles"} to come`;
    else if (busy > 0) setTimeout(() => this.redraw(), SOON);
  }

  speak() {
    const cell = this.cell(state.u, state.v);
    if (cell?.text === "computing") { // it will be there soon
      this.rest = setTimeout(() => this.speak(), PAUSE);
      return;
    }
    const text = cell ? `Under the cross: ${this.told(cell)}` : "Under the cross: outside";
    const line = $("cell");
    if (line.textContent !== text) line.textContent = text;
  }

  zoomBy(steps, u = state.u, v = state.v) {
    const before = span(state.zoom);
    state.zoom = Math.min(this.closest, Math.max(FARTHEST, state.zoom + steps));
    const part = span(state.zoom) / before;
    // The place stays where it is.
    state.u = u + (state.u - u) * part;
    state.v = v + (state.v - v) * part;
    this.moved();
  }

  panBy(across, up) {
    state.u += across * span(state.zoom);
    state.v += up * span(state.zoom);
    this.moved();
  }

  whole() {
    Object.assign(state, { u: 0.5, v: 0.5, zoom: 0 });
    this.moved();
  }

  choose(u, v) {
    const cell = this.cell(u, v);
    if (cell) this.chosen(cell.values);
  }

  // The place of the plane under a pointer.
  under(event) {
    const box = this.box.getBoundingClientRect();
    const [[left], [bottom]] = this.seen;
    const s = span(state.zoom);
    return [
      left + ((event.clientX - box.left - EDGE.left) / this.width) * s,
      bottom + (1 - (event.clientY - box.top - EDGE.top) / this.height) * s,
    ];
  }

  listen() {
    const down = new Map();
    let travelled = 0;
    const spread = () => {
      const [one, other] = [...down.values()];
      return Math.hypot(one.x - other.x, one.y - other.y);
    };
    this.box.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      this.box.setPointerCapture(event.pointerId);
      if (down.size === 0) travelled = 0;
      down.set(event.pointerId, { x: event.clientX, y: event.clientY });
    });
    this.box.addEventListener("pointerleave", () => {
      this.pointer = null;
      this.tellUnder();
    });
    this.box.addEventListener("pointermove", (event) => {
      this.pointer = event.pointerType === "mouse" ? { clientX: event.clientX, clientY: event.clientY } : null;
      this.tellUnder();
      const held = down.get(event.pointerId);
      if (!held) return;
      const before = down.size === 2 ? spread() : 0;
      const [dx, dy] = [event.clientX - held.x, event.clientY - held.y];
      travelled += Math.abs(dx) + Math.abs(dy);
      Object.assign(held, { x: event.clientX, y: event.clientY });
      if (travelled <= CLICK) return;
      const share = 1 / down.size;
      this.panBy((-dx / this.width) * share, (dy / this.height) * share);
      if (down.size === 2 && before > 0) {
        const [one, other] = [...down.values()];
        const middle = { clientX: (one.x + other.x) / 2, clientY: (one.y + other.y) / 2 };
        this.zoomBy(Math.log2(Math.max(1, spread()) / before), ...this.under(middle));
      }
    });
    const up = (event) => {
      const held = down.delete(event.pointerId);
      if (held && down.size === 0 && event.type === "pointerup" && travelled <= CLICK) this.choose(...this.under(event));
    };
    this.box.addEventListener("pointerup", up);
    this.box.addEventListener("pointercancel", up);
    this.box.addEventListener("wheel", (event) => {
      event.preventDefault();
      const lines = [1, 20, 400][event.deltaMode] ?? 1;
      this.zoomBy(Math.max(-2, Math.min(2, (-event.deltaY * lines) / 240)), ...this.under(event));
    }, { passive: false });
    this.box.addEventListener("keydown", (event) => this.key(event));
  }

  key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    // By one cell with Shift, or by an eighth of what is seen.
    const cell = 1 / (CELLS * 2 ** this.z * span(state.zoom));
    const step = event.shiftKey ? cell : 0.125;
    const does = {
      ArrowLeft: () => this.panBy(-step, 0), ArrowRight: () => this.panBy(step, 0),
      ArrowDown: () => this.panBy(0, -step), ArrowUp: () => this.panBy(0, step),
      "+": () => this.zoomBy(1), "=": () => this.zoomBy(1), "-": () => this.zoomBy(-1), "−": () => this.zoomBy(-1),
      0: () => this.whole(), Home: () => this.whole(),
      Enter: () => this.choose(state.u, state.v), Escape: () => this.left(),
    }[event.key];
    if (!does) return;
    event.preventDefault();
    does();
  }
}

export const className = (name) => {
  const [stability, sides] = name.includes("-") ? name.split("-") : ["", name];
  const breathers = { double: "double-sided", single: "single-sided", word: "of the words", none: "no breather" }[sides];
  return stability ? `${stability} ${breathers}` : breathers;
};
// Of mechanisms, and of borders, which have more names than these.
export const mechanismName = (name) =>
  ({ "plus-one": "through +1", "neimark-sacker": "Neimark–Sacker" })[name] ?? name.replaceAll("-", " ");
