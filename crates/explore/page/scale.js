// Numbers as colours: how they become so is asked of the program, for what is seen, once the map rests.

import { gone, post } from "./ask.js";
import { $, element } from "./dom.js";
import { sceneOfView } from "./overlays.js";
import { remember, state } from "./state.js";

const PAUSE = 150; // milliseconds of rest before the scale is asked for
const POINTS = [96, 72]; // cells that it is taken from
const BAR = [260, 14]; // width and height of the key, in pixels

export class Scale {
  constructor(map, colours, changed) {
    Object.assign(this, { map, colours, changed });
    this.is = null; // ends, ticks and words, as the program gives them
    this.select = $("color");
    this.select.addEventListener("change", () => this.choose(this.select.value));
  }

  // Colours by a number of the cells, or by their class.
  choose(color) {
    state.color = color;
    remember();
    this.is = null;
    this.show();
  }

  // Shows what the state says, as far as the scene computes it.
  show() {
    if (state.color === "spectral_radius" && !state.scene.compute.stability) state.color = "class";
    this.select.value = state.color;
    // Room for the key, which comes later, so that the map does not move then.
    $("colours").classList.toggle("numbers", state.color !== "class");
    for (const option of this.select.options) option.disabled = option.value === "spectral_radius" && !state.scene.compute.stability;
    if (state.color === "class") this.is = null;
    this.paint();
    this.moved();
  }

  // The map has moved: what is seen has another scale, once it rests.
  moved() {
    this.controller?.abort();
    clearTimeout(this.timer);
    if (state.color !== "class") this.timer = setTimeout(() => this.ask(), PAUSE);
  }

  async ask() {
    const controller = new AbortController();
    this.controller = controller;
    const color = state.color;
    try {
      const is = await post("scale", { scene: sceneOfView(this.map, POINTS, true), color }, controller.signal);
      if (this.controller !== controller || color !== state.color) return;
      this.is = { ...is, color };
      this.paint();
    } catch (error) {
      if (!gone(error)) $("scaleword").textContent = error.message;
    }
  }

  paint() {
    this.changed();
    this.key();
  }

  // The step of the scale at a number of a tile's cell: -1 below it, null where a cell has none.
  step(tile, i) {
    const { color, logarithm, ends: [from, to] } = this.is;
    const steps = this.colours.scale.length;
    const number = { spectral_radius: () => Math.fround(tile.radius[i] - 1), margin: () => Math.fround(tile.margin[i]), solutions: () => tile.solutions[i] || NaN }[color]();
    if (Number.isNaN(number)) return null;
    const at = logarithm ? Math.log10(number) : number;
    if (logarithm && !(at >= from)) return -1;
    return Math.round(Math.min(1, Math.max(0, (at - from) / (to - from))) * (steps - 1));
  }

  key() {
    $("scale").hidden = this.is === null;
    $("scaleword").textContent = "";
    if (this.is === null) return;
    const { heading, ticks, below } = this.is;
    const canvas = $("scalebar");
    [canvas.width, canvas.height] = BAR;
    const paint = canvas.getContext("2d");
    const { scale } = this.colours;
    const css = (rgb) => `#${rgb.toString(16).padStart(6, "0")}`;
    for (let x = 0; x < BAR[0]; x += 1) {
      paint.fillStyle = css(scale[Math.round((x / (BAR[0] - 1)) * (scale.length - 1))]);
      paint.fillRect(x, 0, 1, BAR[1]);
    }
    $("scalename").textContent = heading;
    $("scaleticks").replaceChildren(...ticks.map(([part, text]) => {
      const tick = element("span", {}, text);
      tick.style.left = `${100 * part}%`;
      return tick;
    }));
    const swatch = element("span", { class: "swatch" });
    swatch.style.background = css(this.colours.below);
    $("scalebelow").replaceChildren(...(below ? [swatch, below] : []));
  }
}
