// Where a point gets its light from: a row of the form factors, F, seen from a point.
//
// H = sum over what is seen of F B. F depends on geometry alone, so it is measured once and serves every light: rays of
// a cosine distribution, of which each carries the same share. Small bright emitters, which few rays would find, are
// taken out of that and sampled by area instead; what they send is counted once.

import type { LitScene } from "./light";
import { evenly, locate, pointAt, type Point } from "./field";

export interface Sight {
  patch: number;
  distance: number;
  /** Whether it is the front of the patch; backs are black. */
  isFront: boolean;
}

/** What a ray finds first; the direction has length one. */
export type Closest = (origin: Point, direction: Point) => Sight | null;

/** Rays that ask for a row. */
export const RAYS = 4096;

export interface Row {
  /** Of each sample: the patch that it found. */
  patch: Uint32Array;
  /** Coordinates on it, two a sample. */
  st: Float32Array;
  /** How much it adds to the form factor. */
  factor: Float32Array;
  /** The share that leaves the scene. */
  outside: number;
  /** The share that meets the backs of patches, which are black. */
  backs: number;
}

/** What a surface has in the light of a point. */
export interface Source {
  surface: number;
  /** From the point to the surface. */
  factor: number;
  /** What arrives of its radiosity, by band. */
  irradiance: number[];
}

/** Where the light of a point leaves from: a part of a surface that lies in one plane or nearly. */
export interface Origin extends Source {
  point: Point;
}

/** Asks rays for the row of F of a point on the front of a patch. */
export function row(lit: LitScene, patch: number, point: Point, closest: Closest, rays = RAYS): Row {
  const normal = [...lit.normal.subarray(3 * patch, 3 * patch + 3)] as Point;
  const start = along(point, normal, offset(lit));
  const collected = new Collected(lit);
  const emitters = smallEmitters(lit, start, normal);
  collected.byRays(start, normal, patch, closest, rays, emitters.isSmall);
  collected.byArea(start, normal, patch, closest, rays >> 2, emitters);
  return collected.row();
}

/** What arrives of each sample in the light as it is, samples x bands. */
export function arrivals(lit: LitScene, { patch, st, factor }: Row): Float64Array {
  const out = new Float64Array(patch.length * lit.bands);
  patch.forEach((p, i) => lit.addRadiosity(p, st[2 * i], st[2 * i + 1], factor[i], out, i * lit.bands));
  return out;
}

/** By surface, the brightest first. */
export function sources(lit: LitScene, row: Row, arriving = arrivals(lit, row)): Source[] {
  return groups(lit, row, arriving, (patch) => lit.surface[patch]).map(({ sum }) => sum);
}

/** By parts of surfaces that face one way, the `most` brightest first, and where the middle of their light is. */
export function origins(lit: LitScene, row: Row, most: number, arriving = arrivals(lit, row)): Origin[] {
  const facing = (patch: number) => {
    const axis = (k: number) => Math.round(lit.normal[3 * patch + k]) + 1;
    return 27 * lit.surface[patch] + 9 * axis(0) + 3 * axis(1) + axis(2);
  };
  return groups(lit, row, arriving, facing)
    .slice(0, most)
    .map(({ sum, samples }) => ({ ...sum, point: middle(lit, row, samples) }));
}

/** All bands together. */
export function total(spectrum: number[]): number {
  return spectrum.reduce((a, b) => a + b, 0);
}

interface Group {
  sum: Source;
  samples: number[];
}

function groups(lit: LitScene, row: Row, arriving: Float64Array, key: (patch: number) => number): Group[] {
  const { bands, surface } = lit;
  const found = new Map<number, Group>();
  row.patch.forEach((patch, i) => {
    const name = key(patch);
    let group = found.get(name);
    if (!group) {
      const irradiance = Array<number>(bands).fill(0);
      found.set(name, (group = { sum: { surface: surface[patch], factor: 0, irradiance }, samples: [] }));
    }
    group.sum.factor += row.factor[i];
    for (let band = 0; band < bands; band++) group.sum.irradiance[band] += arriving[i * bands + band];
    group.samples.push(i);
  });
  return [...found.values()].sort(
    (a, b) => total(b.sum.irradiance) - total(a.sum.irradiance) || b.sum.factor - a.sum.factor,
  );
}

/** The sample that is nearest to the mean of all: a place that the point sees. */
function middle(lit: LitScene, row: Row, samples: number[]): Point {
  const points = samples.map((i) => pointAt(lit.polygons, row.patch[i], row.st[2 * i], row.st[2 * i + 1]));
  const mean: Point = [0, 0, 0];
  const weight = samples.reduce((sum, i) => sum + row.factor[i], 0);
  points.forEach((p, k) => p.forEach((x, axis) => (mean[axis] += (row.factor[samples[k]] / weight) * x)));
  const distances = points.map((p) => Math.hypot(p[0] - mean[0], p[1] - mean[1], p[2] - mean[2]));
  return points[distances.indexOf(Math.min(...distances))];
}

/** Emitters that subtend little, with how many samples by area each is due. */
interface Emitters {
  patches: number[];
  /** Of sampling each. */
  probability: number[];
  isSmall: Uint8Array;
}

/** Whether an emitter is small enough for samples by area: its form factor is below 1 / (4 pi). */
const SMALL = 0.25;

function smallEmitters(lit: LitScene, start: Point, normal: Point): Emitters {
  const patches: number[] = [];
  const weights: number[] = [];
  const isSmall = new Uint8Array(lit.count);
  for (const { patch, emission } of lit.emitters) {
    const to = minus(pointAt(lit.polygons, patch, 0.5, 0.5), start);
    const square = dot(to, to);
    if (lit.area[patch] > SMALL * square) continue;
    const facing = -dot(to, normalOf(lit, patch)) / Math.sqrt(square);
    if (facing <= 0) continue;
    // Over a patch the cosine at the point is largest at a corner; where that is behind, all of it is.
    const high = Math.max(...[0, 1, 2, 3].map((k) => dot(minus(cornerOf(lit, patch, k), start), normal)));
    if (high <= 0) continue;
    patches.push(patch);
    weights.push((emission * lit.area[patch] * facing * high) / (square * Math.sqrt(square)));
    isSmall[patch] = 1;
  }
  const all = total(weights);
  return { patches, probability: weights.map((w) => w / all), isSmall };
}

class Collected {
  private readonly patch: number[] = [];
  private readonly st: number[] = [];
  private readonly factor: number[] = [];
  private outside = 0;
  private backs = 0;

  constructor(private readonly lit: LitScene) {}

  /** Rays of a cosine distribution; what they find of small emitters is left to the other samples. */
  byRays(start: Point, normal: Point, seed: number, closest: Closest, rays: number, isSmall: Uint8Array): void {
    const [tangent, bitangent] = frame(normal);
    for (let i = 0; i < rays; i++) {
      const [x, y] = disk(...spread(i, seed));
      const z = Math.sqrt(Math.max(0, 1 - x * x - y * y));
      const direction = [0, 1, 2].map((k) => x * tangent[k] + y * bitangent[k] + z * normal[k]) as Point;
      const sight = closest(start, direction);
      if (!sight) this.outside += 1 / rays;
      else if (!sight.isFront) this.backs += 1 / rays;
      else if (!isSmall[sight.patch]) {
        const [px, py, pz] = along(start, direction, sight.distance);
        this.add(sight.patch, ...locate(this.lit.polygons, sight.patch, px, py, pz), 1 / rays);
      }
    }
  }

  /** Points on emitters, as many as their light is worth; the next in line share one fairly. */
  byArea(start: Point, normal: Point, seed: number, closest: Closest, count: number, emitters: Emitters): void {
    const { patches, probability } = emitters;
    const { polygons, area } = this.lit;
    let which = -1;
    let below = 0; // the probability of all up to `which`
    for (let i = 0; i < count && patches.length; i++) {
      while (which < 0 || (below < (i + 0.5) / count && which < patches.length - 1)) below += probability[++which];
      const patch = patches[which];
      const [s, t] = evenly(polygons, patch, ...spread(i, seed + 1));
      const to = minus(pointAt(polygons, patch, s, t), start);
      const distance = Math.sqrt(dot(to, to));
      const direction = to.map((x) => x / distance) as Point;
      const cosines = Math.max(0, dot(direction, normal)) * Math.max(0, -dot(direction, normalOf(this.lit, patch)));
      if (cosines === 0) continue;
      const sight = closest(start, direction);
      if (sight && sight.distance < distance * (1 - 1e-4)) continue;
      this.add(patch, s, t, (cosines * area[patch]) / (Math.PI * distance ** 2 * count * probability[which]));
    }
  }

  row(): Row {
    const { outside, backs } = this;
    return {
      patch: Uint32Array.from(this.patch), st: Float32Array.from(this.st), factor: Float32Array.from(this.factor),
      outside, backs,
    };
  }

  private add(patch: number, s: number, t: number, factor: number): void {
    this.patch.push(patch);
    this.st.push(s, t);
    this.factor.push(factor);
  }
}

/** Roberts 2018, "The unreasonable effectiveness of quasirandom sequences": R2, shifted by a number. */
function spread(index: number, seed: number): [number, number] {
  return [fraction(shift(seed, 0) + index * 0.7548776662466927), fraction(shift(seed, 1) + index * 0.5698402909980532)];
}

function shift(seed: number, axis: number): number {
  let h = Math.imul(seed + 1, 0x9e3779b1) ^ Math.imul(axis + 1, 0x85ebca6b);
  h = Math.imul(h ^ (h >>> 15), 0x2c1b3c6d);
  return ((h ^ (h >>> 12)) >>> 0) / 2 ** 32;
}

function fraction(x: number): number {
  return x - Math.floor(x);
}

/** Shirley and Chiu 1997, "A low distortion map between disk and square". */
function disk(u: number, v: number): [number, number] {
  const [a, b] = [2 * u - 1, 2 * v - 1];
  if (a === 0 && b === 0) return [0, 0];
  const isWide = Math.abs(a) > Math.abs(b);
  const radius = isWide ? a : b;
  const angle = isWide ? (Math.PI / 4) * (b / a) : Math.PI / 2 - (Math.PI / 4) * (a / b);
  return [radius * Math.cos(angle), radius * Math.sin(angle)];
}

/** Duff et al. 2017, "Building an orthonormal basis, revisited". */
function frame([x, y, z]: Point): [Point, Point] {
  const sign = z >= 0 ? 1 : -1;
  const a = -1 / (sign + z);
  const b = x * y * a;
  return [[1 + sign * x * x * a, sign * b, -sign * x], [b, sign + y * y * a, -y]];
}

/** Far enough off the surface for single precision, metres. */
function offset(lit: LitScene): number {
  return 1e-5 * lit.size;
}

function normalOf(lit: LitScene, patch: number): Point {
  return [lit.normal[3 * patch], lit.normal[3 * patch + 1], lit.normal[3 * patch + 2]];
}

function cornerOf(lit: LitScene, patch: number, corner: number): Point {
  const at = 12 * patch + 3 * corner;
  return [lit.polygons[at], lit.polygons[at + 1], lit.polygons[at + 2]];
}

function along(point: Point, direction: Point, distance: number): Point {
  return [
    point[0] + distance * direction[0], point[1] + distance * direction[1], point[2] + distance * direction[2],
  ];
}

function minus(a: Point, b: Point): Point {
  return [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
}

function dot(a: Point, b: Point): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
