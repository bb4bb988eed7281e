// Lines of light from where it leaves to where it arrives, over the picture: one draw call.

import * as THREE from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import type { Point } from "./field";
import type { Overlay } from "./overlay";

export interface Beam {
  from: Point;
  to: Point;
  /** "#rrggbb" as it is on the screen. */
  colour: string;
  /** Pixels. */
  width: number;
}

/** Pixels of dark on both sides, so that light lines stand out from light walls. */
const HALO = 1.25;

export class Beams {
  private readonly material = widthByLine();
  private lines: LineSegments2 | null = null;

  constructor(private readonly overlay: Overlay) {}

  /** Shows these and no others; the last lie on top. */
  show(beams: Beam[]): void {
    if (this.lines) this.overlay.remove(this.lines);
    this.lines = null;
    if (!beams.length) return;
    this.lines = new LineSegments2(this.geometry(beams), this.material);
    this.lines.frustumCulled = false;
    this.lines.renderOrder = 1;
    this.overlay.add(this.lines);
  }

  private geometry(beams: Beam[]): LineSegmentsGeometry {
    const all = beams.flatMap((beam) => [{ ...beam, colour: "#101114", width: beam.width + 2 * HALO }, beam]);
    const geometry = new LineSegmentsGeometry();
    geometry.setPositions(all.flatMap(({ from, to }) => [...from, ...to]));
    geometry.setColors(all.flatMap(({ colour }) => [...onScreen(colour), ...onScreen(colour)]));
    const widths = Float32Array.from(all, ({ width }) => width);
    geometry.setAttribute("instanceWidth", new THREE.InstancedBufferAttribute(widths, 1));
    return geometry;
  }
}

/** The renderer does not encode, so colours are given as they are shown. */
function onScreen(colour: string): number[] {
  return [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16) / 255);
}

/** The material of fat lines with a width for each. */
function widthByLine(): LineMaterial {
  const material = new LineMaterial({ vertexColors: true, transparent: true, opacity: 0.9, depthTest: false });
  material.vertexShader = material.vertexShader
    .replace("uniform float linewidth;", "attribute float instanceWidth;\n#define linewidth instanceWidth");
  return material;
}
