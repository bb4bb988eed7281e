// W/m2 and lux of the same light, and the one number that stands for all bands.

import type { Quantity } from "./light";

export type Unit = "W/m2" | "lux";

/** Lumens of a watt of white: what Radiance takes (Ward Larson and Shakespeare 1998, "Rendering with Radiance"). */
export const EFFICACY = 179;

/** Shares of red, green and blue in brightness: the same. */
const LUMINOUS = [0.265, 0.67, 0.065];

/** How a unit follows from the other, for people. */
export const CONVERSION =
  "Lux of red, green and blue in W/m²: 179 lm/W × (0.265 R + 0.670 G + 0.065 B), as Radiance has it; " +
  "of one band, or of others than these three, 179 lm/W × their mean.";

/** What values of each band are multiplied by from one unit to another. */
export function conversion(from: string, to: string): number {
  if (from === to) return 1;
  return to === "lux" ? EFFICACY : 1 / EFFICACY;
}

/** Weights of bands in the one number: brightness for lux of red, green and blue, else the mean. */
export function bandWeights(unit: string, bands: number): number[] {
  return unit === "lux" && bands === 3 ? LUMINOUS : Array<number>(bands).fill(1 / bands);
}

/** The one number of a spectrum. */
export function scalar(unit: string, spectrum: number[]): number {
  const weights = bandWeights(unit, spectrum.length);
  return spectrum.reduce((sum, value, band) => sum + weights[band] * value, 0);
}

/** Whether a quantity has a unit; reflectances and colours of patches are just numbers. */
export function hasUnit(quantity: Quantity): boolean {
  return quantity !== "reflectance" && quantity !== "patches";
}

/** The unit of a quantity in print: light that leaves is not in lux, which is for light that arrives. */
export function unitOf(quantity: Quantity, unit: string): string {
  if (!hasUnit(quantity)) return "";
  if (unit !== "lux") return "W/m²";
  return quantity === "radiosity" || quantity === "emission" ? "lm/m²" : "lux";
}
