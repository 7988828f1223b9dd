// Where the page begins: what the program shows first, or what the address says, and what happens when either changes.

import { get } from "./ask.js";
import { Controls } from "./controls.js";
import { $ } from "./dom.js";
import { MapView, className, mechanismName } from "./map.js";
import { Overlays } from "./overlays.js";
import { Point } from "./point.js";
import { Scale } from "./scale.js";
import { learn, recall, remember, state } from "./state.js";
import { takeAlong } from "./take.js";

const THEMES = ["system", "light", "dark"];

function dress() {
  if (state.theme === "system") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = state.theme;
  $("theme").textContent = `Theme: ${state.theme}`;
}

function legend({ classes, samples, tiles, period }) {
  const numbers = state.color !== "class";
  const sample = (pixels) => {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [28, 16];
    const paint = canvas.getContext("2d");
    const image = paint.createImageData(28, 16);
    for (let y = 0; y < 16; y += 1) {
      for (let x = 0; x < 28; x += 1) {
        const rgb = pixels[(y % period) * period + (x % period)];
        image.data.set([rgb >> 16, (rgb >> 8) & 255, rgb & 255, 255], 4 * (y * 28 + x));
      }
    }
    paint.putImageData(image, 0, 0);
    canvas.setAttribute("aria-hidden", "true");
    return canvas;
  };
  const pixels = (name, mechanism = null) => tiles.find((tile) => tile.class === name && tile.mechanism === mechanism).pixels;
  const entry = (picture, text) => {
    const item = document.createElement("li");
    item.append(sample(picture), text);
    return item;
  };
  const { families, stability } = state.scene.compute;
  const sides = new Set(families.map((name) => (name.startsWith("double") ? "double" : name.startsWith("single") ? "single" : "word")));
  const shown = classes.filter((name) => {
    const parts = name.split("-");
    return name === "none" || (sides.has(parts.at(-1)) && parts.length === (stability ? 2 : 1));
  });
  const items = shown.filter((name) => !numbers || name === "none").map((name) => entry(pixels(name), className(name)));
  if (stability && !numbers) items.push(...samples.map(({ mechanism, pixels: marked }) => entry(marked, `unstable: ${mechanismName(mechanism)}`)));
  items.push(entry(pixels(null), numbers ? "not known" : "class not known"));
  $("legend").replaceChildren(...items);
}

async function begin() {
  const start = await get("start");
  learn(start.parameters);
  if (!recall(location.hash)) state.scene = null;
  state.scene ??= start.scene;
  dress();
  const failed = (error) => { $("wrong").textContent = error.message; };
  const map = new MapView({
    colours: start.colours,
    chosen: (at) => point.open(at),
    left: () => point.close(false),
    failed,
  });
  const point = new Point(() => {
    map.redraw();
    remember();
  });
  const overlays = new Overlays(map);
  const scale = new Scale(map, start.colours, () => {
    map.redraw();
    legend(start.colours);
  });
  map.scale = scale;
  const controls = new Controls((view) => {
    overlays.reset();
    map.reset(view.deepest);
    scale.show();
    // The point stays where it is, with what it has now.
    if (state.at) point.open(state.at, { which: state.which, number: state.number, focus: false });
    else if (point.isOpen) point.close(false);
  });
  takeAlong(map);
  window.explorer = { map, state }; // for tests, and the curious

  // A view that was shared, or the first one; of a scene that is refused the program's own.
  const show = async () => {
    const { at, which, number, run, over } = state;
    state.at = null;
    controls.asked = null;
    try {
      await controls.take(state.scene);
    } catch (error) {
      Object.assign(state, { scene: start.scene, u: 0.5, v: 0.5, zoom: 0 });
      await controls.take(state.scene);
      failed(new Error(`the address holds a scene that is refused: ${error.message}`));
      controls.build();
      return;
    }
    controls.build();
    if (at) {
      await point.open(at, { which, number, focus: false });
      if (run && point.solution) await point.run.resume(run);
    }
    if (over.length > 0) await overlays.ask();
  };
  window.addEventListener("hashchange", () => {
    if (recall(location.hash)) {
      state.scene ??= start.scene;
      dress();
      show();
    }
  });
  $("closer").addEventListener("click", () => map.zoomBy(1));
  $("farther").addEventListener("click", () => map.zoomBy(-1));
  $("whole").addEventListener("click", () => map.whole());
  $("theme").addEventListener("click", () => {
    state.theme = THEMES[(THEMES.indexOf(state.theme) + 1) % THEMES.length];
    dress();
    remember();
  });
  await show();
}

begin().catch((error) => { $("wrong").textContent = error.message; });
