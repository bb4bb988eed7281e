// What a camera would expose for: the logarithmic mean of what it sees becomes middle grey (Reinhard et al. 2002).

import * as THREE from "three";
import { KEY } from "./tone";

/** Pixels on a side of the picture that is measured. */
const SIZE = 48;

/** Milliseconds from one measurement to the next while the view moves: reading back holds up the graphics card. */
const PAUSE = 100;

/** Where measuring takes long, this many times as long passes between. */
const PATIENCE = 4;

/** Seconds in which the exposure comes nearer by a factor of e, where it adapts: most of the way in half a second. */
const ADAPTS = 0.15;

/** Of the exposure: nobody sees less. */
const CLOSE = 0.002;

export class Meter {
  /** What multiplies values before the tone curve. */
  exposure = 1;
  /** Whether it comes to a new exposure by and by. */
  isSmooth = false;
  private wanted = 1;
  private last = -Infinity;
  private took = 0;
  private isFresh = false;
  private readonly target = new THREE.WebGLRenderTarget(SIZE, SIZE, { type: THREE.FloatType });
  private readonly pixels = new Float32Array(4 * SIZE * SIZE);

  /** The light is another one: what was adapted to counts no longer. */
  forget(): void {
    this.last = -Infinity;
    this.isFresh = true;
  }

  /**
   * Comes nearer to the exposure of the view, and measures that if it is time to.
   *
   * @param render draws linear values on a black ground with no alpha.
   * @returns whether it is not there yet and wants another picture.
   */
  adapt(renderer: THREE.WebGLRenderer, seconds: number, render: () => void): boolean {
    const now = performance.now();
    const isDue = now - this.last >= Math.max(PAUSE, PATIENCE * this.took);
    if (isDue) this.measure(renderer, render, now);
    const step = this.isSmooth && !this.isFresh ? 1 - Math.exp(-seconds / ADAPTS) : 1;
    const gap = Math.log(this.wanted / this.exposure);
    if (Math.abs(gap) < CLOSE || step === 1) this.exposure = this.wanted;
    else this.exposure *= Math.exp(step * gap);
    this.isFresh = false;
    return !isDue || this.exposure !== this.wanted;
  }

  /** Exposes for the view at once. */
  take(renderer: THREE.WebGLRenderer, render: () => void): void {
    this.measure(renderer, render, performance.now());
    this.exposure = this.wanted;
  }

  private measure(renderer: THREE.WebGLRenderer, render: () => void, now: number): void {
    const { target, pixels } = this;
    const before = renderer.getRenderTarget();
    renderer.setRenderTarget(target);
    renderer.setClearColor(0, 0);
    renderer.clear();
    render();
    renderer.readRenderTargetPixels(target, 0, 0, SIZE, SIZE, pixels);
    renderer.setRenderTarget(before);
    this.wanted = exposureOf(pixels);
    this.last = performance.now();
    this.took = this.last - now;
  }
}

/** The exposure for a picture, four linear values a pixel; black pixels do not count. */
export function exposureOf(pixels: Float32Array): number {
  let sum = 0;
  let count = 0;
  for (let i = 0; i < pixels.length; i += 4) {
    const l = 0.2126 * pixels[i] + 0.7152 * pixels[i + 1] + 0.0722 * pixels[i + 2]; // as tone.ts
    if (!(l > 0 && l < Infinity)) continue;
    sum += Math.log(l);
    count++;
  }
  return count ? KEY / Math.exp(sum / count) : 1;
}
