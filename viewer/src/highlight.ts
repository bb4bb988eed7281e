// A surface that stands out from the others.

import * as THREE from "three";
import type { LitScene } from "./light";
import type { Overlay } from "./overlay";

export class Highlight {
  private readonly material = new THREE.MeshBasicMaterial({
    color: new THREE.Color().setHex(0xff9a1f, THREE.LinearSRGBColorSpace), // as it is on the screen
    transparent: true, opacity: 0.4, depthWrite: false, polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -1,
  });
  private mesh: THREE.Mesh | null = null;

  constructor(private readonly overlay: Overlay) {}

  /** Marks all patches of a surface, and of none if it is null. */
  show(lit: LitScene | null, surface: number | null): void {
    if (this.mesh) this.overlay.remove(this.mesh);
    this.mesh = null;
    if (!lit || surface === null) return;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(corners(lit, surface), 3));
    this.mesh = new THREE.Mesh(geometry, this.material);
    this.mesh.frustumCulled = false;
    this.overlay.add(this.mesh);
  }
}

/** Two triangles a patch. */
function corners({ polygons, surface }: LitScene, which: number): Float32Array {
  const out = new Float32Array(18 * surface.reduce((count, s) => count + (s === which ? 1 : 0), 0));
  let at = 0;
  surface.forEach((s, patch) => {
    if (s !== which) return;
    for (const corner of [0, 1, 2, 0, 2, 3]) {
      const from = 12 * patch + 3 * corner;
      out.set(polygons.subarray(from, from + 3), at);
      at += 3;
    }
  });
  return out;
}
