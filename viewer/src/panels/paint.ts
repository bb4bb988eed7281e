// Other paint for a surface: chosen by a click or from the list, answered by the session.

import type { App } from "../app";
import { hex, linear } from "../colour";
import { MOST_REFLECTANCE, type Control } from "../control";
import { h } from "../dom";
import { duration } from "../figures";
import { Highlight } from "../highlight";
import type { Overlay } from "../overlay";
import type { Answer } from "../relight";
import { button, colourField, numberField, slider } from "../ui";
import "./paint.css";

export class Paint {
  readonly element = h("div", { className: "paint" });
  private readonly reason = h("p", { className: "reason" });
  private readonly search = h("input", {
    type: "search", placeholder: "Find a surface", "aria-label": "Find a surface by name or material",
  });
  private readonly list = h("select", { size: 6, "aria-label": "Surface to paint" });
  private readonly fields = h("fieldset", {});
  private readonly took = h("p", { className: "took", role: "status" });
  private readonly highlight: Highlight;
  private surface: number | null = null;

  constructor(
    private readonly app: App,
    private readonly control: Control,
    overlay: Overlay,
  ) {
    this.highlight = new Highlight(overlay);
    this.element.append(this.reason, this.search, this.list, this.fields, this.took);
    this.search.oninput = () => this.fill();
    this.list.onchange = () => this.choose(Number(this.list.value));
    this.list.onblur = () => this.highlight.show(null, null);
    app.events.on("scene", () => this.begin());
    control.events.on("means", () => this.show());
    control.events.on("settings", () => this.show());
    control.relighting.events.on("answered", (answer) => this.answered(answer));
    control.relighting.events.on("waiting", (isWaiting) => this.element.classList.toggle("waiting", isWaiting));
  }

  /** Chooses the surface to paint. */
  choose(surface: number, isMarked = true): void {
    if (surface !== this.surface) this.took.textContent = "";
    this.surface = surface;
    this.list.value = String(surface);
    this.highlight.show(this.app.lit, isMarked ? surface : null);
    this.show();
  }

  /** Surfaces may be others. */
  private begin(): void {
    this.fill();
    if (this.surface !== null && this.surface >= this.app.lit!.head.surfaces.length) this.surface = null;
    this.show();
  }

  private fill(): void {
    const wanted = this.search.value.trim().toLowerCase();
    const surfaces = this.app.lit?.head.surfaces ?? [];
    const found = surfaces.flatMap(({ name, material }, k) =>
      `${name} ${material}`.toLowerCase().includes(wanted) ? [h("option", { value: String(k) }, name)] : [],
    );
    this.list.replaceChildren(...found);
    if (this.surface !== null) this.list.value = String(this.surface);
  }

  private show(): void {
    const reason = this.control.paintFixed;
    this.reason.textContent = reason;
    this.reason.hidden = !reason;
    this.fields.disabled = !!reason;
    // What is being dragged stays.
    if (!this.fields.contains(document.activeElement)) this.build();
  }

  private build(): void {
    const { app, surface, control } = this;
    if (surface === null || !app.lit) return this.fields.replaceChildren(h("p", {}, "Click on a surface, or choose one."));
    const { bands, surfaces } = app.lit.head;
    const now = control.paintOf(surface) ?? app.lit.reflectanceOf(surface);
    const sliders = now.map((value, band) => new Band(bands[band], value, () => this.take(sliders.map((s) => s.value))));
    const picker = colourField({ label: "Colour of the paint" }, (colour) => {
      sliders.forEach((slider, band) => (slider.value = Math.min(linear(colour)[band], MOST_REFLECTANCE)));
      this.take(sliders.map((slider) => slider.value));
    });
    picker.value = hex(now);
    const reset = button({ label: "As in the scene" }, () => {
      reset.blur();
      control.paint(surface, null);
    });
    reset.disabled = !control.paintOf(surface);
    this.fields.replaceChildren(
      h("div", { className: "chosen" }, h("strong", {}, surfaces[surface].name), bands.length === 3 && picker, reset),
      ...sliders.map(({ element }) => element),
    );
  }

  private take(reflectance: number[]): void {
    this.control.paint(this.surface!, reflectance);
  }

  private answered({ took, finding }: Answer): void {
    const found = finding === null ? "No other light" : `Found in ${duration(finding)}`;
    this.took.textContent = `${found}, here after ${duration(took / 1000)}.`;
    this.show();
  }
}

/** Reflectance of one band, by slider or number. */
class Band {
  readonly element: HTMLElement;
  private readonly slider: HTMLInputElement;
  private readonly number: HTMLInputElement;

  constructor(name: string, value: number, changed: () => void) {
    const range = { min: 0, max: MOST_REFLECTANCE, step: 0.01 };
    const take = (value: number) => {
      this.value = value;
      changed();
    };
    this.slider = slider({ label: `Reflectance ${name}`, ...range }, take);
    this.number = numberField({ label: `Reflectance ${name}, number`, ...range, step: "any" }, take);
    this.value = value;
    this.element = h("div", { className: "band" }, h("span", {}, name), this.slider, this.number);
  }

  get value(): number {
    return this.number.valueAsNumber;
  }

  set value(value: number) {
    this.slider.valueAsNumber = value;
    this.number.value = String(Number(value.toFixed(3)));
  }
}
