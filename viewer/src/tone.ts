// From linear values to colours on the screen, as crates/picture/src/tone.rs has it.

import { rgb } from "d3-color";
import * as chromatic from "d3-scale-chromatic";

export type Curve = "filmic" | "linear" | "reinhard";
export const CURVES: Curve[] = ["filmic", "linear", "reinhard"];

/** The middle grey that automatic exposure makes of the mean: Reinhard et al. 2002. */
export const KEY = 0.18;

/** The least luminance that Reinhard's curve makes white. */
export const WHITE = 4;

const MAPS = {
  viridis: chromatic.interpolateViridis,
  inferno: chromatic.interpolateInferno,
  magma: chromatic.interpolateMagma,
  cividis: chromatic.interpolateCividis,
  turbo: chromatic.interpolateTurbo,
  grey: (t: number) => `rgb(${Array(3).fill(Math.round(255 * t)).join()})`,
};

export type ColourMap = keyof typeof MAPS;
export const COLOUR_MAPS = Object.keys(MAPS) as ColourMap[];

/** 256 colours, four bytes each. */
export function table(map: ColourMap): Uint8Array {
  return Uint8Array.from(
    Array.from({ length: 256 }, (_, i) => {
      const { r, g, b } = rgb(MAPS[map](i / 255));
      return [r, g, b, 255];
    }).flat(),
  );
}

/** ITU-R BT.709. */
export function luminance([r, g, b]: ArrayLike<number>& Iterable<number>): number {
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

/** Exposed linear values to 0 ... 1. */
export function curved(curve: Curve, colour: number[]): number[] {
  const l = luminance(colour);
  return colour.map((c) => {
    const x = Math.min(Math.max(c, 0), 1e6);
    // Narkowicz 2015; Reinhard et al. 2002, equation 4.
    if (curve === "filmic") return clamp((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14));
    if (curve === "reinhard") return clamp((x * (1 + l / WHITE ** 2)) / (1 + l));
    return clamp(x);
  });
}

/** IEC 61966-2-1. */
export function srgb(x: number): number {
  return x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055;
}

/** What the screen shows, 0 ... 255, for a linear colour. */
export function developed(curve: Curve, stops: number, colour: number[]): number[] {
  return curved(curve, colour.map((c) => c * 2 ** stops)).map((c) => Math.round(255 * srgb(c)));
}

function clamp(x: number): number {
  return Math.min(Math.max(x, 0), 1);
}
