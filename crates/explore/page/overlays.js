// Lines over the map, computed for what is seen when they are asked for: borders, and where two modes collide.

import { gone, post } from "./ask.js";
import { table } from "./chart.js";
import { $ } from "./dom.js";
import { mechanismName } from "./map.js";
import { toValue } from "./plane.js";
import { limits, remember, state } from "./state.js";

const TOLERANCE = 1e-4; // of what is seen: a tenth of a pixel
const POINTS = { curves: [200, 150], stripes: [400, 300] }; // cells; from the latter stripes are judged

// The scene of what is seen, with so many cells; `inside` its window alone, beyond which parameters may be out of range.
export function sceneOfView(map, [across, up], inside = false) {
  const scene = structuredClone(state.scene);
  map.seen.forEach((range, axis) => {
    const name = "xy"[axis];
    const held = range.map((part) => (inside ? Math.min(1, Math.max(0, part)) : part));
    const [from, to] = (held[0] < held[1] ? held : [0, 1]).map((part) => toValue(limits()[axis], part));
    Object.assign(scene.sweep[name], { from, to, points: [across, up][axis] });
  });
  return scene;
}

export class Overlays {
  constructor(map) {
    this.map = map;
    this.colours = map.colours.borders.map((rgb) => `#${rgb.toString(16).padStart(6, "0")}`);
    this.lines = { curves: [], stripes: [] };
    for (const name of ["curves", "stripes"]) {
      $(name).addEventListener("click", () => (state.over.includes(name) || this.busy === name ? this.drop(name) : this.ask(name)));
    }
  }

  reset() {
    this.controller?.abort();
    this.lines = { curves: [], stripes: [] };
    state.over = [];
    $("lines").textContent = "";
    this.show();
  }

  show() {
    for (const name of ["curves", "stripes"]) $(name).setAttribute("aria-pressed", String(state.over.includes(name) || this.busy === name));
    this.map.lines = [...this.lines.curves, ...this.lines.stripes];
    const key = new Map(this.map.lines.map(({ name, kind }) => [name, kind]));
    $("linekey").replaceChildren(...[...key].map(([name, kind]) => {
      const item = document.createElement("li");
      const swatch = document.createElement("span");
      swatch.style.background = kind;
      item.append(swatch, name);
      return item;
    }));
    this.map.redraw();
    remember();
  }

  drop(name) {
    if (this.busy === name) this.controller.abort();
    state.over = state.over.filter((other) => other !== name);
    this.lines[name] = [];
    $("lines").textContent = "";
    this.show();
  }

  async ask(name) {
    this.controller?.abort();
    const controller = new AbortController();
    this.controller = controller;
    this.busy = name;
    $("lines").textContent = "computing for what is seen; press again to stop";
    this.show();
    try {
      const scene = sceneOfView(this.map, POINTS[name]);
      const body = name === "curves" ? { scene, tolerance: TOLERANCE, places: 0 } : { scene };
      const answer = await post(name, body, controller.signal);
      this.lines[name] = name === "curves" ? borders(answer.answer, this.colours) : stripes(answer.files["stripes.csv"], this.colours[1]);
      state.over = [...new Set([...state.over, name])];
      const count = this.lines[name].length;
      $("lines").textContent = `${count} ${name === "curves" ? "borders" : "lines where two modes collide"}. ${answer.command}`;
    } catch (error) {
      if (this.controller === controller) $("lines").textContent = gone(error) ? "" : error.message;
    } finally {
      if (this.controller === controller) this.busy = null;
      this.show();
    }
  }
}

// Each kind has its colour, in order of use, as in printed maps.
function borders({ borders: list }, colours) {
  const kinds = [...new Set(list.map((border) => border.event))];
  const colour = (event) => colours[kinds.indexOf(event) % colours.length];
  return list.map(({ event, points }) => ({ points: points.map((point) => point.values), kind: colour(event), name: mechanismName(event) }));
}

// The table has a point a row of the map; a line that skips rows, or leaps, is two.
function stripes(text, colour) {
  const { names, rows } = table(text);
  const column = Object.fromEntries(names.map((name, i) => [name, i]));
  const name = (row) => ["family", "mode1", "mode2", "harmonic"].map((key) => row[column[key]]).join(" ");
  const sums = rows.filter((row) => row[column.sum] === "true").map((row) => ({ name: name(row), point: [Number(row[column.omega]), Number(row[column.gamma2])] }));
  const heights = [...new Set(sums.map(({ point }) => point[1]))].sort((one, other) => one - other);
  const row = new Map(heights.map((height, i) => [height, i]));
  const [from, to] = limits()[0];
  const [leap, bend] = [0.01, 0.003].map((part) => part * (to - from) * 2 ** -state.zoom);
  const lines = [];
  let [last, slant] = [null, null];
  for (const one of sums) {
    const step = one.point[0] - (last?.point[0] ?? 0);
    const next = last?.name === one.name && row.get(one.point[1]) - row.get(last.point[1]) === 1;
    if (next && Math.abs(step) < leap && (slant === null || Math.abs(step - slant) < bend)) {
      lines.at(-1).points.push(one.point);
      slant = step;
    } else {
      lines.push({ points: [one.point], kind: colour, name: "two modes collide" });
      slant = null;
    }
    last = one;
  }
  return lines.filter(({ points }) => points.length > 1);
}
