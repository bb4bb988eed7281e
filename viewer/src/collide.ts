// What stops whoever walks: triangles, from both sides.

import { type Box3, type Line3, Ray, Vector3 } from "three";
import type { ExtendedTriangle, MeshBVH } from "three-mesh-bvh";

/** Of the radius: as deep as this into a wall does not count. */
const SLACK = 0.02;

/** Pushes until nothing is in the way, at most. */
const ROUNDS = 4;

const BOTH_SIDES = 2; // THREE.DoubleSide

export class Obstacles {
  private readonly ray = new Ray();
  private readonly onTriangle = new Vector3();
  private readonly onAxis = new Vector3();

  constructor(private readonly tree: MeshBVH) {}

  /** Metres to what lies in a direction, which is unit; infinite if nothing does within `far`. */
  distance(from: Vector3, direction: Vector3, far = Infinity): number {
    this.ray.origin.copy(from);
    this.ray.direction.copy(direction);
    return this.tree.raycastFirst(this.ray, BOTH_SIDES, 0, far)?.distance ?? Infinity;
  }

  /**
   * Moves a capsule out of what it is in, sideways of `level` only if that is given.
   *
   * @param axis from the middle of one end to that of the other; is moved.
   * @returns whether it is free then.
   */
  push(axis: Line3, radius: number, level: Vector3 | null): boolean {
    for (let round = 0; round < ROUNDS; round++) {
      const isFree = this.pushOnce(axis, radius, level);
      if (isFree) return true;
    }
    return this.isFree(axis, radius);
  }

  isFree(axis: Line3, radius: number): boolean {
    return !this.visit(axis, radius, (depth) => depth > SLACK * radius);
  }

  private pushOnce(axis: Line3, radius: number, level: Vector3 | null): boolean {
    let isFree = true;
    this.visit(axis, radius, (depth, away) => {
      if (depth > SLACK * radius) isFree = false;
      if (level) away.addScaledVector(level, -away.dot(level));
      axis.start.addScaledVector(away, depth);
      axis.end.addScaledVector(away, depth);
      return false;
    });
    return isFree;
  }

  /**
   * Calls with how deep the capsule is in each triangle and the unit direction out of it, until that returns true.
   *
   * @returns whether it did.
   */
  private visit(axis: Line3, radius: number, touch: (depth: number, away: Vector3) => boolean): boolean {
    const { onTriangle, onAxis } = this;
    return this.tree.shapecast({
      intersectsBounds: (box: Box3) => reaches(box, axis, radius),
      intersectsTriangle: (triangle: ExtendedTriangle) => {
        if (!(triangle.getArea() > 0)) return false; // the second half of a triangular patch
        const distance = triangle.closestPointToSegment(axis, onTriangle, onAxis);
        // Steps are shorter than the radius, so the axis itself is in nothing, unless the way began there.
        if (!(distance < radius) || distance === 0) return false;
        return touch(radius - distance, onAxis.sub(onTriangle).divideScalar(distance));
      },
    });
  }
}

/** Whether a box may be within the radius of an axis. */
function reaches({ min, max }: Box3, { start, end }: Line3, radius: number): boolean {
  return (
    Math.min(start.x, end.x) - radius <= max.x && Math.max(start.x, end.x) + radius >= min.x &&
    Math.min(start.y, end.y) - radius <= max.y && Math.max(start.y, end.y) + radius >= min.y &&
    Math.min(start.z, end.z) - radius <= max.z && Math.max(start.z, end.z) + radius >= min.z
  );
}
