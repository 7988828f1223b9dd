// The model by sliders and fields. What is typed is asked of the program first: a scene that it refuses is never shown.

import { post, gone } from "./ask.js";
import { $, element, unbroken } from "./dom.js";
import { LAYERED, NAMES, ORDER, RANGES, axes, remember, state } from "./state.js";

const FAMILIES = {
  "double-sided": "hits both barriers once a period",
  "double-sided-symmetric": "the same; without force only the one whose two flights are equal, φ = T/2: quicker",
  "single-sided": "hits one barrier once a period",
};
const PAUSE = 120; // milliseconds after which what is typed is asked for

// What is typed: a number if it is one; else as it is, so that the program says what is wrong with it.
const typed = (text) => (text.trim() !== "" && Number.isFinite(Number(text)) ? Number(text) : text.trim());

export class Controls {
  constructor(changed) {
    this.changed = changed;
    this.form = $("model");
    this.wrong = $("wrong");
    this.form.addEventListener("submit", (event) => event.preventDefault());
    $("restore").addEventListener("click", () => {
      this.asked = null;
      this.accepted();
      this.build();
    });
  }

  // Fields for what the scene has.
  build() {
    const { model, compute } = state.scene;
    const layered = (model.layers ?? 1) > 1;
    const known = ORDER.filter((name) => name !== "sites" && (layered || !LAYERED.includes(name)) && !(name === "amplitude" && model.force));
    const section = (id, ...rows) => {
      const box = $(id);
      box.replaceChildren(box.querySelector("legend"), ...rows);
    };
    section("axes", ...axes().flatMap((axis, i) => {
      const name = "xy"[i];
      const select = element("select", { id: `${name}-parameter` });
      for (const parameter of known) select.append(element("option", { value: parameter }, NAMES[parameter]));
      select.value = axis.parameter;
      select.addEventListener("change", () => this.turn(name, select.value));
      const field = (end) => {
        const input = element("input", { type: "text", inputmode: "decimal", id: `${name}-${end}`, value: String(axis[end]), "aria-label": `${NAMES[axis.parameter]} ${end}` });
        input.addEventListener("change", () => this.edit((scene) => { scene.sweep[name][end] = typed(input.value); }, input));
        return input;
      };
      return [
        element("div", { class: "row" }, element("label", { for: `${name}-parameter` }, name === "x" ? "across" : "upward"), select),
        element("div", { class: "row" }, element("label", { for: `${name}-from` }, "from, to"), element("span", { class: "pair" }, field("from"), field("to"))),
      ];
    }));
    const swept = axes().map((axis) => axis.parameter);
    section("values", ...ORDER.filter((name) => name in model && !swept.includes(name) && typeof model[name] === "number").map((name) => this.row(name)));
    const rows = Object.entries(FAMILIES).map(([name, meaning]) => {
      const box = element("input", { type: "checkbox", value: name });
      box.checked = compute.families.includes(name);
      box.addEventListener("change", () => this.families(box));
      return element("label", { class: "choice" }, box, ` ${name}`, element("small", {}, meaning));
    });
    const words = element("input", { type: "text", id: "words", value: compute.families.filter((name) => !(name in FAMILIES)).join("; "), placeholder: "0+3+,0-3-", "aria-describedby": "wordhelp" });
    words.addEventListener("change", () => this.families(words));
    const threshold = element("input", { type: "text", inputmode: "decimal", id: "threshold", value: compute.threshold ?? "", placeholder: "strict", "aria-describedby": "excesshelp" });
    threshold.addEventListener("change", () => this.edit((scene) => {
      scene.compute.threshold = threshold.value.trim() === "" ? null : typed(threshold.value);
    }, threshold));
    section("families", ...rows,
      element("div", { class: "row" }, element("label", { for: "words" }, "words"), words),
      element("p", { class: "quiet", id: "wordhelp" }, "Impact words, with ; between them: 0+3+,0-3- hits masses 0 and 3 together, up and down."),
      element("div", { class: "row" }, element("label", { for: "threshold" }, "excess allowed"), threshold),
      element("p", { class: "quiet", id: "excesshelp" }, unbroken("Still stable: |μ| up to 1 + this a period, as 0.01. Empty: none beyond rounding.")));
    $("heading").textContent = unbroken(state.heading ?? "");
  }

  row(name) {
    const [least, most, step] = RANGES[name];
    const now = state.scene.model[name];
    const field = element("input", { type: "text", inputmode: "decimal", id: `value-${name}`, value: String(now) });
    const slider = element("input", { type: "range", min: least, max: most, step, "aria-label": NAMES[name] });
    slider.value = now;
    const set = (text, input) => this.edit((scene) => { scene.model[name] = typed(text); }, input, true);
    field.addEventListener("change", () => { slider.value = field.value; set(field.value, field); });
    slider.addEventListener("input", () => { field.value = slider.value; set(slider.value, field); });
    return element("div", { class: "row" }, element("label", { for: `value-${name}` }, NAMES[name]), field, slider);
  }

  // Another parameter along an axis: the old one stands where the cross is.
  turn(name, parameter) {
    this.edit((scene) => {
      const [own, other] = [scene.sweep[name], scene.sweep[name === "x" ? "y" : "x"]];
      if (other.parameter === parameter) {
        [scene.sweep.x, scene.sweep.y] = [scene.sweep.y, scene.sweep.x];
        return;
      }
      const part = name === "x" ? state.u : state.v;
      scene.model[own.parameter] = own.from + part * (own.to - own.from);
      delete scene.model[parameter];
      const [least, most] = RANGES[parameter];
      scene.sweep[name] = { parameter, from: least, to: most, points: own.points };
      Object.assign(state, { u: 0.5, v: 0.5, zoom: 0, at: null });
    });
  }

  families(source) {
    const boxes = [...document.querySelectorAll("#families input[type=checkbox]")];
    if (source.type === "checkbox" && source.checked && source.value.startsWith("double")) {
      for (const box of boxes) if (box !== source && box.value.startsWith("double")) box.checked = false;
    }
    const words = $("words").value.split(";").map((word) => word.trim()).filter(Boolean);
    this.edit((scene) => {
      scene.compute.families = [...boxes.filter((box) => box.checked).map((box) => box.value), ...words];
    }, source);
  }

  // Changes a copy of the scene, and shows it if the program takes it. Fields are built anew, unless they are under somebody's hand.
  edit(change, source, kept = false) {
    const scene = structuredClone(this.asked ?? state.scene);
    change(scene);
    this.asked = scene;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.try(scene, source, kept), PAUSE);
  }

  async try(scene, source, kept) {
    this.controller?.abort();
    this.controller = new AbortController();
    try {
      await this.take(scene, this.controller.signal);
      if (!kept) {
        const focused = document.activeElement?.id;
        this.build();
        if (focused) $(focused)?.focus();
      }
    } catch (error) {
      if (gone(error)) return;
      // What is asked stays so, and stands in its field, until it is mended or given up.
      this.wrong.textContent = error.message;
      $("restore").hidden = false;
      source?.setAttribute("aria-invalid", "true");
    }
  }

  accepted() {
    this.wrong.textContent = "";
    $("restore").hidden = true;
    for (const input of this.form.querySelectorAll("[aria-invalid]")) input.removeAttribute("aria-invalid");
  }

  async take(scene, signal) {
    const view = await post("view", { scene }, signal);
    if (this.asked === scene) this.asked = null;
    this.accepted();
    state.scene = view.scene;
    state.heading = view.heading;
    state.conservative = view.conservative;
    $("heading").textContent = unbroken(view.heading);
    remember();
    this.changed(view);
  }
}
