// A smooth way from one viewpoint to another.

import { Quaternion, Vector3 } from "three";

export interface View {
  position: Vector3;
  orientation: Quaternion;
  /** Vertical, radians. */
  angle: number;
}

/** Seconds. */
const LASTS = 0.7;

export class Flight {
  private seconds = 0;

  constructor(private readonly from: View, private readonly to: View) {}

  /** Goes on for a while; where that leads to, and whether it is the end. */
  advance(seconds: number): View & { isEnd: boolean } {
    this.seconds += seconds;
    const t = Math.min(this.seconds / LASTS, 1);
    const s = t * t * (3 - 2 * t);
    const { from, to } = this;
    return {
      position: new Vector3().lerpVectors(from.position, to.position, s),
      orientation: new Quaternion().slerpQuaternions(from.orientation, to.orientation, s),
      angle: from.angle + s * (to.angle - from.angle),
      isEnd: t === 1,
    };
  }
}

/** Whether whoever looks asked for no more motion than needed. */
export function isCalm(): boolean {
  return matchMedia("(prefers-reduced-motion: reduce)").matches;
}
