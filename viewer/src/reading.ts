// What the probe reads at a place: the light there, that of its patch, and where it comes from.

import type { Point } from "./field";
import type { LitScene, Spectra } from "./light";
import { arrivals, sources, total, type Row, type Source } from "./row";

export interface Place {
  patch: number;
  /** Metres, relative to head.origin. */
  point: Point;
  st: [number, number];
}

export interface NamedSource extends Source {
  name: string;
  /** Of the sum of all, bands together; 0 to 1. */
  share: number;
}

/** Numbers in the unit of the scene, by band. */
export interface Reading {
  surface: string;
  material: string;
  patch: number;
  /** Metres, where the file has it. */
  position: Point;
  /** Square metres. */
  area: number;
  /** Of the field, at the place. */
  irradiance: number[];
  radiosity: number[];
  /** Means of the patch. */
  mean: Spectra;
  /** Root mean square over the bands of the estimated error, relative to the mean irradiance of the patch; NaN in the dark. */
  relativeError: number;
  /** By surface, the brightest first; empty before rays were sent. */
  sources: NamedSource[];
  /** What all of them make arrive. */
  gathered: number[];
  /** Shares of the hemisphere: what leaves the scene, and what meets backs. */
  outside: number;
  backs: number;
}

export function reading(
  lit: LitScene, { patch, point, st }: Place, row: Row | null, arriving = row && arrivals(lit, row),
): Reading {
  const surface = lit.head.surfaces[lit.surface[patch]];
  const mean = lit.of(patch);
  const from = row && arriving ? named(lit, sources(lit, row, arriving)) : [];
  return {
    surface: surface.name,
    material: surface.material,
    patch,
    position: point.map((x, axis) => x + lit.head.origin[axis]) as Point,
    area: lit.area[patch],
    irradiance: lit.irradianceAt(patch, ...st),
    radiosity: lit.radiosityAt(patch, ...st),
    mean,
    relativeError: Math.hypot(...mean.error) / Math.sqrt(lit.bands) / (total(mean.irradiance) / lit.bands || NaN),
    sources: from,
    gathered: mean.irradiance.map((_, band) => total(from.map((source) => source.irradiance[band]))),
    outside: row?.outside ?? 0,
    backs: row?.backs ?? 0,
  };
}

function named(lit: LitScene, from: Source[]): NamedSource[] {
  const all = total(from.map((source) => total(source.irradiance)));
  return from.map((source) => ({
    ...source,
    name: lit.head.surfaces[source.surface].name,
    share: all > 0 ? total(source.irradiance) / all : 0,
  }));
}

/** How far the sum of the sources is from the field, relative to it: 0.01 is one per cent more; NaN in the dark. */
export function disagreement({ gathered, irradiance }: Reading): number {
  return total(gathered) / (total(irradiance) || NaN) - 1;
}
