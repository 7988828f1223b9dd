// A point that was clicked on: its orbits, as mapgen orbit tells them, and the one that is looked at, drawn and moving.

import { gone, post } from "./ask.js";
import { Chain } from "./chain.js";
import { COLOURS, chart, table } from "./chart.js";
import { $ } from "./dom.js";
import { mechanismName } from "./map.js";
import { short, shortRadius } from "./plane.js";
import { LETTERS, axes, remember, state } from "./state.js";
import { Run } from "./run.js";

const SAMPLES = 256; // of a period
const MOST_NUMBERS = 140000; // of a table, whatever the number of masses

export class Point {
  constructor(changed) {
    this.changed = changed;
    this.box = $("point");
    this.list = [];
    this.marks = [];
    this.chain = new Chain((time) => this.marks.forEach((mark) => mark(time)));
    this.run = new Run(this);
    $("leave").addEventListener("click", () => this.close(true));
    this.box.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.close(true);
    });
    $("solution").addEventListener("change", () => {
      this.pick(Number($("solution").value));
      this.run.clear();
    });
    $("ofrun").addEventListener("change", () => this.move());
  }

  get isOpen() {
    return !this.box.hidden;
  }

  close(focus) {
    this.controller?.abort();
    this.run.clear();
    this.chain.stop();
    this.box.hidden = true;
    Object.assign(state, { at: null, which: null, number: 0, run: null });
    this.solution = null;
    this.changed();
    if (focus) $("map").focus();
  }

  // The model at the values along the axes.
  model(at) {
    const model = { ...state.scene.model };
    axes().forEach((axis, i) => { model[axis.parameter] = at[i]; });
    return model;
  }

  samples(model) {
    const masses = (model.sites ?? 1) * (model.layers ?? 1);
    return Math.max(16, Math.min(SAMPLES, Math.floor(MOST_NUMBERS / (2 * masses))));
  }

  // Looks at a point. What was chosen before, by `which` and `number`, is chosen again if it is there.
  async open(at, { which = null, number = 0, focus = true } = {}) {
    this.controller?.abort();
    this.run.clear();
    const controller = new AbortController();
    this.controller = controller;
    Object.assign(state, { at, which, number });
    this.box.hidden = false;
    const model = this.model(at);
    this.asked = model;
    const [x, y] = axes();
    $("pointname").textContent = `${LETTERS[x.parameter]} = ${at[0]}, ${LETTERS[y.parameter]} = ${at[1]}`;
    // A point that follows a slider is not announced anew at each of its steps.
    if (focus) $("pointnote").textContent = "computing";
    if (focus) {
      // On a small screen it stands below the map, out of sight.
      const { top, bottom } = $("pointname").getBoundingClientRect();
      if (top < 0 || bottom > 0.6 * window.innerHeight) this.box.scrollIntoView({ block: "start" });
      $("pointname").focus({ preventScroll: true });
    }
    this.changed();
    const { families, threshold } = state.scene.compute;
    const list = [];
    const notes = [];
    for (const family of families) {
      try {
        const body = { model, which: family, threshold: threshold ?? null, samples: this.samples(model) };
        const answer = await post("orbit", body, controller.signal);
        const motions = periods(answer.files["orbit.csv"]);
        answer.answer.solutions.forEach((orbit, i) => list.push({ family, orbit, number: i, motion: motions.get(i + 1), answer }));
        if (answer.answer.reason) notes.push(`${family}: ${answer.answer.reason}`);
      } catch (error) {
        if (gone(error)) return;
        notes.push(`${family}: ${error.message}`);
      }
    }
    if (this.controller !== controller) return;
    this.list = list;
    const physical = list.filter(({ orbit }) => orbit.physical).length;
    const count = `${list.length} ${list.length === 1 ? "solution" : "solutions"}, ${physical} physical`;
    $("pointnote").textContent = [count, ...notes].join(". ");
    $("pointbody").hidden = list.length === 0;
    if (list.length === 0) {
      this.chain.stop();
      return;
    }
    const choice = $("solution");
    choice.replaceChildren(...list.map(({ family, orbit, number: n }, i) => {
      const option = document.createElement("option");
      const stability = orbit.stability ? (orbit.stability.stable ? "stable" : "unstable") : "stability unknown";
      option.value = String(i);
      option.textContent = `${family} ${n + 1}: ${orbit.physical ? stability : "not physical"}`;
      return option;
    }));
    const before = list.findIndex((one) => one.family === which && one.number === number);
    // A stable one gives the cell its class, then any that is physical.
    const rank = ({ orbit }) => (orbit.physical ? (orbit.stability?.stable ? 0 : 1) : 2);
    const best = list.reduce((found, one, i) => (rank(one) < rank(list[found]) ? i : found), 0);
    this.pick(before >= 0 ? before : best);
    if (focus) {
      // Before its body was there the page may have been too short to bring it up.
      const [{ top }, { bottom }] = ["pointname", "chain"].map((id) => $(id).getBoundingClientRect());
      if (top < 0 || bottom > window.innerHeight) this.box.scrollIntoView({ block: "start" });
    }
  }

  pick(i) {
    const one = this.list[i];
    this.solution = one;
    $("solution").value = String(i);
    Object.assign(state, { which: one.family, number: one.number });
    $("start").disabled = !one.orbit.physical;
    $("command").textContent = one.answer.command;
    $("python").textContent = one.answer.python[one.number];
    $("json").textContent = JSON.stringify(one.answer.answer, null, 2);
    this.facts(one.orbit);
    this.move();
    this.charts(one);
    remember();
  }

  // What the chain shows: the orbit, or the run from it.
  move() {
    const run = $("ofrun").checked && this.run.motion;
    const { orbit, motion } = this.solution;
    const { sites, asymmetry } = this.asked;
    const length = sites * (this.asked.layers ?? 1);
    const hit = orbit.impacts[0] ? index(orbit.impacts[0], sites) : 0;
    const shared = { sites: length, hit, barriers: [asymmetry - 1, asymmetry + 1], period: orbit.period, ring: (this.asked.ends ?? "closed") === "closed" };
    this.chain.take(run ? { ...shared, ...run } : {
      ...shared,
      length: orbit.period,
      impacts: orbit.impacts.map((impact) => ({ site: index(impact, sites), time: impact.time, upper: impact.barrier === "upper" })),
      displacement: (site, time) => motion.displacement(site, time),
    });
  }

  facts(orbit) {
    const rows = [
      ["breather", `${orbit.word ?? orbit.family}, period ${short(orbit.period)}`],
      ["physical", orbit.physical ? `yes, margin ${short(orbit.margin)}` : `no: ${orbit.obstruction?.message ?? "an impact has the wrong sign"}`],
    ];
    const { stability } = orbit;
    if (stability) {
      const how = stability.mechanism ? `, lost ${stability.mechanism === "plus-one" ? "through +1" : `by ${mechanismName(stability.mechanism)}`}` : "";
      rows.push(["stability", `${stability.stable ? "stable" : stability.undecided ? "undecided" : "unstable"}${how}`]);
      rows.push(["largest |μ|", shortRadius(stability.spectral_radius)]);
    } else {
      rows.push(["stability", orbit.stability_error ?? "not known"]);
    }
    if (orbit.collision) {
      const { modes: [k, l], harmonic } = orbit.collision;
      rows.push(["collided", `modes ${k} and ${l}, their frequencies sum to ${harmonic === 1 ? "" : harmonic}ω`]);
    }
    if (orbit.phi !== null) rows.push(["φ", short(orbit.phi)]);
    if (orbit.psi !== null) rows.push(["ψ", short(orbit.psi)]);
    for (const impact of orbit.impacts) {
      const layer = impact.layer === undefined ? "" : `:${impact.layer}`;
      rows.push(["impact", `mass ${impact.site}${layer}, ${impact.barrier}, t = ${short(impact.time)}, impulse ${short(impact.impulse)}`]);
    }
    rows.push(["residual", short(orbit.residual)]);
    $("facts").tBodies[0].replaceChildren(...rows.map(([name, text]) => {
      const row = document.createElement("tr");
      const head = document.createElement("th");
      head.scope = "row";
      head.textContent = name;
      row.append(head, Object.assign(document.createElement("td"), { textContent: text }));
      return row;
    }));
  }

  charts({ orbit, motion }) {
    const { sites, asymmetry, ends = "closed", layers = 1 } = this.asked;
    const barriers = [asymmetry - 1, asymmetry + 1];
    const hit = index(orbit.impacts[0], sites);
    const ring = ends === "closed";
    const centre = ring ? hit % sites : 0;
    const places = Array.from({ length: sites }, (_, i) => (ring ? i - Math.floor((sites - 1) / 2) : i));
    const site = (n, layer) => layer * sites + ((((centre + n) % sites) + sites) % sites);
    const instants = [...new Map(orbit.impacts.map((impact) => [impact.time, impact])).values()].slice(0, 4);
    const profiles = instants.map((impact, i) => ({
      points: places.map((n) => [n, motion.displacement(site(n, impact.layer ?? 0), impact.time)]), colour: COLOURS[i],
    }));
    const T = orbit.period;
    chart($("profile"), {
      label: `Displacements at the impacts, between the barriers at ${short(barriers[0])} and ${short(barriers[1])}; the mass that is hit reaches ${instants.map((i) => i.barrier).join(" and ")}`,
      x: { label: ring ? "mass, from the one that is hit" : "mass" }, y: { label: "u" },
      lines: profiles, dots: profiles.map((one) => ({ ...one, size: 2.4 })), levels: barriers,
      key: instants.map((impact, i) => [`t/T = ${(impact.time / T).toFixed(3)}`, COLOURS[i]]),
    });
    const times = motion.times.map((t) => t / T);
    const neighbour = ring ? Math.floor(hit / sites) * sites + ((hit + 1) % sites) : Math.min(hit + 1, sites * layers - 1);
    const trace = (n) => motion.times.map((t, k) => [times[k], motion.u[n][k]]);
    const hits = orbit.impacts.map((impact) => [impact.time / T, impact.barrier === "upper" ? barriers[1] : barriers[0]]);
    const along = chart($("trace"), {
      label: "The mass that is hit and its neighbour over a period, between the barriers",
      x: { label: "t/T", range: [0, 1] }, y: { label: "u" }, levels: barriers,
      lines: [{ points: trace(neighbour), colour: COLOURS[0], dash: "4 3" }, { points: trace(hit), colour: COLOURS[1] }],
      dots: [{ points: hits.filter((_, i) => index(orbit.impacts[i], sites) === hit), colour: COLOURS[1] }],
      key: [["hit", COLOURS[1]], ["neighbour", COLOURS[0]]],
    });
    // From impact to impact; the impacts themselves are jumps.
    const own = orbit.impacts.filter((impact) => index(impact, sites) === hit);
    const flights = own.map((impact, i) => {
      const next = own[(i + 1) % own.length];
      const end = i + 1 < own.length ? next.time : next.time + T;
      const wall = (one) => (one.barrier === "upper" ? barriers[1] : barriers[0]);
      const inside = [];
      const per = motion.times.length - 1;
      for (let k = Math.ceil((impact.time / T) * per + 1e-6); (k / per) * T < end - 1e-9; k += 1) {
        inside.push([motion.u[hit][k % per], motion.v[hit][k % per]]);
      }
      return [[wall(impact), impact.velocity_after], ...inside, [wall(next), next.velocity_before]];
    });
    const jumps = own.map((impact) => {
      const wall = impact.barrier === "upper" ? barriers[1] : barriers[0];
      return [[wall, impact.velocity_before], [wall, impact.velocity_after]];
    });
    const portrait = chart($("phase"), {
      label: "Velocity over displacement of the mass that is hit; impacts are jumps of the velocity",
      x: { label: "u" }, y: { label: "u̇" },
      lines: [...flights.map((points) => ({ points, colour: COLOURS[1] })), ...jumps.map((points) => ({ points, colour: "var(--quiet)", dash: "3 3", width: 1.2 }))],
      dots: jumps.flatMap(([before, after]) => [{ points: [before], colour: COLOURS[1], size: 2.6 }, { points: [after], colour: COLOURS[1], hollow: true, size: 2.6 }]),
    });
    const multipliers = orbit.stability?.multipliers ?? [];
    const radius = orbit.stability?.spectral_radius ?? 1;
    const outside = multipliers.filter(([re, im]) => orbit.stability?.mechanism && Math.hypot(re, im) > 1 + 1e-9);
    const note = orbit.stability?.multipliers_note ?? "";
    $("multipliers").parentElement.querySelector("figcaption").textContent = note ? `Multipliers: ${note}` : "Multipliers and the unit circle";
    chart($("multipliers"), {
      label: `${multipliers.length} multipliers, the largest modulus ${shortRadius(radius)}`,
      x: { label: "Re μ" }, y: { label: "Im μ" }, height: 250, equal: true, circle: true,
      dots: [{ points: multipliers, colour: COLOURS[0], hollow: true, size: 2.6 }, { points: outside, colour: COLOURS[1], size: 3.2 }],
    });
    this.marks = [
      (time) => along(($("ofrun").checked && this.run.motion ? time % T : time) / T, motion.displacement(hit, time)),
      (time) => portrait(motion.displacement(hit, time), motion.velocity(hit, time)),
      (time) => this.run.mark(time),
    ];
  }
}

const index = (impact, sites) => (impact.layer ?? 0) * sites + impact.site;

// The periods in a table of solutions, by their numbers.
export function periods(text) {
  const { names, rows } = table(text);
  const sites = (names.length - 2) / 2;
  const found = new Map();
  for (const row of rows) {
    const solution = Number(row[0]);
    if (!found.has(solution)) found.set(solution, []);
    found.get(solution).push(row.slice(1).map(Number));
  }
  return new Map([...found].map(([solution, list]) => [solution, new Motion(list, sites, true)]));
}

// Samples of all masses, equally spaced in time; between them along straight lines, and round and round if it is a period.
export class Motion {
  constructor(rows, sites, round) {
    this.times = rows.map((row) => row[0]);
    const column = (i) => Float64Array.from(rows, (row) => row[i]);
    this.u = Array.from({ length: sites }, (_, n) => column(1 + n));
    this.v = Array.from({ length: sites }, (_, n) => column(1 + sites + n));
    this.round = round;
    this.first = this.times[0] ?? 0;
    this.length = (this.times.at(-1) ?? 0) - this.first;
  }

  at(numbers, time) {
    const last = this.times.length - 1;
    if (last < 1) return numbers[0] ?? 0;
    let place = ((time - (this.round ? this.first : 0)) / this.length) * last;
    place = this.round ? ((place % last) + last) % last : Math.max(0, Math.min(last, place));
    const k = Math.min(last - 1, Math.floor(place));
    return numbers[k] + (place - k) * (numbers[k + 1] - numbers[k]);
  }

  displacement(site, time) { return this.at(this.u[site], time); }
  velocity(site, time) { return this.at(this.v[site], time); }
}
