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
    $("text").rows = Math.min(20, Math.max(3, text.split("\n", 20).length + 1));
    $("takenote").textContent = `${text.length} characters`;
  };
  const scene = () => {
    const ratio = map.height / map.width;
    const points = ratio < 1 ? [CELLS, Math.max(2, Math.round(CELLS * ratio))] : [Math.max(2, Math.round(CELLS / ratio)), CELLS];
    return sceneOfView(map, points);
  };
  let controller = null;
  const does = {
    scene: async (signal) => offer("Scene, as view.toml", (await post("texts", { scene: scene() }, signal)).scene, "view.toml", "application/toml"),
    command: async (signal) => offer("Command; save the scene as view.toml first", (await post("texts", { scene: scene() }, signal)).command, "view.sh", "text/x-sh"),
    python: async (signal) => offer("Python; save the scene as view.toml first", (await post("texts", { scene: scene() }, signal)).python, "view.py", "text/x-python"),
    svg: async (signal) => offer("Picture of what is seen", (await picture(signal)).files["map.svg"], "view.svg", "image/svg+xml"),
    csv: async (signal) => offer("Table of what is seen", (await picture(signal)).files["map.csv"], "view.csv", "text/csv"),
    address: async () => offer("Address: with its token it leads here, what follows # leads to this view from any other", `${location.href.split("#")[0]}${address()}`, "address.txt", "text/plain"),
  };
  const picture = (signal) => post("sweep", { scene: scene(), curves: state.over.includes("curves"), ...(state.color === "class" ? {} : { color: state.color }) }, signal);
  const buttons = [...$("take").querySelectorAll("[data-take]")];
  const take = async (name) => {
    controller?.abort();
    controller = new AbortController();
    for (const button of buttons) button.setAttribute("aria-pressed", String(button.dataset.take === name));
    $("taken").hidden = true;
    $("takenote").textContent = "computing";
    try {
      await does[name](controller.signal);
    } catch (error) {
      if (!gone(error)) $("takenote").textContent = error.message;
    }
  };
  for (const button of buttons) button.addEventListener("click", () => take(button.dataset.take));
  $("takealong").addEventListener("click", () => {
    $("take").showModal();
    take("command");
  });
  $("untake").addEventListener("click", () => $("take").close());
  $("take").addEventListener("close", () => controller?.abort());
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
