// The map of a structure: tiles on demand, and the orbits at a point.

import { get, gone, post } from "./ask.js";
import { $, element } from "./dom.js";
import { short, ticks, tickTexts } from "./plane.js";

const MARGIN = { left: 64, bottom: 34 };
const DEEPEST = 40;
const AT_ONCE = 4;
const HUES = [212, 28, 140, 320, 50, 265, 180, 0];

const start = await get("start");
const { axes, words, side } = start;
const canvas = $("cells");
const paint = canvas.getContext("2d");
const view = { u: 0.5, v: 0.5, zoom: 0 };
const kept = new Map();
const pending = new Map();
const seen = new Set();
let queue = [];

// "stable 0+": how strong, and the hue of the word.
function colour(name) {
  if (name === "none") return "#ffffff";
  if (name === "unknown") return "#9a9a9a";
  const [how, word] = name.split(" ");
  const light = { stable: 36, undecided: 56, unstable: 78, physical: 48 }[how] ?? 60;
  return `hsl(${HUES[Math.max(0, words.indexOf(word)) % HUES.length]} 70% ${light}%)`;
}

const frame = () => {
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  return { left: MARGIN.left, top: 8, width: width - MARGIN.left - 8, height: height - MARGIN.bottom - 8 };
};
const span = () => 2 ** -view.zoom;
const toPixel = (u, v) => {
  const box = frame();
  return [box.left + ((u - view.u) / span() + 0.5) * box.width, box.top + (0.5 - (v - view.v) / span()) * box.height];
};
const toPlane = (px, py) => {
  const box = frame();
  return [view.u + ((px - box.left) / box.width - 0.5) * span(), view.v + (0.5 - (py - box.top) / box.height) * span()];
};
const level = () => Math.max(0, Math.min(DEEPEST, Math.floor(view.zoom + Math.log2(frame().width / side / 3))));

function visible(z) {
  const [n, half, list] = [2 ** z, 0.5 * span(), []];
  const range = (c) => [Math.max(-n, Math.floor((c - half) * n)), Math.min(2 * n - 1, Math.floor((c + half) * n))];
  const [[x0, x1], [y0, y1]] = [range(view.u), range(view.v)];
  for (let y = y0; y <= y1; y += 1) for (let x = x0; x <= x1; x += 1) list.push([z, x, y]);
  const far = ([, x, y]) => Math.hypot((x + 0.5) / n - view.u, (y + 0.5) / n - view.v);
  return list.sort((a, b) => far(a) - far(b));
}

function want() {
  const z = level();
  const list = [0, Math.max(0, z - 2), z].filter((one, i, all) => all.indexOf(one) === i).flatMap(visible);
  const keys = new Set(list.map(String));
  for (const [key, controller] of pending) if (!keys.has(key)) controller.abort();
  queue = list.filter((one) => !kept.has(String(one)) && !pending.has(String(one)));
  next();
}

function next() {
  while (pending.size < AT_ONCE && queue.length > 0) ask(queue.shift());
}

async function ask([z, x, y]) {
  const key = String([z, x, y]);
  const controller = new AbortController();
  pending.set(key, controller);
  try {
    const { classes, cells } = await post("cells", { z, x, y }, controller.signal);
    const picture = new OffscreenCanvas(side, side);
    const brush = picture.getContext("2d");
    cells.forEach((cell, i) => {
      brush.fillStyle = colour(classes[cell]);
      brush.fillRect(i % side, side - 1 - Math.floor(i / side), 1, 1);
    });
    kept.set(key, { z, x, y, picture, classes, cells });
    classes.forEach((name) => seen.add(name));
  } catch (error) {
    if (!gone(error)) $("wrong").textContent = error.message;
  } finally {
    pending.delete(key);
    next();
    draw();
  }
}

function draw() {
  const [ratio, box] = [window.devicePixelRatio || 1, frame()];
  [canvas.width, canvas.height] = [canvas.clientWidth * ratio, canvas.clientHeight * ratio];
  paint.setTransform(ratio, 0, 0, ratio, 0, 0);
  paint.imageSmoothingEnabled = false;
  const ink = getComputedStyle(document.body).color;
  paint.save();
  paint.beginPath();
  paint.rect(box.left, box.top, box.width, box.height);
  paint.clip();
  for (const tile of [...kept.values()].filter(({ z }) => z <= level()).sort((a, b) => a.z - b.z)) {
    const n = 2 ** tile.z;
    const [left, bottom] = toPixel(tile.x / n, tile.y / n);
    const [right, top] = toPixel((tile.x + 1) / n, (tile.y + 1) / n);
    paint.drawImage(tile.picture, left, top, right - left, bottom - top);
  }
  paint.restore();
  Object.assign(paint, { strokeStyle: ink, fillStyle: ink, font: "13px system-ui, sans-serif" });
  paint.strokeRect(box.left, box.top, box.width, box.height);
  axes.forEach((axis, i) => {
    const centre = i === 0 ? view.u : view.v;
    const value = (part) => axis.from + part * (axis.to - axis.from);
    const scale = ticks(value(centre - 0.5 * span()), value(centre + 0.5 * span()), 5);
    const { base, texts } = tickTexts(scale);
    scale.list.forEach((at, k) => {
      const part = (at - axis.from) / (axis.to - axis.from);
      const [px, py] = i === 0 ? [toPixel(part, 0)[0], box.top + box.height] : [box.left, toPixel(0, part)[1]];
      paint.textAlign = i === 0 ? "center" : "right";
      paint.fillText(texts[k], i === 0 ? px : px - 6, i === 0 ? py + 15 : py + 4);
    });
    paint.textAlign = "left";
    if (i === 0) paint.fillText(`${axis.name} ${base}`, box.left, box.top + box.height + 30);
    else paint.fillText(`${axis.name} ${base}`, box.left + 6, box.top + 16);
  });
  const item = (name) => {
    const mark = element("span", { class: "swatch" });
    mark.style.cssText = `display:inline-block;width:1.6em;height:1em;margin-right:.4em;border:1px solid;background:${colour(name)}`;
    return element("li", {}, mark, name);
  };
  $("legend").replaceChildren(...[...seen].sort().map(item));
}

// The cell at a place: its class, and the values in its middle.
function cellAt([u, v]) {
  for (let z = level(); z >= 0; z -= 1) {
    const n = 2 ** z;
    const [x, y] = [u, v].map((part) => Math.floor(part * n));
    const tile = kept.get(String([z, x, y]));
    if (!tile) continue;
    const [i, j] = [u * n - x, v * n - y].map((part) => Math.min(side - 1, Math.floor(part * side)));
    const at = [[x, i], [y, j]].map(([number, cell], k) => {
      const { from, to } = axes[k];
      return from + (number * side + cell + 0.5) * ((to - from) / (side * n));
    });
    return { name: tile.classes[tile.cells[j * side + i]], at };
  }
  return null;
}

function told(place) {
  const cell = cellAt(place);
  $("cell").textContent = cell ? `${axes.map((axis, i) => `${axis.name} = ${short(cell.at[i])}`).join(", ")}: ${cell.name}` : "computing";
}

let asking = null;
async function open(place) {
  const cell = cellAt(place);
  if (!cell) return;
  asking?.abort();
  asking = new AbortController();
  $("point").hidden = false;
  $("pointname").textContent = axes.map((axis, i) => `${axis.name} = ${cell.at[i]}`).join(", ");
  $("orbits").textContent = "computing";
  $("pointname").focus({ preventScroll: true });
  draw();
  try {
    const answers = await post("orbits", { at: cell.at }, asking.signal);
    $("orbits").replaceChildren(...answers.flatMap(listed));
  } catch (error) {
    if (!gone(error)) $("orbits").textContent = error.message;
  }
}

function listed({ answer, files, command }) {
  const rows = (answer.solutions ?? []).map((one, i) => {
    const how = one.stability ? (one.stability.stable ? "stable" : one.stability.undecided ? "undecided" : "unstable") : "–";
    const impulses = one.impacts.map((impact) => short(impact.impulse)).join(", ");
    const cells = [i + 1, impulses, one.physical ? "physical" : "not physical", how, short(one.stability?.spectral_radius)];
    return element("tr", {}, ...cells.map((text) => element("td", {}, String(text))));
  });
  const head = ["", "impulses", "", "", "largest |μ|"].map((text) => element("th", {}, text));
  const parts = [element("h3", {}, answer.word ?? ""), element("table", {}, element("tr", {}, ...head), ...rows)];
  if (rows.length === 0) parts[1] = element("p", {}, "no orbit");
  if (files["orbit.svg"]) {
    const address = URL.createObjectURL(new Blob([files["orbit.svg"]], { type: "image/svg+xml" }));
    parts.push(element("img", { src: address, alt: `Orbits of ${answer.word}`, width: "100%" }));
  }
  return [...parts, element("pre", {}, command)];
}

function move(change) {
  Object.assign(view, change);
  view.zoom = Math.max(-1, Math.min(DEEPEST, view.zoom));
  [view.u, view.v] = [view.u, view.v].map((part) => Math.max(-1, Math.min(2, part)));
  want();
  draw();
  told([view.u, view.v]);
}

const zoomBy = (by, [u, v] = [view.u, view.v]) => {
  const shrink = 2 ** -by;
  move({ u: u + (view.u - u) * shrink, v: v + (view.v - v) * shrink, zoom: view.zoom + by });
};
const place = (event) => {
  const { left, top } = canvas.getBoundingClientRect();
  return toPlane(event.clientX - left, event.clientY - top);
};

const map = $("map");
let drag = null;
map.addEventListener("wheel", (event) => { event.preventDefault(); zoomBy(-event.deltaY / 400, place(event)); }, { passive: false });
map.addEventListener("pointerdown", (event) => { drag = { from: place(event), moved: false, x: event.clientX, y: event.clientY }; map.setPointerCapture(event.pointerId); });
map.addEventListener("pointermove", (event) => {
  if (!drag) { told(place(event)); return; }
  if (!drag.moved && Math.hypot(event.clientX - drag.x, event.clientY - drag.y) < 4) return;
  drag.moved = true;
  const [u, v] = place(event);
  move({ u: view.u + drag.from[0] - u, v: view.v + drag.from[1] - v });
});
map.addEventListener("pointerup", (event) => { if (drag && !drag.moved) open(place(event)); drag = null; });
map.addEventListener("keydown", (event) => {
  const by = 0.1 * span();
  const keys = {
    ArrowLeft: () => move({ u: view.u - by }), ArrowRight: () => move({ u: view.u + by }),
    ArrowDown: () => move({ v: view.v - by }), ArrowUp: () => move({ v: view.v + by }),
    "+": () => zoomBy(1), "-": () => zoomBy(-1), 0: () => move({ u: 0.5, v: 0.5, zoom: 0 }), Enter: () => open([view.u, view.v]),
  };
  if (keys[event.key]) { event.preventDefault(); keys[event.key](); }
});
$("closer").addEventListener("click", () => zoomBy(1));
$("farther").addEventListener("click", () => zoomBy(-1));
$("whole").addEventListener("click", () => move({ u: 0.5, v: 0.5, zoom: 0 }));
$("leave").addEventListener("click", () => { $("point").hidden = true; draw(); map.focus(); });
new ResizeObserver(() => { Object.assign(canvas.style, { width: "100%", height: "100%" }); move({}); }).observe(map);
$("heading").textContent = [start.heading, start.fixed].filter(Boolean).join(", ");
window.explorer = { view, kept, axes }; // for tests, and the curious
