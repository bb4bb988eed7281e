// The light at a place that was clicked, and where it comes from: the row of F made visible.

import type { App } from "../app";
import { Beams, type Beam } from "../beams";
import { hex, hue } from "../colour";
import { h } from "../dom";
import { factor as formFactor, figures, metres, percent, printed, whole } from "../figures";
import { Highlight } from "../highlight";
import { Labels, type Label } from "../labels";
import type { LitScene } from "../light";
import type { Overlay } from "../overlay";
import { disagreement, reading, type NamedSource, type Place, type Reading } from "../reading";
import { arrivals, origins, RAYS, row, total, type Closest, type Origin, type Row } from "../row";
import { button, select } from "../ui";
import { conversion, scalar, type Unit } from "../units";
import "./probe.css";

/** Lines that are drawn. */
const BEAMS = 12;

/** Surfaces in the list before the rest is one line. */
const LISTED = 12;

/** Labels beside lines, where none is pointed at. */
const LABELS = 3;

export class Probe {
  readonly element = h("div", { className: "probe" });
  /** Called when there is something to show, and when there no longer is. */
  onToggle: (isOpen: boolean) => void = () => {};
  rays = RAYS;
  private place: Place | null = null;
  private lit: LitScene | null = null;
  private row: Row | null = null;
  private read: Reading | null = null;
  private origins: Origin[] = [];
  private pointed: number | null = null;
  private isDue = false;
  private readonly closer = button({ label: "×", title: "Close the probe (Escape)" }, () => this.close());
  private readonly beams: Beams;
  private readonly labels: Labels;
  private readonly highlight: Highlight;

  constructor(
    private readonly app: App,
    overlay: Overlay,
    private readonly closest: Closest,
  ) {
    this.closer.className = "plain";
    this.beams = new Beams(overlay);
    this.highlight = new Highlight(overlay);
    this.labels = new Labels(app.stage, app.root);
    app.events.on("scene", () => this.close());
    app.events.on("light", () => this.soon());
    app.events.on("settings", () => this.soon());
  }

  /** Reads the light at a place, and asks rays where it is from as soon as that is shown. */
  open(place: Place): void {
    this.lit = this.app.lit!;
    this.place = place;
    this.pointed = null;
    this.row = null;
    this.refresh();
    this.onToggle(true);
    this.soon();
  }

  /** What it reads, with all that is still to be found. */
  get reading(): Reading | null {
    if (this.isDue || !this.row) this.update();
    return this.read;
  }

  close(): void {
    if (!this.place) return;
    this.place = this.row = this.read = null;
    this.origins = [];
    this.pointed = null;
    this.draw();
    this.onToggle(false);
  }

  private get unit(): Unit {
    return this.app.stage.settings.unit;
  }

  get isOpen(): boolean {
    return this.place !== null;
  }

  /** Once after the next picture: while a lamp is dimmed light changes more often than anybody sees. */
  private soon(): void {
    if (this.isDue) return;
    this.isDue = true;
    requestAnimationFrame(() => setTimeout(() => this.update()));
  }

  private update(): void {
    this.isDue = false;
    if (this.row) this.refresh();
    else this.measure();
  }

  /** Sends the rays. */
  private measure(): void {
    const { lit, place } = this;
    if (!lit || !place) return;
    this.row = row(lit, place.patch, place.point, this.closest, this.rays);
    this.refresh();
  }

  /** The same rays in the light as it is now. */
  private refresh(): void {
    const { lit, place, row } = this;
    if (!lit || !place) return;
    const arriving = row && arrivals(lit, row);
    this.read = reading(lit, place, row, arriving);
    this.origins = row && arriving ? origins(lit, row, BEAMS, arriving) : [];
    this.show();
  }

  private show(): void {
    const { read } = this;
    if (!read || !this.lit) return;
    const focused = (document.activeElement as HTMLElement | null)?.dataset.surface;
    this.element.replaceChildren(this.headline(read), this.values(read), ...this.light(read));
    if (focused !== undefined) this.element.querySelector<HTMLElement>(`[data-surface="${focused}"]`)?.focus();
    this.draw();
  }

  private headline({ surface, material, position, patch, area }: Reading): HTMLElement {
    const places = position.map(metres).join(", ");
    return h(
      "header", {},
      h("h3", {}, swatch(hex(this.lit!.reflectanceOf(this.lit!.surface[patch]))), h("span", {}, surface || "without a name"), this.closer),
      h("p", {}, material && material !== surface ? `${material} · ` : "", `patch ${whole(patch)}, ${figures(area)} m²`),
      h("p", { className: "numbers" }, `(${places}) m`),
    );
  }

  private values(read: Reading): HTMLElement {
    const { unit } = this;
    const factor = conversion(this.lit!.head.unit, unit);
    const { mean } = read;
    const row = (title: string, values: number[], kind = "", scale = factor) =>
      h("tr", { className: kind }, h("th", { scope: "row" }, title), ...values.map((x) => h("td", {}, figures(scale * x))));
    const share = Number.isFinite(read.relativeError) ? ` (${percent(read.relativeError)})` : "";
    // What leaves a surface is not called lux.
    const leaving = unit === "lux" ? ", lm/m²" : "";
    const error = this.lit!.isMixed ? "Error ± as solved" : `Error ±${share}`;
    return h(
      "div", { className: "scroll" },
      h(
        "table", {},
        h("thead", {}, h("tr", {}, h("th", { scope: "col" }, printed(unit)), ...bandNames(this.lit!))),
        h(
          "tbody", {},
          row("Irradiance", read.irradiance), row("mean of patch", mean.irradiance, "minor"),
          row(`Radiosity${leaving}`, read.radiosity), row("mean of patch", mean.radiosity, "minor"),
          row(error, mean.error), row(`Emission${leaving}`, mean.emission), row("Reflectance", mean.reflectance, "", 1),
        ),
      ),
    );
  }

  /** Where it comes from. */
  private light(read: Reading): HTMLElement[] {
    if (!this.row) return [h("p", { className: "rest" }, "Asking rays where its light comes from …")];
    const rest = read.sources.slice(LISTED);
    const list = h("ol", { className: "sources" }, ...read.sources.slice(0, LISTED).map((source) => this.source(source)));
    if (rest.length) list.append(h("li", { className: "rest" }, this.rest(rest)));
    return [h("h4", {}, "Where its light comes from"), list, this.balance(read)];
  }

  private source({ surface, name, share, factor, irradiance }: NamedSource): HTMLElement {
    const button = h(
      "button",
      { type: "button", title: `form factor ${formFactor(factor)}` },
      swatch(hue(irradiance)), h("span", { className: "name" }, name), h("span", { className: "share" }, percent(share)),
      h("span", { className: "factor" }, `F ${formFactor(factor)}`),
    );
    button.dataset.surface = String(surface);
    button.style.setProperty("--share", share.toFixed(4));
    button.onmouseenter = button.onfocus = () => this.point(surface);
    button.onmouseleave = button.onblur = () => this.point(null);
    return h("li", {}, button);
  }

  private rest(rest: NamedSource[]): string {
    const [share, factor] = [total(rest.map((s) => s.share)), total(rest.map((s) => s.factor))];
    return `${rest.length} more: ${percent(share)}, F ${factor.toFixed(3)}`;
  }

  private balance(read: Reading): HTMLElement {
    const { unit } = this;
    const factor = conversion(this.lit!.head.unit, unit);
    const value = (spectrum: number[]) => `${figures(factor * scalar(unit, spectrum))} ${printed(unit)}`;
    const off = disagreement(read);
    const differs = Number.isFinite(off) ? ` (${off < 0 ? "−" : "+"}${percent(Math.abs(off))})` : "";
    const dark = [["Outside", read.outside], ["Black backs of surfaces", read.backs]] as const;
    const lost = dark.filter(([, share]) => share > 0).map(([what, share]) => `${what}: F ${formFactor(share)}.`);
    const lights = this.lit!.head.lamps.some((lamp) => lamp.lights.length);
    return h(
      "footer", {},
      h("p", {}, `All of it: ${value(read.gathered)}; the field says ${value(read.irradiance)}${differs}.`),
      lost.length > 0 && h("p", {}, lost.join(" ")),
      lights && h("p", {}, "Lights without area are not among the surfaces."),
      h("label", {}, "Rays ", this.rayChoice()),
    );
  }

  private rayChoice(): HTMLElement {
    const options = [1024, 4096, 16384, 65536].map((n) => [String(n), whole(n)] as const);
    const choice = select({ label: "Rays", title: "More of them are slower and less noisy" }, options, (value) => {
      this.rays = Number(value);
      this.measure();
    });
    choice.value = String(this.rays);
    return choice;
  }

  private point(surface: number | null): void {
    this.pointed = surface;
    this.draw();
  }

  /** Lines, labels and the surface that is pointed at. */
  private draw(): void {
    const { origins, place, pointed, read } = this;
    const lines = pointed === null ? origins : origins.filter(({ surface }) => surface === pointed);
    this.highlight.show(this.lit, pointed);
    if (!place || !read) {
      this.beams.show([]);
      this.labels.show([]);
      return;
    }
    const all = total(read.gathered) || 1;
    const share = ({ irradiance }: Origin) => total(irradiance) / all;
    const beam = (origin: Origin): Beam => ({
      from: origin.point, to: place.point, colour: hue(origin.irradiance), width: 1 + 8 * Math.sqrt(share(origin)),
    });
    this.beams.show(lines.filter((origin) => share(origin) > 0).map(beam).reverse());
    const label = (origin: Origin): Label => ({
      point: origin.point, text: `${this.lit!.head.surfaces[origin.surface].name} ${percent(share(origin))}`,
    });
    // A surface is named once, where most of its light leaves.
    const named = lines.filter(({ surface }, k) => lines.findIndex((line) => line.surface === surface) === k);
    const mark = { point: place.point, text: "", kind: "mark" };
    this.labels.show([mark, ...(pointed === null ? named.slice(0, LABELS) : lines).map(label)]);
  }
}

function bandNames(lit: LitScene): HTMLElement[] {
  return lit.head.bands.map((band) => h("th", { scope: "col" }, band));
}

function swatch(colour: string): HTMLElement {
  const element = h("span", { className: "swatch" });
  element.style.backgroundColor = colour;
  return element;
}
