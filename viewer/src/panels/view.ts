// How the light is shown: which of its numbers, in which colours, how bright.

import type { App } from "../app";
import { h } from "../dom";
import { NAMES } from "../legend";
import { QUANTITIES, type LitScene } from "../light";
import type { Settings } from "../settings";
import { COLOUR_MAPS, CURVES } from "../tone";
import { field, numberField, segmented, select, slider, toggle } from "../ui";
import { CONVERSION, conversion, hasUnit, type Unit } from "../units";

/** Stops that the slider reaches. */
const STOPS = { min: -12, max: 12, step: 0.1 };

const LARGEST = 1e12;

const CURVE_NAMES = { filmic: "Filmic", linear: "Linear", reinhard: "Reinhard" };

export class View {
  readonly element = h("div", { className: "view" });
  private readonly band = h("div", {});
  private showBand: (band: string) => void = () => {};
  private readonly smooth = segmented({ label: "Values" }, [["smooth", "Smooth"], ["patches", "Patches"]], (value) =>
    this.app.set({ smooth: value === "smooth" }),
  );
  private readonly unit = segmented({ label: "Unit", title: CONVERSION }, [["W/m2", "W/m²"], ["lux", "lux"]], (unit) => this.convert(unit));
  private readonly colours = segmented({ label: "Colours" }, [["seen", "As seen"], ["false", "False colours"]], (value) =>
    this.app.set({ falseColours: value === "false" }),
  );
  private readonly quantity = select({ label: "Quantity" }, QUANTITIES.map((quantity) => [quantity, NAMES[quantity]]), (quantity) =>
    this.app.set({ quantity, range: null }),
  );
  private readonly automatic = toggle({ label: "Automatic", title: "The mean of the view becomes middle grey" }, (isOn) => this.meter(isOn));
  private readonly stops = slider({ label: "Exposure in stops", ...STOPS }, (exposure) => this.app.set({ exposure }));
  private readonly stopsNumber = numberField({ label: "Exposure in stops, number", min: -60, max: 60, step: 0.1 }, (exposure) =>
    this.app.set({ exposure }),
  );
  private readonly curve = select({ label: "Tone curve" }, CURVES.map((curve) => [curve, CURVE_NAMES[curve]]), (curve) => this.app.set({ curve }));
  private readonly map = select({ label: "Colour map" }, COLOUR_MAPS.map((map) => [map, capital(map)]), (map) => this.app.set({ map }));
  private readonly isRangeAutomatic = toggle({ label: "Automatic", title: "From zero to what half a per cent of the area exceeds" }, (isOn) =>
    this.app.set({ range: isOn ? null : this.app.stage.range }),
  );
  private readonly low = numberField({ label: "First value of the colour scale", min: 0, max: LARGEST }, () => this.span());
  private readonly high = numberField({ label: "Last value of the colour scale", min: 0, max: LARGEST }, () => this.span());
  private readonly logarithmic = toggle({ label: "Logarithmic" }, (isLogarithmic) => this.app.set({ isLogarithmic, range: null }));
  private readonly isolines = toggle({ label: "Isolines" }, (isolines) => this.app.set({ isolines }));
  private readonly mesh = toggle({ label: "Edges of patches" }, (mesh) => this.app.set({ mesh }));
  private readonly seen: HTMLElement;
  private readonly scale: HTMLElement;
  private readonly unitRow: HTMLElement;
  private readonly valuesRow: HTMLElement;

  constructor(private readonly app: App) {
    this.unitRow = field("Unit", this.unit.element);
    this.valuesRow = field("Values", this.smooth.element);
    this.seen = h(
      "div", {},
      field("Exposure", this.automatic.element, this.stopsNumber),
      field("", this.stops),
      field("Tone curve", this.curve),
    );
    this.scale = h(
      "div", {},
      field("Colour map", this.map),
      field("Range", this.isRangeAutomatic.element),
      field("", h("div", { className: "pair" }, this.low, h("span", {}, "to"), this.high)),
      field("", this.logarithmic.element),
    );
    this.element.append(
      field("Show", this.quantity), this.band, this.valuesRow, this.unitRow, field("Colours", this.colours.element),
      this.seen, this.scale, field("Lines", this.isolines.element), field("", this.mesh.element),
    );
    app.events.on("scene", (lit) => this.build(lit));
    app.events.on("settings", () => this.show());
    app.events.on("light", () => this.show());
    app.stage.afterFrame.push(() => this.showStops());
    this.show();
  }

  private build({ head }: LitScene): void {
    const options: [string, string][] = [["all", "All"], ...head.bands.map((name, k): [string, string] => [String(k), name])];
    const changed = (value: string) => this.app.set({ band: value === "all" ? "all" : Number(value), range: null });
    const isShort = options.length <= 4;
    const bands = isShort ? segmented({ label: "Band" }, options, changed) : null;
    const list = isShort ? null : select({ label: "Band" }, options, changed);
    this.showBand = (band) => (bands ? bands.set(band) : (list!.value = band));
    this.band.replaceChildren(field("Band", bands?.element ?? list!));
    this.band.hidden = head.bands.length < 2;
    this.show();
  }

  private show(): void {
    const { settings, quantity, range } = this.app.stage;
    const { falseColours, isExposureAutomatic } = settings;
    this.quantity.value = settings.quantity;
    this.showBand(String(settings.band));
    this.smooth.set(settings.smooth ? "smooth" : "patches");
    this.unit.set(settings.unit);
    this.colours.set(falseColours ? "false" : "seen");
    this.automatic.input.checked = isExposureAutomatic;
    this.curve.value = settings.curve;
    this.map.value = settings.map;
    this.isRangeAutomatic.input.checked = !settings.range;
    this.logarithmic.input.checked = settings.isLogarithmic;
    this.isolines.input.checked = settings.isolines;
    this.mesh.input.checked = settings.mesh;
    this.low.disabled = this.high.disabled = !settings.range;
    this.stops.disabled = this.stopsNumber.disabled = isExposureAutomatic;
    if (falseColours) [this.low.value, this.high.value] = range.map((x) => String(Number(x.toPrecision(4))));
    this.showStops();
    this.arrange(settings, quantity !== "patches");
  }

  /** What automatic exposure came to, or what was chosen. */
  private showStops(): void {
    const { settings, exposure } = this.app.stage;
    if (document.activeElement === this.stopsNumber) return;
    const stops = settings.isExposureAutomatic ? Math.log2(exposure * this.radiance) : settings.exposure;
    const text = (Math.round(10 * stops) / 10 + 0).toFixed(1); // never -0.0
    if (text !== this.stopsNumber.value) this.stops.value = this.stopsNumber.value = text;
  }

  /** What means something for what is shown. */
  private arrange({ falseColours, quantity }: Settings, isNumber: boolean): void {
    this.seen.hidden = falseColours || quantity === "reflectance" || !isNumber;
    this.scale.hidden = !falseColours || !isNumber;
    this.unitRow.hidden = !hasUnit(quantity);
    this.valuesRow.hidden = quantity !== "radiosity" && quantity !== "irradiance";
    this.isolines.input.disabled = !isNumber;
  }

  /** Stops count on radiance where radiosity is shown. */
  private get radiance(): number {
    return this.app.stage.quantity === "radiosity" ? Math.PI : 1;
  }

  /** By hand it goes on from what it was. */
  private meter(isExposureAutomatic: boolean): void {
    const stops = Math.log2(this.app.stage.exposure * this.radiance);
    this.app.set(isExposureAutomatic ? { isExposureAutomatic } : { isExposureAutomatic, exposure: Number(stops.toFixed(2)) });
  }

  private span(): void {
    const low = this.low.valueAsNumber || 0;
    const high = this.high.valueAsNumber || 0;
    if (high > low) this.app.set({ range: [low, high] });
    else this.show();
  }

  private convert(unit: Unit): void {
    const { settings } = this.app.stage;
    const factor = conversion(settings.unit, unit);
    this.app.set({ unit, range: settings.range && [factor * settings.range[0], factor * settings.range[1]] });
  }
}

function capital(name: string): string {
  return name[0].toUpperCase() + name.slice(1);
}
