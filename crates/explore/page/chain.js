// The chain between its barriers, moving: every mass swings along its gap, and lights up where it is hit.

import { COLOURS } from "./chart.js";
import { $, svg } from "./dom.js";

const MOST = 61; // masses that one can tell apart: of more, those about the one that is hit
const FLASH = 0.04; // of a period

export class Chain {
  constructor(moved) {
    this.moved = moved;
    this.target = $("chain");
    this.button = $("play");
    this.slider = $("time");
    this.speed = $("speed");
    this.time = 0;
    this.calm = window.matchMedia("(prefers-reduced-motion: reduce)");
    this.wanted = !this.calm.matches;
    this.button.addEventListener("click", () => this.play(!this.playing));
    this.slider.addEventListener("input", () => {
      this.play(false);
      this.time = (Number(this.slider.value) / 1000) * this.motion.length;
      this.show();
    });
    document.addEventListener("visibilitychange", () => { this.last = 0; });
  }

  // `motion`: sites, length of time, period, barriers, hit (the mass in the middle), ring, impacts [{ site, time, upper }], and
  // displacement(site, time).
  take(motion) {
    this.motion = motion;
    const { sites, barriers: [low, high], hit, ring } = motion;
    const shown = Math.min(sites, MOST);
    const first = ring ? hit - Math.floor((shown - 1) / 2) : Math.max(0, Math.min(sites - shown, hit - Math.floor(shown / 2)));
    this.shown = Array.from({ length: shown }, (_, i) => ((((first + i) % sites) + sites) % sites));
    const [width, height, edge] = [400, 170, 16];
    const step = (width - 2 * edge) / shown;
    const wide = Math.min(0.8 * step, 26);
    this.y = (u) => 14 + ((high - u) / (high - low)) * (height - 42);
    const parts = [];
    this.masses = this.shown.map((site, i) => {
      const x = edge + (i + 0.5) * step;
      parts.push(svg("path", { d: `M${x - wide / 2},${this.y(low)}h${wide}M${x - wide / 2},${this.y(high)}h${wide}`, stroke: "var(--quiet)", "stroke-width": 2.5 }));
      const flash = [low, high].map((level) => svg("path", { d: `M${x - wide / 2},${this.y(level)}h${wide}`, stroke: COLOURS[1], "stroke-width": 5, visibility: "hidden" }));
      const mass = svg("circle", { cx: x, r: Math.max(1.6, Math.min(6, 0.36 * step)), fill: site === hit ? COLOURS[1] : COLOURS[0] });
      const name = (i - this.shown.indexOf(hit)) % Math.ceil(shown / 14) === 0 ? [svg("text", { x, y: height - 8, "text-anchor": "middle" }, String(site))] : [];
      parts.push(...flash, ...name);
      return { x, site, mass, flash };
    });
    this.thread = svg("path", { fill: "none", stroke: "var(--quiet)", "stroke-width": 1 });
    parts.push(svg("path", { d: `M${edge},${this.y(0)}h${width - 2 * edge}`, stroke: "var(--grid)" }), this.thread, ...this.masses.map(({ mass }) => mass));
    this.target.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.target.replaceChildren(...parts);
    this.time = 0;
    this.show();
    this.play(this.wanted);
  }

  // Nothing is shown any more.
  stop() {
    cancelAnimationFrame(this.frame);
    this.playing = false;
  }

  play(on) {
    this.wanted = on;
    cancelAnimationFrame(this.frame);
    this.playing = on;
    this.button.setAttribute("aria-pressed", String(on));
    this.button.textContent = on ? "Pause" : "Play";
    this.last = 0;
    if (on) this.frame = requestAnimationFrame((now) => this.step(now));
  }

  step(now) {
    // A period takes two seconds at speed 0; each step of the slider doubles it.
    const rate = (this.motion.period / 2) * 2 ** Number(this.speed.value);
    if (this.last) this.time += (Math.min(100, now - this.last) / 1000) * rate;
    this.last = now;
    if (this.time >= this.motion.length) this.time %= this.motion.length;
    this.slider.value = String((1000 * this.time) / this.motion.length);
    this.show();
    this.frame = requestAnimationFrame((then) => this.step(then));
  }

  show() {
    const { motion, time } = this;
    const flash = FLASH * motion.period;
    let d = "";
    for (const { x, site, mass } of this.masses) {
      const y = this.y(motion.displacement(site, time)).toFixed(2);
      mass.setAttribute("cy", y);
      d += `${d ? "L" : "M"}${x.toFixed(1)},${y}`;
    }
    this.thread.setAttribute("d", d);
    const lit = new Set();
    for (const impact of motion.impacts) {
      const since = time - impact.time;
      if (since >= 0 && since < flash) lit.add(`${impact.site}${impact.upper}`);
    }
    for (const { site, flash: [low, high] } of this.masses) {
      low.setAttribute("visibility", lit.has(`${site}false`) ? "visible" : "hidden");
      high.setAttribute("visibility", lit.has(`${site}true`) ? "visible" : "hidden");
    }
    this.moved(time);
  }
}
