// Draws the patches. It owns the renderer, the camera and the values on the graphics card; it knows no panels.

import * as THREE from "three";
import type { CameraHead } from "./messages";
import type { LitScene, Quantity } from "./light";
import { Meter } from "./meter";
import { triangles } from "./patches";
import { roundStep, top } from "./range";
import { FRAGMENT, LOOK, VERTEX } from "./shaders";
import { DEFAULTS, type Settings } from "./settings";
import { Statistics } from "./statistics";
import { CURVES, table } from "./tone";
import { bandWeights, conversion, hasUnit } from "./units";

/** Texels in a row of values. */
const WIDTH = 4096;

/** Seconds: what takes longer goes slower. */
const LONGEST = 0.25;

/** Of logarithmic scales, unless chosen: the first value is a thousandth of the last. */
const LOGARITHMIC = 1e-3;

export class Stage {
  readonly renderer: THREE.WebGLRenderer;
  readonly camera = new THREE.PerspectiveCamera(50, 1, 0.01, 1000);
  readonly scene = new THREE.Scene();
  readonly meter = new Meter();
  readonly statistics = new Statistics();
  settings: Settings = { ...DEFAULTS };
  lit: LitScene | null = null;
  /** Whether there is light on the patches; their paint is shown before. */
  isLit = true;
  mesh: THREE.Mesh<THREE.BufferGeometry, THREE.RawShaderMaterial> | null = null;
  /** Called before each picture, with seconds since the last; returns whether it changed anything. */
  readonly beforeFrame: ((seconds: number) => boolean)[] = [];
  /** Called after each picture. */
  readonly afterFrame: (() => void)[] = [];

  private values: THREE.DataTexture | null = null;
  private readonly colours = new THREE.DataTexture(table("viridis"), 256, 1);
  private readonly material: THREE.RawShaderMaterial;
  /** The vertical angle of the viewpoint, radians; narrow pictures see more than that. */
  private angle = THREE.MathUtils.degToRad(50);
  private known: number | null = null;
  private isStale = true;
  private last = performance.now();

  /** Throws where the browser has no WebGL 2. */
  constructor(canvas: HTMLCanvasElement) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, powerPreference: "high-performance" });
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace; // the shader encodes by itself
    this.scene.background = new THREE.Color().setHex(0x101114, THREE.LinearSRGBColorSpace);
    this.colours.minFilter = this.colours.magFilter = THREE.LinearFilter;
    this.colours.needsUpdate = true;
    this.material = new THREE.RawShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      side: THREE.FrontSide,
      uniforms: {
        values: { value: null },
        colours: { value: this.colours },
        look: { value: LOOK.developed },
        curve: { value: 0 },
        exposure: { value: 1 },
        weights: { value: new THREE.Vector3() },
        scale: { value: new THREE.Vector3(0, 1, 0) },
        isolines: { value: 0 },
        mesh: { value: 0 },
        chosen: { value: new THREE.Vector2(-1, 0) },
      },
    });
    this.renderer.setAnimationLoop(() => this.frame());
  }

  /** Shows other patches, or the same with other light if they are. */
  show(lit: LitScene, isLit = true): void {
    const isNew = this.lit !== lit;
    if (isNew || isLit !== this.isLit) this.meter.forget();
    this.isLit = isLit;
    if (isNew) this.takePatches(lit);
    this.takeValues();
  }

  /** Shows the same in another way. */
  set(change: Partial<Settings>): void {
    const before = this.settings;
    this.settings = { ...before, ...change };
    const { quantity, band, smooth, map } = this.settings;
    if (map !== before.map) {
      (this.colours.image.data as Uint8Array).set(table(map));
      this.colours.needsUpdate = true;
    }
    if (quantity !== before.quantity || band !== before.band || smooth !== before.smooth) {
      this.meter.forget();
      this.takeValues();
    }
    this.known = null;
    this.invalidate();
  }

  /** What is shown: the paint as long as there is no light. */
  get quantity(): Quantity {
    return this.isLit || this.settings.quantity === "patches" ? this.settings.quantity : "reflectance";
  }

  /** What multiplies values before the tone curve. */
  get exposure(): number {
    if (this.isMetered) return this.meter.exposure;
    // Radiosity is shown as radiance; exposure in stops counts on that.
    return 2 ** this.settings.exposure * (this.quantity === "radiosity" ? 1 / Math.PI : 1);
  }

  /** First and last value of the colour scale, in the unit shown. */
  get range(): [number, number] {
    if (this.settings.range) return this.settings.range;
    const high = (this.known ??= this.highest());
    return [this.settings.isLogarithmic ? LOGARITHMIC * high : 0, high];
  }

  /** Has a picture drawn soon. */
  invalidate(): void {
    this.isStale = true;
  }

  lookThrough(camera: CameraHead): void {
    this.camera.position.set(...camera.position);
    this.camera.up.set(...camera.up);
    this.camera.lookAt(this.camera.position.clone().add(new THREE.Vector3(...camera.forward)));
    this.verticalAngle = camera.vertical_fov;
  }

  /** Of the viewpoint, radians. A picture that is higher than wide sees as much across as a square one would. */
  set verticalAngle(angle: number) {
    this.angle = angle;
    const shown = 2 * Math.atan(Math.tan(angle / 2) / Math.min(this.camera.aspect, 1));
    this.camera.fov = THREE.MathUtils.radToDeg(shown);
    this.camera.updateProjectionMatrix();
    this.invalidate();
  }

  get verticalAngle(): number {
    return this.angle;
  }

  /** Pixels of the page. */
  resize(width: number, height: number): void {
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = Math.max(width, 1) / Math.max(height, 1);
    this.verticalAngle = this.angle;
    this.draw(); // a canvas of another size is empty until then
  }

  /** Marks a patch; -1 marks none. */
  mark(patch: number, percent = 50): void {
    this.material.uniforms.chosen.value.set(patch, percent);
    this.invalidate();
  }

  /** Draws if anything changed. */
  private frame(): void {
    const now = performance.now();
    const seconds = Math.min((now - this.last) / 1000, LONGEST);
    this.last = now;
    for (const before of this.beforeFrame) if (before(seconds)) this.isStale = true;
    if (!this.isStale || this.isLost) return this.statistics.rest();
    this.isStale = this.isMetered && this.meter.adapt(this.renderer, seconds, () => this.renderLinear());
    this.render();
    this.afterFrame.forEach((after) => after());
    this.statistics.count(now, performance.now() - now);
  }

  /** Draws now, exposed for just this view. */
  draw(): void {
    if (this.isLost) return;
    if (this.isMetered) this.meter.take(this.renderer, () => this.renderLinear());
    this.render();
    this.afterFrame.forEach((after) => after());
  }

  /** Whether the browser took the graphics card away. */
  private get isLost(): boolean {
    return this.renderer.getContext().isContextLost();
  }

  private get isMetered(): boolean {
    return this.settings.isExposureAutomatic && this.look === LOOK.developed;
  }

  private get look(): number {
    if (this.quantity === "patches") return LOOK.plain;
    if (this.settings.falseColours && this.isLit) return LOOK.falseColours;
    return this.quantity === "reflectance" ? LOOK.plain : LOOK.developed;
  }

  private render(): void {
    const { settings, look } = this;
    const u = this.material.uniforms;
    u.look.value = look;
    u.curve.value = CURVES.indexOf(settings.curve);
    u.exposure.value = this.exposure;
    u.isolines.value = 0;
    if (look === LOOK.falseColours || this.hasIsolines) {
      u.weights.value.set(...this.weights);
      u.scale.value.set(...this.range, settings.isLogarithmic ? 1 : 0);
      u.isolines.value = this.hasIsolines ? this.isolineStep : 0;
    }
    u.mesh.value = settings.mesh || !this.isLit ? 0.35 : 0;
    this.renderer.render(this.scene, this.camera);
  }

  /** Linear values on nothing, for the meter. */
  private renderLinear(): void {
    const { background } = this.scene;
    const u = this.material.uniforms;
    u.look.value = LOOK.linear;
    this.scene.background = null;
    this.renderer.render(this.scene, this.camera);
    this.scene.background = background;
  }

  get hasIsolines(): boolean {
    return this.settings.isolines && this.isLit && this.quantity !== "patches";
  }

  /** The distance of two isolines: a round number that makes some ten of them; in decades if logarithmic. */
  get isolineStep(): number {
    if (this.settings.isLogarithmic) return 0.25;
    const [low, high] = this.range;
    return roundStep((high - low) / 10);
  }

  /** What makes the one number of the three that are on the graphics card, in the unit shown. */
  get weights(): [number, number, number] {
    const { lit, settings, quantity } = this;
    if (!lit) return [0, 0, 0];
    const factor = hasUnit(quantity) ? conversion(lit.head.unit, settings.unit) : 1;
    const isSpectrum = lit.bands === 3 && settings.band === "all";
    // One band, or the mean of many, is there three times.
    const [r, g, b] = bandWeights(isSpectrum && hasUnit(quantity) ? settings.unit : "", 3);
    return [factor * r, factor * g, factor * b];
  }

  private takePatches(lit: LitScene): void {
    this.lit = lit;
    this.mesh?.geometry.dispose();
    this.mesh?.removeFromParent();
    this.values?.dispose();
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(lit.polygons, 3));
    geometry.setIndex(new THREE.BufferAttribute(triangles(lit.count), 1));
    geometry.boundingSphere = lit.sphere();
    const size = Math.max(geometry.boundingSphere.radius, 1e-6);
    this.camera.near = 2e-4 * size;
    this.camera.far = 40 * size;
    this.camera.updateProjectionMatrix();
    const height = Math.max(1, Math.ceil((4 * lit.count) / WIDTH));
    const data = new Float32Array(4 * WIDTH * height);
    for (let p = 0; p < lit.count; p++) if (lit.isTriangle[p]) for (let i = 3; i < 16; i += 4) data[16 * p + i] = 1;
    this.values = new THREE.DataTexture(data, WIDTH, height, THREE.RGBAFormat, THREE.FloatType);
    this.material.uniforms.values.value = this.values;
    this.mesh = new THREE.Mesh(geometry, this.material);
    this.scene.add(this.mesh);
  }

  /** Puts what is to be seen on the graphics card. */
  private takeValues(): void {
    const { lit, values, settings, quantity } = this;
    if (!lit || !values) return;
    const data = values.image.data as Float32Array;
    const { band, smooth } = settings;
    if (quantity === "patches") [0, 1, 2].forEach((c) => lit.fill(quantity, c, false, data, c, 4));
    else if (band !== "all") {
      lit.fill(quantity, band, smooth, data, 0, 4);
      copyFirst(data);
    } else if (lit.bands === 3) [0, 1, 2].forEach((c) => lit.fill(quantity, c, smooth, data, c, 4));
    else {
      const sum = new Float32Array(4 * lit.count);
      const one = new Float32Array(4 * lit.count);
      for (let b = 0; b < lit.bands; b++) {
        lit.fill(quantity, b, smooth, one, 0, 1);
        for (let i = 0; i < sum.length; i++) sum[i] += one[i] / lit.bands;
      }
      for (let i = 0; i < sum.length; i++) data[4 * i] = sum[i];
      copyFirst(data);
    }
    values.needsUpdate = true;
    this.known = null;
    this.invalidate();
  }

  /** What one part in two hundred of the area exceeds, in the unit shown; of radiosity lamps do not count. */
  private highest(): number {
    const { lit, values, weights } = this;
    if (!lit || !values) return 1;
    const area = this.quantity === "radiosity" ? lit.areaWithoutLamps() : lit.area;
    return top(means(values.image.data as Float32Array, lit.count, weights), area);
  }
}

/** The one number of each patch. */
function means(data: Float32Array, count: number, [r, g, b]: number[]): Float32Array {
  const out = new Float32Array(count);
  for (let p = 0, i = 0; p < count; p++) {
    let sum = 0;
    for (const end = i + 16; i < end; i += 4) sum += r * data[i] + g * data[i + 1] + b * data[i + 2];
    out[p] = sum / 4;
  }
  return out;
}

function copyFirst(data: Float32Array): void {
  for (let i = 0; i < data.length; i += 4) data[i + 1] = data[i + 2] = data[i];
}
