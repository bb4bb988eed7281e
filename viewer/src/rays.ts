// What rays find of the patches: the one place that asks the hierarchy over their triangles.

import * as THREE from "three";
import { MeshBVH } from "three-mesh-bvh";
import { locate, type Point } from "./field";
import type { LitScene } from "./light";
import type { Place } from "./reading";
import type { Sight } from "./row";
import type { Stage } from "./stage";

/** Two faces that are this near, relative to the distance, are the front and the back of one sheet. */
const SAME = 1e-5;

export class Rays {
  private lit: LitScene | null = null;
  private tree: MeshBVH | null = null;
  private readonly ray = new THREE.Ray();
  private readonly caster = new THREE.Raycaster();

  constructor(private readonly stage: Stage) {}

  /** What a ray meets first, whichever way that faces; of the two sides of a sheet the one that faces the ray. */
  closest(origin: Point, direction: Point): Sight | null {
    const tree = this.hierarchy();
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
    const tree = this.hierarchy();
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

  /** The hierarchy over the patches that are shown, made when somebody first asks. */
  private hierarchy(): MeshBVH | null {
    const { lit, mesh } = this.stage;
    if (lit !== this.lit) {
      this.lit = lit;
      // Indirect: the order of the triangles stays, so that their numbers tell the patch.
      this.tree = mesh && new MeshBVH(mesh.geometry, { indirect: true });
    }
    return this.tree;
  }

  private sight(hit: THREE.Intersection, [x, y, z]: Point): Sight {
    const patch = hit.faceIndex! >> 1;
    const { normal } = this.lit!;
    const isFront = x * normal[3 * patch] + y * normal[3 * patch + 1] + z * normal[3 * patch + 2] < 0;
    return { patch, distance: hit.distance, isFront };
  }
}
