// W/m2 and lux of the same light, and the one number that stands for all bands.

export type Unit = "W/m2" | "lux";

/** Lumens of a watt of white: what Radiance takes (Ward Larson and Shakespeare 1998, "Rendering with Radiance"). */
export const EFFICACY = 179;

/** Shares of red, green and blue in brightness: the same. */
const LUMINOUS = [0.265, 0.67, 0.065];

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
