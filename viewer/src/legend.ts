// The colour scale beside the picture: a bar with round values, the unit, and what lines there are.

import { figures } from "./figures";
import type { Quantity } from "./light";
import { ticks } from "./range";
import type { Stage } from "./stage";
import { table } from "./tone";
import { unitOf } from "./units";
import { h } from "./dom";

/** Pixels of the page. */
const WIDTH = 300;
const BAR = { left: 16, top: 30, height: 12 };
const FONT = "system-ui, sans-serif";

export const NAMES: Record<Quantity, string> = {
  radiosity: "Radiosity", irradiance: "Irradiance", emission: "Emission", error: "Estimated error",
  reflectance: "Reflectance", patches: "Patches",
};

export class Legend {
  readonly element = h("canvas", { className: "legend", role: "img" });
  private drawn = "";

  constructor(private readonly stage: Stage) {
    this.element.hidden = true;
    stage.afterFrame.push(() => this.show());
  }

  /** Draws it into any canvas whose scale is set; nothing if the picture needs none. Returns its height in pixels. */
  drawInto(context: CanvasRenderingContext2D): number {
    const { stage } = this;
    const isBar = this.hasBar;
    if (!isBar && !stage.hasIsolines) return 0;
    const height = isBar ? (stage.hasIsolines ? 82 : 64) : 30;
    context.clearRect(0, 0, WIDTH, height);
    context.font = `11px ${FONT}`;
    panel(context, isBar ? WIDTH : context.measureText(this.lines).width + 2 * BAR.left, height);
    if (isBar) this.drawBar(context);
    if (stage.hasIsolines) text(context, this.lines, 16, height - 10, "#a0a4ad");
    return height;
  }

  private get hasBar(): boolean {
    return this.stage.settings.falseColours && this.stage.isLit && this.stage.quantity !== "patches";
  }

  private get title(): string {
    const { quantity, settings, lit } = this.stage;
    const unit = unitOf(quantity, settings.unit);
    const band = settings.band === "all" ? "" : ` of ${lit?.head.bands[settings.band] ?? ""}`;
    return `${NAMES[quantity]}${band}${unit && `, ${unit}`}`;
  }

  private get lines(): string {
    const { settings, isolineStep, quantity } = this.stage;
    if (settings.isLogarithmic) return `${Math.round(1 / isolineStep)} lines a decade`;
    return `A line every ${short(isolineStep)} ${unitOf(quantity, settings.unit)}`.trim();
  }

  private show(): void {
    const { stage, element } = this;
    const { map, isLogarithmic } = stage.settings;
    const shown = this.hasBar && [this.title, stage.range, map, isLogarithmic];
    const key = JSON.stringify([shown, stage.hasIsolines && this.lines, devicePixelRatio]);
    if (key === this.drawn) return;
    this.drawn = key;
    const context = element.getContext("2d")!;
    element.width = WIDTH * devicePixelRatio;
    element.height = 90 * devicePixelRatio;
    context.scale(devicePixelRatio, devicePixelRatio);
    const height = this.drawInto(context);
    element.hidden = height === 0;
    element.ariaLabel = this.hasBar ? `${this.title}: colours from ${stage.range.map(figures).join(" to ")}` : this.lines;
  }

  private drawBar(context: CanvasRenderingContext2D): void {
    const { settings, range } = this.stage;
    text(context, this.title, BAR.left, 20, "#e8e8ea", 600);
    const width = WIDTH - 2 * BAR.left;
    const colours = table(settings.map);
    for (let x = 0; x < width; x++) {
      const at = 4 * Math.round((255 * x) / (width - 1));
      context.fillStyle = `rgb(${colours[at]} ${colours[at + 1]} ${colours[at + 2]})`;
      context.fillRect(BAR.left + x, BAR.top, 1.5, BAR.height);
    }
    this.drawTicks(context, width, range);
  }

  private drawTicks(context: CanvasRenderingContext2D, width: number, [low, high]: [number, number]): void {
    const { isLogarithmic } = this.stage.settings;
    const measure = isLogarithmic ? Math.log : (x: number) => x;
    let end = -Infinity;
    for (const value of ticks(low, high, isLogarithmic)) {
      const x = BAR.left + (width * (measure(value) - measure(low))) / (measure(high) - measure(low) || 1);
      const label = short(value);
      context.font = `11px ${FONT}`;
      const half = context.measureText(label).width / 2;
      const centre = Math.min(Math.max(x, half + 4), WIDTH - half - 4);
      context.fillStyle = "#e8e8ea";
      context.fillRect(x - 0.5, BAR.top + BAR.height, 1, 4);
      if (centre - half < end + 6) continue;
      text(context, label, centre - half, BAR.top + BAR.height + 15, "#e8e8ea");
      end = centre + half;
    }
  }
}

/** A round value: 0.05, 20, 1,000, 1e-6. */
export function short(value: number): string {
  const size = Math.abs(value);
  if (size === 0) return "0";
  if (size < 1e-3 || size >= 1e6) return value.toExponential().replace("e+", "e").replace("-", "−");
  return value.toLocaleString("en-GB", { maximumSignificantDigits: 6 }).replace("-", "−");
}

function panel(context: CanvasRenderingContext2D, width: number, height: number): void {
  context.fillStyle = "rgb(20 22 26 / 0.84)";
  context.beginPath();
  context.roundRect(0, 0, width, height, 10);
  context.fill();
}

function text(context: CanvasRenderingContext2D, said: string, x: number, y: number, colour: string, weight = 400): void {
  context.font = `${weight} ${weight > 400 ? 12.5 : 11}px ${FONT}`;
  context.fillStyle = colour;
  context.fillText(said, x, y);
}
