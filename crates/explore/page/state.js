// What is shown, all of it: kept in the address, so that a view can be shared and comes back when it is loaded again.

export const state = {
  scene: null, // model, sweep, compute, as the program gives them
  u: 0.5, v: 0.5, zoom: 0, // the place under the cross, and how close
  at: null, // the point looked at, by its values along x and y
  which: null, number: 0, // the solution looked at: its family or word, and its number from 0
  run: null, // perturb, direction, seed, periods of the run shown
  over: [], // lines over the map: "curves"
  color: "class", // what colours the map: "class", or a number, as a column of tables is called
  theme: "system",
};

export const COLORS = ["class", "spectral_radius", "margin", "solutions"];

// Keys in the address, which people see.
const KEYS = { scene: "scene", u: "x", v: "y", zoom: "zoom", at: "at", which: "orbit", number: "solution", run: "run", over: "lines", color: "color", theme: "theme" };

let timer = 0;

export function remember() {
  clearTimeout(timer);
  timer = setTimeout(() => history.replaceState(null, "", address()), 150);
}

export function address() {
  const plain = {};
  for (const [key, name] of Object.entries(KEYS)) {
    const v = state[key];
    if (v !== null && v !== "system" && v !== "class" && !(Array.isArray(v) && v.length === 0)) plain[name] = v;
  }
  return `#${encodeURIComponent(JSON.stringify(plain))}`;
}

const number = (v, otherwise) => (typeof v === "number" && Number.isFinite(v) ? v : otherwise);

// Takes what an address says, of whoever has written it: anything that is not as it must be is left out.
export function recall(hash) {
  let plain;
  try {
    plain = JSON.parse(decodeURIComponent(hash.slice(1)));
  } catch {
    return false;
  }
  if (typeof plain !== "object" || plain === null) return false;
  if (typeof plain.scene === "object" && plain.scene !== null) state.scene = plain.scene;
  state.u = Math.min(2, Math.max(-1, number(plain.x, 0.5)));
  state.v = Math.min(2, Math.max(-1, number(plain.y, 0.5)));
  state.zoom = Math.max(-1, number(plain.zoom, 0));
  const pair = Array.isArray(plain.at) && plain.at.length === 2 && plain.at.every((v) => number(v, null) !== null);
  state.at = pair ? plain.at : null;
  state.which = typeof plain.orbit === "string" ? plain.orbit : null;
  state.number = Math.max(0, Math.trunc(number(plain.solution, 0)));
  state.run = typeof plain.run === "object" ? plain.run : null;
  state.over = Array.isArray(plain.lines) ? plain.lines.filter((name) => name === "curves") : [];
  state.color = COLORS.includes(plain.color) ? plain.color : "class";
  state.theme = ["light", "dark"].includes(plain.theme) ? plain.theme : "system";
  return true;
}

export const axes = () => [state.scene.sweep.x, state.scene.sweep.y];
export const limits = () => axes().map((axis) => [axis.from, axis.to]);

// Names of parameters for people, and their sliders, in the order in which a model has them; the program tells them when the page begins.
export const NAMES = { sites: "masses", layers: "layers" };
export const LETTERS = {};
export const RANGES = { sites: [1, 101, 1] }; // ends and step of the sliders; fields take whatever the program takes
export const ORDER = ["sites"];
export const LAYERED = []; // what takes several layers
export function learn(parameters) {
  for (const { name, letter, label, slider, layers } of parameters) {
    [NAMES[name], LETTERS[name], RANGES[name]] = [label, letter, slider];
    ORDER.push(name);
    if (layers) LAYERED.push(name);
  }
}
