// What rays find of the patches: the one place that asks the hierarchy over their triangles.

import * as THREE from "three";
import type { MeshBVH } from "three-mesh-bvh";
import { locate, type Point } from "./field";
import { hierarchy } from "./hierarchy";
import { hierarchyLater } from "./later";
import type { LitScene } from "./light";
import type { Place } from "./reading";
import type { Sight } from "./row";
import type { Stage } from "./stage";

/** Two faces that are this near, relative to the distance, are the front and the back of one sheet. */
const SAME = 1e-5;

export class Rays {
  /** Called when there is a hierarchy over other patches. */
  onReady: () => void = () => {};
  private lit: LitScene | null = null;
  private known: MeshBVH | null = null;
  private making: { of: LitScene; cancel: () => void } | null = null;
  private readonly ray = new THREE.Ray();
  private readonly caster = new THREE.Raycaster();

  constructor(private readonly stage: Stage) {
    stage.afterFrame.push(() => this.begin()); // once the patches are seen
  }

  /** The hierarchy over the patches that are shown, or over those before as long as it is still being made. */
  get tree(): MeshBVH | null {
    return this.known;
  }

  /** What a ray meets first, whichever way that faces; of the two sides of a sheet the one that faces the ray. */
  closest(origin: Point, direction: Point): Sight | null {
    const tree = this.now();
    if (!tree) return null;
    this.ray.origin.set(...origin);
    this.ray.direction.set(...direction);
    const hit = tree.raycastFirst(this.ray, THREE.DoubleSide);
    if (!hit) return null;
    const sight = this.sight(hit, direction);
    if (sight.isFront) return sight;
    const front = tree.raycastFirst(this.ray, THREE.FrontSide, 0, hit.distance * (1 + SAME) + SAME * this.lit!.size);
    return front ? this.sight(front, direction) : sight;
  }

  /**
   * What is seen at a place of the picture, whose backs let the view through.
   *
   * @param x, y pixels from its upper left corner.
   */
  pick(x: number, y: number): Place | null {
    const tree = this.now();
    if (!tree) return null;
    const { clientWidth, clientHeight } = this.stage.renderer.domElement;
    this.stage.camera.updateMatrixWorld();
    this.caster.setFromCamera(new THREE.Vector2((2 * x) / clientWidth - 1, 1 - (2 * y) / clientHeight), this.stage.camera);
    const hit = tree.raycastFirst(this.caster.ray, THREE.FrontSide);
    if (!hit) return null;
    const patch = hit.faceIndex! >> 1;
    const point = hit.point.toArray() as Point;
    return { patch, point, st: locate(this.lit!.polygons, patch, ...point) };
  }

  /** Has the hierarchy made if there is none over these patches. */
  private begin(): void {
    const { lit } = this.stage;
    if (!lit?.count || lit === this.lit || lit === this.making?.of) return;
    this.making?.cancel();
    this.making = { of: lit, cancel: hierarchyLater(lit.polygons, (tree) => this.take(lit, tree)).cancel };
  }

  /** The hierarchy over the patches that are shown, for somebody who cannot wait. */
  now(): MeshBVH | null {
    const { lit } = this.stage;
    if (lit?.count && lit !== this.lit) {
      this.making?.cancel();
      this.take(lit, hierarchy(lit.polygons));
    }
    return lit?.count ? this.known : null;
  }

  private take(lit: LitScene, tree: MeshBVH): void {
    this.making = null;
    this.lit = lit;
    this.known = tree;
    this.onReady();
  }

  private sight(hit: THREE.Intersection, [x, y, z]: Point): Sight {
    const patch = hit.faceIndex! >> 1;
    const { normal } = this.lit!;
    const isFront = x * normal[3 * patch] + y * normal[3 * patch + 1] + z * normal[3 * patch + 2] < 0;
    return { patch, distance: hit.distance, isFront };
  }
}
