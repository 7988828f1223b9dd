// Borders over the map, computed for what is seen when they are asked for.

import { gone, post } from "./ask.js";
import { $ } from "./dom.js";
import { mechanismName } from "./map.js";
import { toValue } from "./plane.js";
import { limits, remember, state } from "./state.js";

const TOLERANCE = 1e-4; // of what is seen: a tenth of a pixel
const POINTS = [200, 150]; // cells

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
    this.busy = false;
    $("curves").addEventListener("click", () => (state.over.length > 0 || this.busy ? this.reset() : this.ask()));
  }

  reset() {
    this.controller?.abort();
    state.over = [];
    this.map.lines = [];
    $("lines").textContent = "";
    this.show();
  }

  show() {
    $("curves").setAttribute("aria-pressed", String(state.over.length > 0 || this.busy));
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

  async ask() {
    this.controller?.abort();
    const controller = new AbortController();
    this.controller = controller;
    this.busy = true;
    $("lines").textContent = "computing for what is seen; press again to stop";
    this.show();
    try {
      const scene = sceneOfView(this.map, POINTS);
      const answer = await post("curves", { scene, tolerance: TOLERANCE, places: 0 }, controller.signal);
      this.map.lines = borders(answer.answer, this.colours);
      state.over = ["curves"];
      $("lines").textContent = `${this.map.lines.length} borders. ${answer.command}`;
    } catch (error) {
      if (this.controller === controller) $("lines").textContent = gone(error) ? "" : error.message;
    } finally {
      if (this.controller === controller) this.busy = false;
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
