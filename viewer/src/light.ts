// Patches and the light on them, lamp by lamp: B = E + rho H, and light is linear.

import { Sphere, Vector3 } from "three";
import { cornerWeights } from "./field";
import type { LightHead, SceneHead } from "./messages";
import type { Packet } from "./packet";

export type Quantity = "radiosity" | "irradiance" | "emission" | "error" | "reflectance" | "patches";

export const QUANTITIES: Quantity[] = ["radiosity", "irradiance", "emission", "error", "reflectance", "patches"];

/** The share of all area up to which lamps are something apart. */
const FEW = 0.1;

/** Numbers of one patch, for those who ask about it. */
export interface Spectra {
  irradiance: number[];
  radiosity: number[];
  emission: number[];
  error: number[];
  reflectance: number[];
}

export interface Emitter {
  patch: number;
  /** W/m2, all bands and layers together. */
  emission: number;
}

export class LitScene {
  readonly head: SceneHead;
  readonly count: number;
  readonly bands: number;
  /** count x 4 corners x 3, metres from head.origin; a triangle repeats its last corner. */
  readonly polygons: Float32Array;
  readonly surface: Uint32Array;
  /** 1 where a patch is a triangle. */
  readonly isTriangle: Uint8Array;
  /** Square metres. */
  readonly area: Float32Array;
  /** count x 3, unit. */
  readonly normal: Float32Array;
  /** Least and greatest coordinates, metres from head.origin. */
  readonly low: [number, number, number];
  readonly high: [number, number, number];
  /** The largest extent of the patches, metres. */
  readonly size: number;
  /** How much of each layer there is: layers x bands. Change it with `mix`. */
  readonly weights: Float32Array;

  private emission!: Float32Array;
  private irradiance!: Float32Array;
  private cornerIrradiance!: Float32Array;
  private error!: Float32Array;
  private reflectance: number[][];
  private firstEmitters: Emitter[] | null = null;

  constructor(packet: Packet) {
    if (packet.head.type !== "scene") throw new Error("the packet holds no scene");
    this.head = packet.head;
    this.polygons = packet.floats("polygons");
    this.surface = packet.indices("surface");
    this.count = this.surface.length;
    this.bands = this.head.bands.length;
    this.reflectance = this.head.surfaces.map((surface) => surface.reflectance);
    this.weights = new Float32Array(packet.shape("emission")[0] * this.bands).fill(1);
    [this.isTriangle, this.area, this.normal] = shapes(this.polygons);
    [this.low, this.high] = bounds(this.polygons);
    this.size = Math.max(...this.high.map((x, axis) => x - this.low[axis]), 0);
    this.takeLight(packet);
  }

  /** Around all patches. */
  sphere(): Sphere {
    const low = new Vector3(...this.low);
    const middle = new Vector3(...this.high).add(low).multiplyScalar(0.5);
    return new Sphere(middle, middle.distanceTo(low));
  }

  get layers(): number {
    return this.weights.length / this.bands;
  }

  /** Whether the light is another than that which was solved for, whose error is known. */
  get isMixed(): boolean {
    return this.weights.some((weight) => weight !== 1);
  }

  /** Other light on the same patches. */
  relight(packet: Packet): void {
    if (packet.head.type !== "light") throw new Error("the packet holds no light");
    this.firstEmitters ??= this.findEmitters();
    this.reflectance = (packet.head as LightHead).reflectance;
    this.takeLight(packet);
  }

  private takeLight(packet: Packet): void {
    const [layers, count, bands] = packet.shape("emission");
    if (layers !== this.layers || count !== this.count || bands !== this.bands)
      throw new Error("the light is of other patches");
    this.emission = packet.floats("emission");
    this.irradiance = packet.floats("irradiance");
    this.cornerIrradiance = packet.floats("corner_irradiance");
    this.error = packet.floats("error");
  }

  private findEmitters(): Emitter[] {
    const emission = new Float64Array(this.count);
    for (let layer = 0, at = 0; layer < this.layers; layer++)
      for (let patch = 0; patch < this.count; patch++)
        for (let band = 0; band < this.bands; band++) emission[patch] += this.emission[at++];
    const emitters: Emitter[] = [];
    emission.forEach((e, patch) => e > 0 && emitters.push({ patch, emission: e }));
    return emitters;
  }

  /** Sets how much of a layer there is, by band. */
  mix(layer: number, weights: ArrayLike<number>): void {
    for (let b = 0; b < this.bands; b++) this.weights[layer * this.bands + b] = weights[b];
  }

  /** Sum over layers of an array of layers x (count x per) x bands, for one row of bands. */
  private mixed(array: Float32Array, row: number, band: number): number {
    const stride = array.length / this.layers;
    let sum = 0;
    for (let layer = 0, at = row * this.bands + band; layer < this.layers; layer++, at += stride)
      sum += this.weights[layer * this.bands + band] * array[at];
    return sum;
  }

  /** What a patch has: means over it. */
  of(patch: number): Spectra {
    const all = <T>(value: (band: number) => T) => Array.from({ length: this.bands }, (_, band) => value(band));
    const reflectance = this.reflectanceOf(this.surface[patch]);
    const emission = all((b) => this.mixed(this.emission, patch, b));
    const irradiance = all((b) => this.mixed(this.irradiance, patch, b));
    return {
      irradiance,
      emission,
      radiosity: all((b) => emission[b] + reflectance[b] * irradiance[b]),
      error: all((b) => this.error[patch * this.bands + b]),
      reflectance,
    };
  }

  /** Irradiance of the field at a place of a patch, which is what a smooth picture shows. */
  irradianceAt(patch: number, s: number, t: number): number[] {
    const corners = cornerWeights(this.isTriangle[patch] === 1, s, t);
    return Array.from({ length: this.bands }, (_, band) =>
      corners.reduce((sum, w, k) => (w ? sum + w * this.mixed(this.cornerIrradiance, 4 * patch + k, band) : sum), 0),
    );
  }

  /** Radiosity of the field at a place of a patch. */
  radiosityAt(patch: number, s: number, t: number): number[] {
    const out = new Float64Array(this.bands);
    this.addRadiosity(patch, s, t, 1, out, 0);
    return [...out];
  }

  /** Adds a factor times the radiosity at a place of a patch to `out`, a number a band from `first` on. */
  addRadiosity(patch: number, s: number, t: number, factor: number, out: Float64Array, first: number): void {
    const { bands, layers, count, weights, emission, cornerIrradiance: corners } = this;
    const [a, b, c, d] = cornerWeights(this.isTriangle[patch] === 1, s, t);
    const reflectance = this.reflectance[this.surface[patch]];
    for (let layer = 0; layer < layers; layer++)
      for (let band = 0; band < bands; band++) {
        const row = layer * count + patch;
        const at = 4 * row * bands + band;
        const arrives = a * corners[at] + b * corners[at + bands] + c * corners[at + 2 * bands] + d * corners[at + 3 * bands];
        out[first + band] +=
          factor * weights[layer * bands + band] * (emission[row * bands + band] + reflectance[band] * arrives);
      }
  }

  /** Patches that emit when every layer is there once, as they were first; relighting does not make them others. */
  get emitters(): Emitter[] {
    return (this.firstEmitters ??= this.findEmitters());
  }

  /**
   * Areas, zero where a patch is a lamp: more than half of its radiosity is its own. All of them where lamps are a large
   * part of the scene, as in heat.
   */
  areaWithoutLamps(): Float32Array {
    const area = this.area.slice();
    const emission = this.sums("emission");
    const radiosity = this.sums("radiosity");
    let lamps = 0;
    let whole = 0;
    for (let patch = 0; patch < this.count; patch++) {
      whole += area[patch];
      if (emission[4 * patch] <= 0.5 * radiosity[4 * patch]) continue;
      lamps += area[patch];
      area[patch] = 0;
    }
    return lamps < FEW * whole ? area : this.area;
  }

  /** Of all bands, by patch, four times. */
  private sums(quantity: Quantity): Float32Array {
    const sum = new Float32Array(4 * this.count);
    const one = new Float32Array(4 * this.count);
    for (let band = 0; band < this.bands; band++) {
      this.fill(quantity, band, false, one, 0, 1);
      for (let i = 0; i < sum.length; i++) sum[i] += one[i];
    }
    return sum;
  }

  reflectanceOf(surface: number): number[] {
    return this.reflectance[surface];
  }

  /**
   * Values of one band at the four corners of every patch, or of the patch four times.
   *
   * @param step distance of one corner's value from the next in `out`.
   */
  fill(quantity: Quantity, band: number, smooth: boolean, out: Float32Array, first: number, step: number): void {
    const { count } = this;
    const n = 4 * count * step + first;
    if (quantity === "patches") {
      for (let patch = 0, at = first; patch < count; patch++) {
        const colour = tint(patch, band % 3);
        for (let k = 0; k < 4; k++, at += step) out[at] = colour;
      }
      return;
    }
    for (let at = first; at < n; at += step) out[at] = 0;
    if (quantity === "reflectance") return this.addByPatch((patch) => this.reflectance[this.surface[patch]][band], out, first, step);
    if (quantity === "error") return this.addByPatch((patch) => this.error[patch * this.bands + band], out, first, step);
    if (quantity !== "emission") this.addIrradiance(band, smooth, out, first, step);
    if (quantity === "irradiance") return;
    if (quantity === "radiosity") this.reflect(band, out, first, step);
    for (let layer = 0; layer < this.layers; layer++) {
      const weight = this.weights[layer * this.bands + band];
      const rows = layer * count * this.bands + band;
      if (weight) this.addByPatch((patch) => weight * this.emission[rows + patch * this.bands], out, first, step);
    }
  }

  private addByPatch(value: (patch: number) => number, out: Float32Array, first: number, step: number): void {
    for (let patch = 0, at = first; patch < this.count; patch++) {
      const one = value(patch);
      for (let k = 0; k < 4; k++, at += step) out[at] += one;
    }
  }

  private addIrradiance(band: number, smooth: boolean, out: Float32Array, first: number, step: number): void {
    const { bands, layers, count, weights } = this;
    const array = smooth ? this.cornerIrradiance : this.irradiance;
    const end = 4 * count * step + first;
    for (let layer = 0; layer < layers; layer++) {
      const weight = weights[layer * bands + band];
      if (!weight) continue;
      let from = layer * (array.length / layers) + band;
      if (smooth) for (let at = first; at < end; at += step, from += bands) out[at] += weight * array[from];
      else this.addByPatch((patch) => weight * array[from + patch * bands], out, first, step);
    }
  }

  private reflect(band: number, out: Float32Array, first: number, step: number): void {
    const reflectance = Float32Array.from(this.reflectance, (rho) => rho[band]);
    for (let patch = 0, at = first; patch < this.count; patch++) {
      const rho = reflectance[this.surface[patch]];
      for (let k = 0; k < 4; k++, at += step) out[at] *= rho;
    }
  }
}

/** A colour for a patch that its neighbours do not have. */
function tint(patch: number, channel: number): number {
  let h = Math.imul(patch + 1, 0x9e3779b1) ^ Math.imul(channel + 1, 0x85ebca6b);
  h = Math.imul(h ^ (h >>> 15), 0x2c1b3c6d);
  return 0.15 + 0.7 * (((h ^ (h >>> 12)) >>> 0) / 2 ** 32);
}

function bounds(polygons: Float32Array): [[number, number, number], [number, number, number]] {
  if (!polygons.length) return [[0, 0, 0], [0, 0, 0]];
  const low: [number, number, number] = [Infinity, Infinity, Infinity];
  const high: [number, number, number] = [-Infinity, -Infinity, -Infinity];
  for (let axis = 0; axis < 3; axis++)
    for (let i = axis; i < polygons.length; i += 3) {
      const x = polygons[i];
      if (x < low[axis]) low[axis] = x;
      if (x > high[axis]) high[axis] = x;
    }
  return [low, high];
}

/** Half the cross product of the diagonals is the area along the normal. */
function shapes(q: Float32Array): [Uint8Array, Float32Array, Float32Array] {
  const count = q.length / 12;
  const isTriangle = new Uint8Array(count);
  const area = new Float32Array(count);
  const normal = new Float32Array(3 * count);
  for (let i = 0, p = 0; i < count; i++, p += 12) {
    const ax = q[p + 6] - q[p];
    const ay = q[p + 7] - q[p + 1];
    const az = q[p + 8] - q[p + 2];
    const bx = q[p + 9] - q[p + 3];
    const by = q[p + 10] - q[p + 4];
    const bz = q[p + 11] - q[p + 5];
    const x = ay * bz - az * by;
    const y = az * bx - ax * bz;
    const z = ax * by - ay * bx;
    const length = Math.sqrt(x * x + y * y + z * z);
    area[i] = length / 2;
    normal[3 * i] = length > 0 ? x / length : 0;
    normal[3 * i + 1] = length > 0 ? y / length : 1;
    normal[3 * i + 2] = length > 0 ? z / length : 0;
    isTriangle[i] = q[p + 6] === q[p + 9] && q[p + 7] === q[p + 10] && q[p + 8] === q[p + 11] ? 1 : 0;
  }
  return [isTriangle, area, normal];
}
