// The error as it falls: a plot of curves over time with a logarithmic scale, as SVG.

import { clock, percent } from "./figures";

export interface Curve {
  name: string;
  /** A CSS class for its colour. */
  kind: string;
  points: { x: number; y: number }[];
}

export interface Scale {
  low: number;
  high: number;
  /** From 0 at the low end to 1 at the high end; outside is clamped. */
  (value: number): number;
}

/** A linear scale from zero to at least the values. */
export function linearScale(values: number[]): Scale {
  const high = Math.max(...values, 1e-9);
  return Object.assign((value: number) => clamp(value / high), { low: 0, high });
}

/** A logarithmic scale from whole decades around the positive values, at least one. */
export function logarithmicScale(values: number[]): Scale {
  const positive = values.filter((value) => value > 0 && Number.isFinite(value));
  // Rounding must not take 0.001 for less than a thousandth.
  const first = Math.floor(Math.log10(Math.min(...positive, 1)) + 1e-9);
  const last = Math.max(first + 1, Math.ceil(Math.log10(Math.max(...positive, 1e-9)) - 1e-9));
  const place = (value: number) => clamp((Math.log10(Math.max(value, 1e-30)) - first) / (last - first));
  return Object.assign(place, { low: 10 ** first, high: 10 ** last });
}

/** Round values of a linear scale, some four of them. */
export function linearTicks({ high }: Scale): number[] {
  const decade = 10 ** Math.floor(Math.log10(high / 4));
  const step = decade * [1, 2, 5, 10].find((k) => (k * decade * 5) / high >= 1 - 1e-9)!;
  return Array.from({ length: Math.floor(high / step + 1e-9) + 1 }, (_, k) => k * step);
}

/** Round times of a linear scale in seconds, some four of them. */
export function timeTicks(scale: Scale): number[] {
  const step = [15, 30, 60, 120, 300, 600, 1200, 1800, 3600].find((seconds) => scale.high <= 5 * seconds);
  if (scale.high < 60 || !step) return linearTicks(scale);
  return Array.from({ length: Math.floor(scale.high / step) + 1 }, (_, k) => k * step);
}

/** Its decades. */
export function logarithmicTicks({ low, high }: Scale): number[] {
  const first = Math.round(Math.log10(low));
  return Array.from({ length: Math.round(Math.log10(high)) - first + 1 }, (_, k) => Number(`1e${first + k}`));
}

const WIDTH = 320;
const HEIGHT = 150;
const MARGIN = { left: 44, right: 10, top: 10, bottom: 22 };

/** The plot, described by `title` for those who cannot see it; `wanted` is a dashed line, none where it is not positive. */
export function plot(title: string, curves: Curve[], wanted: number): SVGSVGElement {
  const points = curves.flatMap((curve) => curve.points);
  const scaleX = linearScale(points.map(({ x }) => x));
  const scaleY = logarithmicScale([...points.map(({ y }) => y), ...(wanted > 0 ? [wanted] : [])]);
  const x = (value: number) => MARGIN.left + scaleX(value) * (WIDTH - MARGIN.left - MARGIN.right);
  const y = (value: number) => HEIGHT - MARGIN.bottom - scaleY(value) * (HEIGHT - MARGIN.top - MARGIN.bottom);

  const svg = element("svg", { class: "plot", viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": title });
  for (const tick of logarithmicTicks(scaleY)) {
    svg.append(element("path", { class: "grid", d: `M${MARGIN.left} ${y(tick)}H${WIDTH - MARGIN.right}` }));
    svg.append(label(percent(tick), { x: MARGIN.left - 6, y: y(tick) + 3, "text-anchor": "end" }));
  }
  for (const tick of timeTicks(scaleX)) {
    const anchor = !tick ? "start" : scaleX(tick) > 0.95 ? "end" : "middle";
    svg.append(label(clock(tick), { x: x(tick), y: HEIGHT - 6, "text-anchor": anchor }));
  }
  if (wanted > 0) {
    svg.append(element("path", { class: "wanted", d: `M${MARGIN.left} ${y(wanted)}H${WIDTH - MARGIN.right}` }));
    svg.append(label("wanted", { class: "wanted", x: MARGIN.left + 4, y: y(wanted) - 4 }));
  }
  for (const { kind, points } of curves.filter((curve) => curve.points.length)) {
    const path = points.map((p, k) => `${k ? "L" : "M"}${x(p.x).toFixed(1)} ${y(p.y).toFixed(1)}`).join("");
    const last = points[points.length - 1];
    svg.append(element("path", { class: `curve ${kind}`, d: path }));
    svg.append(element("circle", { class: `end ${kind}`, cx: x(last.x), cy: y(last.y), r: 2.5 }));
  }
  return svg;
}

function label(text: string, attributes: Record<string, string | number>): SVGElement {
  const made = element("text", attributes);
  made.textContent = text;
  return made;
}

function element<Tag extends keyof SVGElementTagNameMap>(
  tag: Tag, attributes: Record<string, string | number>,
): SVGElementTagNameMap[Tag] {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, String(value));
  return made;
}

function clamp(x: number): number {
  return Math.min(Math.max(x, 0), 1);
}
