// What one takes along: scene, command, Python, picture and table of what is seen, and its address.

import { gone, post } from "./ask.js";
import { $ } from "./dom.js";
import { sceneOfView } from "./overlays.js";
import { address, state } from "./state.js";

const CELLS = 400; // along the longer side of pictures and tables

export function takeAlong(map) {
  let url = null;
  const offer = (name, text, file, kind) => {
    if (url) URL.revokeObjectURL(url);
    url = URL.createObjectURL(new Blob([text], { type: kind }));
    $("taken").hidden = false;
    $("textname").textContent = name;
    $("text").value = text.length > 100000 ? `${text.slice(0, 100000)}\n… ${text.length} characters in all` : text;
    Object.assign($("save"), { href: url, download: file });
    $("takenote").textContent = `${name}: ${text.length} characters`;
  };
  const scene = () => {
    const ratio = map.height / map.width;
    const points = ratio < 1 ? [CELLS, Math.max(2, Math.round(CELLS * ratio))] : [Math.max(2, Math.round(CELLS / ratio)), CELLS];
    return sceneOfView(map, points);
  };
  let controller = null;
  const does = {
    scene: async (signal) => offer("Scene", (await post("texts", { scene: scene() }, signal)).scene, "view.toml", "application/toml"),
    command: async (signal) => offer("Command, with the scene as view.toml", (await post("texts", { scene: scene() }, signal)).command, "view.sh", "text/x-sh"),
    python: async (signal) => offer("Python, with the scene as view.toml", (await post("texts", { scene: scene() }, signal)).python, "view.py", "text/x-python"),
    svg: async (signal) => offer("Picture of what is seen", (await picture(signal)).files["map.svg"], "view.svg", "image/svg+xml"),
    csv: async (signal) => offer("Table of what is seen", (await picture(signal)).files["map.csv"], "view.csv", "text/csv"),
    address: async () => offer("Address: with its token it leads here, what follows # leads to this view from any other", `${location.href.split("#")[0]}${address()}`, "address.txt", "text/plain"),
  };
  const picture = (signal) => post("sweep", { scene: scene(), curves: state.over.includes("curves"), ...(state.color === "class" ? {} : { color: state.color }) }, signal);
  for (const button of $("take").querySelectorAll("button")) {
    button.addEventListener("click", async () => {
      controller?.abort();
      controller = new AbortController();
      $("takenote").textContent = "computing";
      try {
        await does[button.dataset.take](controller.signal);
      } catch (error) {
        if (!gone(error)) $("takenote").textContent = error.message;
      }
    });
  }
  $("copy").addEventListener("click", async () => {
    $("text").select();
    try {
      await navigator.clipboard.writeText($("text").value);
      $("takenote").textContent = "copied";
    } catch {
      $("takenote").textContent = "selected: copy it by the keys of your system";
    }
  });
}
