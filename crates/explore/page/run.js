// A run of the event-driven simulation from the orbit that is looked at.

import { gone, post } from "./ask.js";
import { COLOURS, chart, extent, table } from "./chart.js";
import { $ } from "./dom.js";
import { short } from "./plane.js";
import { remember, state } from "./state.js";

const MOST_NUMBERS = 600000; // of the table of a run, as the program has it
const COLUMNS = 350; // of pictures: one for each pixel
const SHOWN = 25; // periods that can be told apart in a picture

export class Run {
  constructor(point) {
    this.point = point;
    this.mark = () => {};
    $("runform").addEventListener("submit", (event) => {
      event.preventDefault();
      this.start();
    });
    $("halt").addEventListener("click", () => this.controller?.abort());
  }

  clear() {
    this.controller?.abort();
    this.motion = null;
    this.mark = () => {};
    state.run = null;
    $("runbody").hidden = true;
    $("showsrun").hidden = true;
    $("ofrun").checked = false;
    $("runnote").textContent = "";
  }

  // A run that an address asks for.
  resume({ perturb, direction, seed, periods }) {
    $("perturb").value = String(perturb);
    $("direction").value = direction === "unstable" ? "unstable" : "random";
    $("seed").value = String(seed);
    $("periods").value = String(periods);
    return this.start();
  }

  async start() {
    const { solution, asked } = this.point;
    if (!solution?.orbit.physical) return;
    this.clear();
    const run = { perturb: Number($("perturb").value), direction: $("direction").value, seed: Number($("seed").value), periods: Number($("periods").value) };
    const masses = asked.sites * (asked.layers ?? 1);
    const samples = Math.max(1, Math.min(64, Math.floor(MOST_NUMBERS / (2 * masses * Math.max(1, run.periods)))));
    const controller = new AbortController();
    this.controller = controller;
    $("halt").hidden = false;
    $("runnote").textContent = "running";
    try {
      const body = { model: asked, which: solution.family, threshold: null, samples, solution: solution.number + 1, ...run };
      const answer = await post("simulate", body, controller.signal);
      if (this.controller !== controller) return;
      state.run = run;
      this.show(answer, asked, solution.orbit);
      remember();
    } catch (error) {
      if (this.controller === controller) $("runnote").textContent = gone(error) ? "stopped" : error.message;
    } finally {
      if (this.controller === controller) $("halt").hidden = true;
    }
  }

  show({ answer, files, command }, model, orbit) {
    const { rows, names } = table(files["run.csv"]);
    const sites = (names.length - 1) / 2;
    const numbers = rows.map((row) => row.map(Number));
    const start = numbers[0]?.[0] ?? 0;
    const times = numbers.map((row) => row[0] - start);
    const u = Array.from({ length: sites }, (_, n) => Float64Array.from(numbers, (row) => row[1 + n]));
    const hit = (orbit.impacts[0].layer ?? 0) * model.sites + orbit.impacts[0].site;
    const length = times.at(-1) ?? 0;
    const barriers = [model.asymmetry - 1, model.asymmetry + 1];
    const impacts = table(files["impacts.csv"]);
    const column = (name) => impacts.names.indexOf(name);
    const [when, where, wall, kind] = ["time", "site", "barrier", "kind"].map(column);
    const layer = column("layer");
    const events = impacts.rows.filter((row) => row[kind] === "impact").map((row) => ({
      time: Number(row[when]) - start, site: (layer < 0 ? 0 : Number(row[layer]) * model.sites) + Number(row[where]), upper: row[wall] === "upper",
    }));
    const at = (site, time) => {
      const last = times.length - 1;
      const place = length > 0 ? Math.max(0, Math.min(last, (time / length) * last)) : 0;
      const k = Math.min(Math.max(0, last - 1), Math.floor(place));
      return last < 1 ? u[site][0] : u[site][k] + (place - k) * (u[site][k + 1] - u[site][k]);
    };
    $("runbody").hidden = false;
    $("showsrun").hidden = false;
    $("runcommand").textContent = command;
    const end = { "time-reached": "to the end", "impacts-reached": "to the number of impacts", interrupted: "stopped", cascade: "into a cascade of impacts without end", "work-limit": "to the limit on work" };
    const far = answer.distance === null ? "" : `; largest distance from the orbit at the end ${short(answer.distance)}`;
    $("runnote").textContent = `${answer.impacts} impacts, ${answer.sticks} sticks, ${end[answer.outcome] ?? answer.outcome}${far}`;
    const T = (2 * Math.PI) / model.omega;
    const periods = length / T;
    // Of a long run the envelope, not samples of it: the least and the largest of each period, or of several.
    const dense = periods > SHOWN;
    const bounds = dense ? envelope(times, u[hit], Math.min(COLUMNS, Math.floor(periods))).map((line) => line.map(([t, v]) => [t / T, v])) : null;
    this.mark = chart($("runtrace"), {
      label: `Displacement of the mass that is hit over ${short(periods)} periods${dense ? ", its least and largest in each" : ""}`,
      x: { label: "t in periods of the force", range: [0, Math.max(periods, 1e-9)] }, y: { label: "u" }, levels: barriers,
      areas: dense ? [{ lower: bounds[0], upper: bounds[1], colour: COLOURS[1] }] : [],
      lines: dense ? bounds.map((points) => ({ points, colour: COLOURS[1] })) : [{ points: times.map((t, k) => [t / T, u[hit][k]]), colour: COLOURS[1], width: 1.2 }],
    });
    const mark = this.mark;
    this.mark = (time) => ($("ofrun").checked ? mark(time / T, at(hit, time)) : mark(NaN, NaN));
    field($("field"), u, barriers, (model.ends ?? "closed") === "closed" && sites === model.sites ? hit : null);
    // Impacts of a long run: only those about now can flash.
    this.motion = { length, impacts: events.length > 4000 ? [] : events, displacement: at };
    $("ofrun").checked = true;
    this.point.move();
  }
}

// The least and the largest of each of `count` stretches.
function envelope(times, numbers, count) {
  const [low, high] = [[], []];
  const step = (times.length - 1) / count;
  for (let i = 0; i < count; i += 1) {
    const [from, to] = [Math.floor(i * step), Math.floor((i + 1) * step) + 1];
    const [least, most] = extent(numbers.subarray(from, to));
    const t = times[Math.floor((from + to) / 2)];
    low.push([t, least]);
    high.push([t, most]);
  }
  return [low, high];
}

// Amplitudes of all masses, from the dark to the light: a column for a stretch of time, a row a mass; on a ring `hit` is in the middle.
function field(canvas, u, barriers, hit) {
  const sites = u.length;
  const first = hit === null ? 0 : hit - Math.floor((sites - 1) / 2);
  const columns = Math.min(COLUMNS, u[0].length);
  [canvas.width, canvas.height] = [columns, sites];
  const paint = canvas.getContext("2d");
  const image = paint.createImageData(columns, sites);
  const most = Math.max(...barriers.map(Math.abs));
  const step = u[0].length / columns;
  for (let row = 0; row < sites; row += 1) {
    const n = (first + row + sites) % sites;
    for (let i = 0; i < columns; i += 1) {
      const from = Math.floor(i * step);
      let largest = 0;
      for (let k = from; k < Math.max(from + 1, Math.floor((i + 1) * step)); k += 1) largest = Math.max(largest, Math.abs(u[n][k]));
      // Even in lightness from near black to near white, through blue and orange.
      const part = Math.min(1, largest / most);
      const [r, g, b] = [20 + 225 * part ** 0.9, 24 + 190 * part ** 1.3, 60 + 60 * Math.sin(Math.PI * part) + 90 * part ** 3];
      image.data.set([r, g, b, 255], 4 * ((sites - 1 - row) * columns + i));
    }
  }
  paint.putImageData(image, 0, 0);
  canvas.setAttribute("aria-label", `Largest displacement of each of ${sites} masses over time, light where it is large; ${hit === null ? "mass 0 is the lowest row" : "the one that is hit is in the middle"}`);
}
