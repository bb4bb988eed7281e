// Draws the patches. It owns the renderer, the camera and the values on the graphics card; it knows no panels.

import * as THREE from "three";
import type { CameraHead } from "./messages";
import type { LitScene } from "./light";
import { FRAGMENT, LOOK, VERTEX } from "./shaders";
import { DEFAULTS, type Settings } from "./settings";
import { CURVES, KEY, luminance, table } from "./tone";

/** Texels in a row of values. */
const WIDTH = 4096;

/** Pixels on a side of the picture that automatic exposure measures. */
const METER = 48;

export class Stage {
  readonly renderer: THREE.WebGLRenderer;
  readonly camera = new THREE.PerspectiveCamera(50, 1, 0.01, 1000);
  readonly scene = new THREE.Scene();
  settings: Settings = { ...DEFAULTS };
  lit: LitScene | null = null;
  mesh: THREE.Mesh<THREE.BufferGeometry, THREE.RawShaderMaterial> | null = null;
  /** What multiplies values before the tone curve. */
  exposure = 1;
  /** First and last value of the colour scale, and the values of the picture it was made for. */
  range: [number, number] = [0, 1];
  /** Called before each picture, with seconds since the last; returns whether it changed anything. */
  readonly beforeFrame: ((seconds: number) => boolean)[] = [];
  /** Called after each picture. */
  readonly afterFrame: (() => void)[] = [];

  private values: THREE.DataTexture | null = null;
  private readonly colours = new THREE.DataTexture(table("viridis"), 256, 1);
  private readonly meter = new THREE.WebGLRenderTarget(METER, METER, { type: THREE.FloatType });
  private readonly material: THREE.RawShaderMaterial;
  private isStale = true;
  private last = performance.now();

  constructor(canvas: HTMLCanvasElement) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, powerPreference: "high-performance" });
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace; // the shader encodes by itself
    this.scene.background = new THREE.Color(0x101114);
    this.colours.minFilter = this.colours.magFilter = THREE.LinearFilter;
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
        weights: { value: new THREE.Vector3(1 / 3, 1 / 3, 1 / 3) },
        scale: { value: new THREE.Vector3(0, 1, 0) },
        isolines: { value: 0 },
        mesh: { value: 0 },
        chosen: { value: new THREE.Vector2(-1, 0) },
      },
    });
    this.renderer.setAnimationLoop(() => this.frame());
  }

  /** Shows other patches, or the same with other light if they are. */
  show(lit: LitScene): void {
    if (this.lit !== lit) this.takePatches(lit);
    this.takeValues();
  }

  /** Shows the same in another way. */
  set(change: Partial<Settings>): void {
    const before = this.settings;
    this.settings = { ...before, ...change };
    const { quantity, band, smooth, map, unit } = this.settings;
    if (map !== before.map) {
      (this.colours.image.data as Uint8Array).set(table(map));
      this.colours.needsUpdate = true;
    }
    if (quantity !== before.quantity || band !== before.band || smooth !== before.smooth || unit !== before.unit)
      this.takeValues();
    this.invalidate();
  }

  /** Has a picture drawn soon. */
  invalidate(): void {
    this.isStale = true;
  }

  lookThrough(camera: CameraHead): void {
    this.camera.position.set(...camera.position);
    this.camera.up.set(...camera.up);
    this.camera.lookAt(this.camera.position.clone().add(new THREE.Vector3(...camera.forward)));
    this.camera.fov = THREE.MathUtils.radToDeg(camera.vertical_fov);
    this.camera.updateProjectionMatrix();
    this.invalidate();
  }

  resize(width: number, height: number): void {
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / Math.max(height, 1);
    this.camera.updateProjectionMatrix();
    this.invalidate();
  }

  /** Marks a patch; -1 marks none. */
  mark(patch: number, percent = 50): void {
    this.material.uniforms.chosen.value.set(patch, percent);
    this.invalidate();
  }

  /** Draws now if anything changed. */
  private frame(): void {
    const now = performance.now();
    const seconds = Math.min((now - this.last) / 1000, 0.1);
    this.last = now;
    for (const before of this.beforeFrame) if (before(seconds)) this.isStale = true;
    if (!this.isStale) return;
    this.isStale = false;
    this.draw();
    this.afterFrame.forEach((after) => after());
  }

  /** Draws now. */
  draw(): void {
    const { settings, material } = this;
    const u = material.uniforms;
    if (settings.isExposureAutomatic && settings.quantity !== "patches") this.measure();
    else this.exposure = 2 ** settings.exposure * this.radianceScale;
    const isPlain = settings.quantity === "patches" || (settings.quantity === "reflectance" && !settings.falseColours);
    u.look.value = isPlain ? LOOK.plain : settings.falseColours ? LOOK.falseColours : LOOK.developed;
    u.curve.value = CURVES.indexOf(settings.curve);
    u.exposure.value = this.exposure;
    u.scale.value.set(...(settings.range ?? this.range), settings.isLogarithmic ? 1 : 0);
    u.isolines.value = settings.isolines && !isPlain ? this.isolineStep : 0;
    u.mesh.value = settings.mesh ? 0.35 : 0;
    this.renderer.render(this.scene, this.camera);
  }

  /** Radiosity is shown as radiance; exposure in stops counts on that. */
  private get radianceScale(): number {
    return this.settings.quantity === "radiosity" ? 1 / Math.PI : 1;
  }

  /** The distance of two isolines: a round number that makes some ten of them; decades if logarithmic. */
  get isolineStep(): number {
    if (this.settings.isLogarithmic) return 0.25;
    const [low, high] = this.settings.range ?? this.range;
    const rough = (high - low) / 10;
    const decade = 10 ** Math.floor(Math.log10(rough || 1));
    return decade * ([1, 2, 5, 10].find((step) => step * decade >= rough * 0.999) ?? 10);
  }

  private takePatches(lit: LitScene): void {
    this.lit = lit;
    this.mesh?.geometry.dispose();
    this.mesh?.removeFromParent();
    this.values?.dispose();
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(lit.polygons, 3));
    const index = new Uint32Array(6 * lit.count);
    for (let patch = 0; patch < lit.count; patch++)
      for (let k = 0; k < 6; k++) index[6 * patch + k] = 4 * patch + [0, 1, 2, 0, 2, 3][k];
    geometry.setIndex(new THREE.BufferAttribute(index, 1));
    geometry.computeBoundingSphere();
    const size = Math.max(geometry.boundingSphere!.radius, 1e-6);
    this.camera.near = 2e-4 * size;
    this.camera.far = 40 * size;
    this.camera.updateProjectionMatrix();
    const height = Math.max(1, Math.ceil((4 * lit.count) / WIDTH));
    const data = new Float32Array(4 * WIDTH * height);
    for (let i = 0; i < 4 * lit.count; i++) data[4 * i + 3] = lit.isTriangle[i >> 2];
    this.values = new THREE.DataTexture(data, WIDTH, height, THREE.RGBAFormat, THREE.FloatType);
    this.material.uniforms.values.value = this.values;
    this.mesh = new THREE.Mesh(geometry, this.material);
    this.scene.add(this.mesh);
  }

  /** Puts what is to be seen on the graphics card. */
  private takeValues(): void {
    const { lit, values, settings } = this;
    if (!lit || !values) return;
    const data = values.image.data as Float32Array;
    const { quantity, band, smooth } = settings;
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
    this.range = this.automaticRange(data);
    this.invalidate();
  }

  /** From zero to what one part in two hundred of the area exceeds. */
  private automaticRange(data: Float32Array): [number, number] {
    const lit = this.lit!;
    const weights = this.material.uniforms.weights.value as THREE.Vector3;
    const value = Float32Array.from({ length: lit.count }, (_, p) => {
      let sum = 0;
      for (let i = 16 * p; i < 16 * p + 16; i += 4)
        sum += weights.x * data[i] + weights.y * data[i + 1] + weights.z * data[i + 2];
      return sum / 4;
    });
    const order = Uint32Array.from(value.keys()).sort((a, b) => value[b] - value[a]);
    let left = 0.005 * order.reduce((sum, p) => sum + (value[p] > 0 ? lit.area[p] : 0), 0);
    const top = order.find((p) => (left -= lit.area[p]) < 0);
    const high = top === undefined ? 1 : value[top] || 1;
    return [this.settings.isLogarithmic ? 1e-3 * high : 0, high];
  }

  /** Exposes for a mean of middle grey of what the camera sees: the logarithmic mean of what is not black. */
  private measure(): void {
    const { material, renderer } = this;
    material.uniforms.look.value = LOOK.linear;
    material.uniforms.mesh.value = 0;
    const background = this.scene.background;
    this.scene.background = null;
    const target = renderer.getRenderTarget();
    renderer.setRenderTarget(this.meter);
    renderer.setClearColor(0, 0);
    renderer.clear();
    renderer.render(this.scene, this.camera);
    const pixels = new Float32Array(4 * METER * METER);
    renderer.readRenderTargetPixels(this.meter, 0, 0, METER, METER, pixels);
    renderer.setRenderTarget(target);
    this.scene.background = background;
    let sum = 0;
    let count = 0;
    for (let i = 0; i < pixels.length; i += 4) {
      const l = luminance(pixels.subarray(i, i + 3));
      if (l > 0 && Number.isFinite(l)) {
        sum += Math.log(l);
        count++;
      }
    }
    this.exposure = count ? KEY / Math.exp(sum / count) : 1;
  }
}

function copyFirst(data: Float32Array): void {
  for (let i = 0; i < data.length; i += 4) data[i + 1] = data[i + 2] = data[i];
}
