// Directions where a scene says what is up.

import { Vector3 } from "three";

/** As far up and down as people look: straight up there is no way ahead. */
export const STEEPEST = (89 * Math.PI) / 180;

/** Angles in radians: yaw to the left around `up`, pitch upwards. */
export interface Heading {
  yaw: number;
  pitch: number;
}

export class Compass {
  readonly up: Vector3;
  readonly east: Vector3;
  readonly north: Vector3;

  constructor([x, y, z]: [number, number, number]) {
    this.up = new Vector3(x, y, z).normalize();
    if (!this.up.lengthSq()) this.up.set(0, 1, 0);
    // Any level direction would do; this is -z where y is up, and y where z is.
    const { up } = this;
    const ahead = Math.abs(up.z) < 0.9 ? new Vector3(0, 0, -1) : new Vector3(0, 1, 0);
    this.north = ahead.addScaledVector(up, -ahead.dot(up)).normalize();
    this.east = new Vector3().crossVectors(this.north, up);
  }

  /** The way of a heading. */
  direction({ yaw, pitch }: Heading): Vector3 {
    return this.level(yaw).multiplyScalar(Math.cos(pitch)).addScaledVector(this.up, Math.sin(pitch));
  }

  /** The same without looking up or down. */
  level(yaw: number): Vector3 {
    return new Vector3().addScaledVector(this.north, Math.cos(yaw)).addScaledVector(this.east, -Math.sin(yaw));
  }

  /** What is to the right of a heading. */
  right(yaw: number): Vector3 {
    return new Vector3().addScaledVector(this.east, Math.cos(yaw)).addScaledVector(this.north, Math.sin(yaw));
  }

  heading(direction: Vector3): Heading {
    const way = direction.clone().normalize();
    const pitch = Math.asin(Math.min(Math.max(way.dot(this.up), -1), 1));
    return {
      yaw: Math.atan2(-way.dot(this.east), way.dot(this.north)),
      pitch: Math.min(Math.max(pitch, -STEEPEST), STEEPEST),
    };
  }

  /** How high a point is. */
  height(point: Vector3): number {
    return point.dot(this.up);
  }
}
