// Walking and flying: where the eyes are after a while of pressing keys. It knows no keys and no pictures.

import { Line3, Vector3 } from "three";
import type { Body } from "./body";
import type { Obstacles } from "./collide";
import { type Compass, type Heading, STEEPEST } from "./compass";

/** Metres per second squared, of a person. */
const GRAVITY = 9.81;

/** Seconds in which the eyes come nearer to where the feet have stepped by a factor of e. */
const EASE = 0.07;

/** How much faster than walking flying is, and being in a hurry. */
const FLYING = 1.5;
const HURRY = 3;

/** Of the radius: the longest way between two looks at what is in the way. */
const STRIDE = 0.5;

/** Looks at most for one picture: who is faster than this goes slower. */
const LOOKS = 64;

/** What is wished, -1 to 1 each. */
export interface Wish {
  ahead: number;
  right: number;
  up: number;
  isFast: boolean;
}

export class Walker {
  readonly eye = new Vector3();
  heading: Heading = { yaw: 0, pitch: 0 };
  /** Without gravity. */
  isFlying = false;
  collides = true;
  /** A factor of the speed. */
  hurry = 1;
  obstacles: Obstacles | null = null;
  /** How far the eyes are from where the feet want them; it is eased away. */
  private offset = 0;
  private falling = 0;
  /** Whether there was a step since the viewpoint was given: before, nobody falls. */
  private hasMoved = false;

  constructor(public compass: Compass, public body: Body) {}

  /** Takes a viewpoint as it is; the feet find the ground with the first step. */
  placeAt(eye: Vector3, direction: Vector3): void {
    this.eye.copy(eye);
    this.heading = this.compass.heading(direction);
    this.offset = this.falling = 0;
    this.hasMoved = false;
  }

  turn(yaw: number, pitch: number): void {
    const { heading } = this;
    this.heading = { yaw: heading.yaw + yaw, pitch: Math.min(Math.max(heading.pitch + pitch, -STEEPEST), STEEPEST) };
  }

  get direction(): Vector3 {
    return this.compass.direction(this.heading);
  }

  /** @returns whether the eyes moved. */
  advance(seconds: number, wish: Wish): boolean {
    const before = this.eye.clone();
    const way = this.way(wish).multiplyScalar(seconds);
    if (way.lengthSq() && !this.hasMoved) this.getUp();
    if (this.isFlying) this.fly(way);
    else if (this.hasMoved) this.walk(way, seconds);
    return !before.equals(this.eye);
  }

  /** Where somebody of this body could stand near a place that is looked at from the eyes; null if nowhere. */
  standNear(): Vector3 | null {
    const { obstacles, eye, body, compass } = this;
    if (!obstacles) return null;
    const ahead = this.direction;
    const sight = Math.min(obstacles.distance(eye, ahead), 1e4 * body.radius);
    const steps = 40;
    for (let k = 0; k <= steps; k++) {
      const place = eye.clone().addScaledVector(ahead, (k / steps) * (sight - 2 * body.radius));
      const ground = obstacles.distance(place, compass.up.clone().negate());
      if (!Number.isFinite(ground)) continue;
      place.addScaledVector(compass.up, body.eye - ground);
      if (obstacles.isFree(this.axis(place), body.radius)) return place;
    }
    return null;
  }

  /** Metres a second. */
  private way({ ahead, right, up, isFast }: Wish): Vector3 {
    const { compass, heading, body, isFlying } = this;
    const forward = isFlying ? this.direction : compass.level(heading.yaw);
    const way = forward.multiplyScalar(ahead).addScaledVector(compass.right(heading.yaw), right);
    if (isFlying) way.addScaledVector(compass.up, up);
    if (way.lengthSq() > 1) way.normalize();
    return way.multiplyScalar(body.speed * this.hurry * (isFast ? HURRY : 1) * (isFlying ? FLYING : 1));
  }

  /** With the first step: whoever looked from lower than the eyes are has the feet below the ground. */
  private getUp(): void {
    const { obstacles, body, eye, compass } = this;
    this.hasMoved = true;
    if (!obstacles || this.isFlying) return;
    const rise = body.eye - obstacles.distance(eye, compass.up.clone().negate(), body.eye);
    const above = eye.clone().addScaledVector(compass.up, rise);
    if (!(rise > 0) || !obstacles.isFree(this.axis(above), body.radius)) return;
    this.offset = -rise;
  }

  private fly(way: Vector3): void {
    const { body, eye } = this;
    this.inStrides(way, (stride) => {
      const ball = new Line3(eye.clone().add(stride), eye.clone().add(stride));
      if (!this.stops || this.obstacles!.push(ball, body.radius, null) || !this.isFree(eye)) eye.copy(ball.start);
    });
  }

  private walk(way: Vector3, seconds: number): void {
    const { body, eye, compass } = this;
    eye.addScaledVector(compass.up, -this.offset);
    this.inStrides(way, (stride) => this.step(stride));
    if (!way.lengthSq()) this.land(eye, 0);
    this.fall(seconds);
    this.offset *= Math.exp(-seconds / EASE);
    if (Math.abs(this.offset) < 1e-3 * body.eye) this.offset = 0;
    eye.addScaledVector(compass.up, this.offset);
  }

  /** One stride on the ground, along walls where they are in the way; none where there is no room. */
  private step(stride: Vector3): void {
    const { eye, body, compass } = this;
    const place = eye.clone().add(stride);
    if (!this.stops) return this.land(place, Infinity);
    const wasFree = this.isFree(eye);
    const axis = this.axis(place);
    const before = axis.start.clone();
    const isFree = this.obstacles!.push(axis, body.radius, compass.up);
    place.add(axis.start.sub(before));
    const rise = this.rise(place);
    if (rise > 0) place.addScaledVector(compass.up, rise);
    if (wasFree && !(isFree && (rise <= 0 || this.isFree(place)))) return;
    this.settle(place, rise);
  }

  /** Puts the feet on the ground below a place, if they can reach it. */
  private land(place: Vector3, reach: number): void {
    const rise = this.rise(place);
    if (rise > 0 && rise <= reach + this.body.step) place.addScaledVector(this.compass.up, rise);
    this.settle(place, rise);
  }

  /** Moves there; the eyes follow the rise of the feet, which is done already if it is upward. */
  private settle(place: Vector3, rise: number): void {
    const { body, compass } = this;
    const isStep = Number.isFinite(rise) && rise >= -body.step && this.falling === 0;
    if (isStep && rise < 0) place.addScaledVector(compass.up, rise);
    if (isStep || rise > 0) this.offset -= rise;
    this.eye.copy(place);
  }

  /** How far the ground is above the feet, metres; minus infinity if there is none. */
  private rise(place: Vector3): number {
    const { obstacles, body, compass } = this;
    if (!obstacles) return 0;
    // From the knees, so that what is climbed is below and what is in the way is not.
    const knees = place.clone().addScaledVector(compass.up, body.step - body.eye);
    return body.step - obstacles.distance(knees, compass.up.clone().negate());
  }

  /** Where there is no ground at all nobody falls: files may have none. */
  private fall(seconds: number): void {
    const { body, eye, compass } = this;
    const depth = -this.rise(eye);
    if (!(depth > 1e-4 * body.eye) || depth === Infinity) {
      this.falling = 0;
      return;
    }
    this.falling += GRAVITY * body.scale * seconds;
    const way = Math.min(this.falling * seconds, depth);
    eye.addScaledVector(compass.up, -way);
    if (way === depth) this.falling = 0;
  }

  /** Parts so short that nothing is passed through. */
  private inStrides(way: Vector3, take: (stride: Vector3) => void): void {
    const length = way.length();
    if (!length) return;
    const longest = STRIDE * this.body.radius;
    const count = this.stops ? Math.min(Math.ceil(length / longest), LOOKS) : 1;
    const stride = way.clone().multiplyScalar(Math.min(1 / count, this.stops ? longest / length : 1));
    for (let k = 0; k < count; k++) take(stride);
  }

  private get stops(): boolean {
    return this.collides && this.obstacles !== null;
  }

  private isFree(eye: Vector3): boolean {
    const { body, isFlying } = this;
    return this.obstacles!.isFree(isFlying ? new Line3(eye, eye) : this.axis(eye), body.radius);
  }

  /** From above what is climbed to the crown. */
  private axis(eye: Vector3): Line3 {
    const { body, compass } = this;
    const top = body.crown - body.radius;
    const bottom = Math.min(body.step + body.radius - body.eye, top);
    const at = (height: number) => eye.clone().addScaledVector(compass.up, height);
    return new Line3(at(bottom), at(top));
  }
}
