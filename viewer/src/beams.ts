// Lines of light from where it leaves to where it arrives, over the picture: one draw call.

import * as THREE from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import type { Point } from "./field";
import type { Stage } from "./stage";

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
  private readonly scene = new THREE.Scene();
  private readonly material = widthByLine();
  private lines: LineSegments2 | null = null;

  constructor(private readonly stage: Stage) {
    // A picture of its own, so that what measures or saves the picture below sees light alone.
    stage.afterFrame.push(() => this.draw());
  }

  /** Shows these and no others; the last lie on top. */
  show(beams: Beam[]): void {
    this.lines?.removeFromParent();
    this.lines?.geometry.dispose();
    this.lines = beams.length ? new LineSegments2(this.geometry(beams), this.material) : null;
    if (this.lines) {
      this.lines.frustumCulled = false;
      this.scene.add(this.lines);
    }
    this.stage.invalidate();
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

  private draw(): void {
    if (!this.lines) return;
    const { renderer, camera } = this.stage;
    renderer.autoClear = false;
    renderer.render(this.scene, camera);
    renderer.autoClear = true;
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
