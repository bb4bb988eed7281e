// Colours of pickers, "#rrggbb" in sRGB, and what they say of bands.

import { srgb } from "./tone";

/** Linear red, green and blue of a colour, 0 to 1. */
export function linear(hex: string): number[] {
  return [1, 3, 5].map((at) => {
    const x = parseInt(hex.slice(at, at + 2), 16) / 255;
    return x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4; // IEC 61966-2-1
  });
}

/** The colour of linear red, green and blue; what is beyond 0 to 1 is cut off. */
export function hex(colour: ArrayLike<number>): string {
  const byte = (x: number) => Math.round(255 * srgb(Math.min(Math.max(x, 0), 1)));
  return `#${[0, 1, 2].map((k) => byte(colour[k]).toString(16).padStart(2, "0")).join("")}`;
}

/** The colour of light, however bright: its largest band is full. White where there are not three bands, or no light. */
export function hue(spectrum: number[]): string {
  const most = Math.max(...spectrum);
  return spectrum.length === 3 && most > 0 ? hex(spectrum.map((x) => x / most)) : "#ffffff";
}
