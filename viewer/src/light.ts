// Patches and the light on them, lamp by lamp: B = E + rho H, and light is linear.

import { cornerWeights } from "./field";
import type { LightHead, SceneHead } from "./messages";
import type { Packet } from "./packet";

export type Quantity = "radiosity" | "irradiance" | "emission" | "error" | "reflectance" | "patches";

export const QUANTITIES: Quantity[] = ["radiosity", "irradiance", "emission", "error", "reflectance", "patches"];

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
    this.size = extent(this.polygons);
    this.takeLight(packet);
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
    for (let i = 0; i < this.emission.length; i++)
      emission[Math.floor(i / this.bands) % this.count] += this.emission[i];
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

  reflectanceOf(surface: number): number[] {
    return this.reflectance[surface];
  }

  /**
   * Values of one band at the four corners of every patch, or of the patch four times.
   *
   * @param step distance of one corner's value from the next in `out`.
   */
  fill(quantity: Quantity, band: number, smooth: boolean, out: Float32Array, first: number, step: number): void {
    const { bands, count, layers, weights } = this;
    const n = 4 * count;
    if (quantity === "radiosity" || quantity === "irradiance") {
      const array = smooth ? this.cornerIrradiance : this.irradiance;
      for (let i = 0; i < n; i++) out[first + i * step] = 0;
      for (let layer = 0; layer < layers; layer++) {
        const weight = weights[layer * bands + band];
        const rows = layer * (array.length / layers) + band;
        for (let i = 0; i < n; i++) out[first + i * step] += weight * array[rows + (smooth ? i : i >> 2) * bands];
      }
    }
    if (quantity === "irradiance") return;
    for (let patch = 0; patch < count; patch++) {
      const rho = this.reflectance[this.surface[patch]][band];
      const emitted = quantity === "radiosity" || quantity === "emission" ? this.mixed(this.emission, patch, band) : 0;
      for (let i = 4 * patch; i < 4 * patch + 4; i++) {
        const at = first + i * step;
        if (quantity === "radiosity") out[at] = emitted + rho * out[at];
        else if (quantity === "emission") out[at] = emitted;
        else if (quantity === "reflectance") out[at] = rho;
        else if (quantity === "error") out[at] = this.error[patch * bands + band];
        else out[at] = tint(patch, band % 3);
      }
    }
  }
}

/** A colour for a patch that its neighbours do not have. */
function tint(patch: number, channel: number): number {
  let h = Math.imul(patch + 1, 0x9e3779b1) ^ Math.imul(channel + 1, 0x85ebca6b);
  h = Math.imul(h ^ (h >>> 15), 0x2c1b3c6d);
  return 0.15 + 0.7 * (((h ^ (h >>> 12)) >>> 0) / 2 ** 32);
}

function extent(polygons: Float32Array): number {
  let largest = 0;
  for (let axis = 0; axis < 3; axis++) {
    let [low, high] = [Infinity, -Infinity];
    for (let i = axis; i < polygons.length; i += 3) {
      if (polygons[i] < low) low = polygons[i];
      if (polygons[i] > high) high = polygons[i];
    }
    largest = Math.max(largest, high - low);
  }
  return largest;
}

function shapes(polygons: Float32Array): [Uint8Array, Float32Array, Float32Array] {
  const count = polygons.length / 12;
  const isTriangle = new Uint8Array(count);
  const area = new Float32Array(count);
  const normal = new Float32Array(3 * count);
  for (let i = 0, p = 0; i < count; i++, p += 12) {
    const [ax, ay, az] = [polygons[p + 6] - polygons[p], polygons[p + 7] - polygons[p + 1], polygons[p + 8] - polygons[p + 2]];
    const [bx, by, bz] = [polygons[p + 9] - polygons[p + 3], polygons[p + 10] - polygons[p + 4], polygons[p + 11] - polygons[p + 5]];
    const [x, y, z] = [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx];
    const length = Math.hypot(x, y, z);
    area[i] = length / 2;
    normal.set(length > 0 ? [x / length, y / length, z / length] : [0, 1, 0], 3 * i);
    isTriangle[i] = [6, 7, 8].every((k) => polygons[p + k] === polygons[p + k + 3]) ? 1 : 0;
  }
  return [isTriangle, area, normal];
}
