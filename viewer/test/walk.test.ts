import { Vector3 } from "three";
import { expect, test } from "vitest";
import { bodyFor, remark } from "../src/body";
import { Obstacles } from "../src/collide";
import { Compass } from "../src/compass";
import type { Point } from "../src/field";
import { hierarchy } from "../src/hierarchy";
import { Walker, type Wish } from "../src/walk";

const AHEAD: Wish = { ahead: 1, right: 0, up: 0, isFast: false };

/** The six faces of a block, seen from outside. */
function block([x0, y0, z0]: Point, [x1, y1, z1]: Point): Point[][] {
  return [
    [[x0, y1, z0], [x0, y1, z1], [x1, y1, z1], [x1, y1, z0]],
    [[x0, y0, z0], [x1, y0, z0], [x1, y0, z1], [x0, y0, z1]],
    [[x0, y0, z0], [x0, y0, z1], [x0, y1, z1], [x0, y1, z0]],
    [[x1, y0, z0], [x1, y1, z0], [x1, y1, z1], [x1, y0, z1]],
    [[x0, y0, z0], [x0, y1, z0], [x1, y1, z0], [x1, y0, z0]],
    [[x0, y0, z1], [x1, y0, z1], [x1, y1, z1], [x0, y1, z1]],
  ];
}

const FLOOR: Point[] = [[-5, 0, -5], [-5, 0, 5], [5, 0, 5], [5, 0, -5]];

/** Somebody at the middle of a floor of 10 m x 10 m, who looks along -z. */
function walker(...blocks: Point[][][]): Walker {
  const polygons = Float32Array.from([FLOOR, ...blocks.flat()].flat(2));
  const walker = new Walker(new Compass([0, 1, 0]), bodyFor(2.5, 10));
  walker.obstacles = new Obstacles(hierarchy(polygons));
  walker.placeAt(new Vector3(0, 1.65, 0), new Vector3(0, 0, -1));
  return walker;
}

function walk(who: Walker, seconds: number, wish = AHEAD): Vector3 {
  for (let k = 0; k < 60 * seconds; k++) who.advance(1 / 60, wish);
  return who.eye;
}

test("a person walks at 1.6 m/s on the ground", () => {
  const eye = walk(walker(), 2);
  expect(eye.z).toBeCloseTo(-3.2, 5);
  expect(eye.y).toBeCloseTo(1.65, 4);
});

test.each([["front", -2], ["back", -2.2]])("the %s of a wall stops at the radius of the body", (side, z) => {
  const corners: Point[] = [[-5, 0, z], [5, 0, z], [5, 3, z], [-5, 3, z]];
  const eye = walk(walker([side === "front" ? corners : corners.reverse()]), 4);
  expect(eye.z).toBeCloseTo(z + 0.22, 1);
  expect(eye.z).toBeGreaterThan(z + 0.2);
});

test("a person in a hurry does not pass through either, however slow the pictures come", () => {
  const who = walker(block([-5, 0, -2.2], [5, 3, -2]));
  for (let k = 0; k < 40; k++) who.advance(0.1, { ...AHEAD, isFast: true });
  expect(who.eye.z).toBeGreaterThan(-1.8);
});

test("walls turn the way aside", () => {
  const who = walker(block([-5, 0, -2.2], [5, 3, -2]));
  who.heading = { yaw: Math.PI / 4, pitch: 0 };
  const eye = walk(who, 3);
  expect(eye.z).toBeGreaterThan(-1.8);
  // Half the way is along x, at 1.6 / sqrt(2) m/s, until the end of the floor, where the wall ends too.
  expect(eye.x).toBeCloseTo((-3 * 1.6) / Math.SQRT2, 1);
});

test("steps of 0.3 m are climbed, and left again; tables of 0.7 m are not", () => {
  const steps = walker(block([-5, 0, -3], [5, 0.3, -1]));
  expect(walk(steps, 1.2).y).toBeCloseTo(1.95, 2);
  expect(walk(steps, 1.2).y).toBeCloseTo(1.65, 2);
  const table = walker(block([-5, 0.65, -3], [5, 0.7, -1]));
  expect(walk(table, 3).z).toBeGreaterThan(-0.8);
  expect(table.eye.y).toBeCloseTo(1.65, 3);
});

test("a step below a ceiling that is too low is not taken", () => {
  const who = walker(block([-5, 0, -3], [5, 0.3, -1]), block([-5, 1.9, -3], [5, 2, -1]));
  expect(walk(who, 3).z).toBeGreaterThan(-1.3);
});

test("whoever steps over an edge falls, and lands", () => {
  const who = walker(block([-1, 0, -1], [1, 1.5, 1]));
  who.placeAt(new Vector3(0, 3.15, 0), new Vector3(0, 0, -1));
  expect(walk(who, 0.2).y).toBeCloseTo(3.15, 3);
  walk(who, 0.6);
  expect(who.eye.y).toBeLessThan(3.1);
  expect(walk(who, 1).y).toBeCloseTo(1.65, 3);
});

test("nobody falls where there is no ground, or before the first step", () => {
  const who = walker();
  who.placeAt(new Vector3(0, 3, 0), new Vector3(0, 0, -1));
  expect(walk(who, 1, { ...AHEAD, ahead: 0 }).y).toBe(3);
  who.placeAt(new Vector3(20, 3, 0), new Vector3(0, 0, -1));
  expect(walk(who, 1).y).toBe(3);
});

test("whoever looked from near the ground gets up to walk", () => {
  const who = walker(block([-5, 0, -2.2], [5, 3, -2]));
  who.placeAt(new Vector3(0, 0.8, 0), new Vector3(0, 0, -1));
  who.advance(1 / 60, AHEAD);
  expect(who.eye.y).toBeGreaterThan(0.8); // and not at once
  expect(who.eye.y).toBeLessThan(1.2);
  const eye = walk(who, 3);
  expect(eye.y).toBeCloseTo(1.65, 3);
  expect(eye.z).toBeGreaterThan(-1.8);
});

test("flying goes where it looks, and stops above the ground", () => {
  const who = walker();
  who.isFlying = true;
  who.heading = { yaw: 0, pitch: -Math.PI / 4 };
  expect(walk(who, 2.5).y).toBeGreaterThan(0.21);
  who.collides = false;
  expect(walk(who, 2.5).y).toBeLessThan(-1);
});

test("z may be up", () => {
  const compass = new Compass([0, 0, 1]);
  expect(compass.north.toArray()).toEqual([0, 1, 0]);
  expect(compass.right(0).toArray()).toEqual([1, 0, 0]);
  const direction = new Vector3(0.3, -0.5, 0.2).normalize();
  expect(compass.direction(compass.heading(direction)).distanceTo(direction)).toBeLessThan(1e-12);
});

test("bodies fit scenes, and say so where they are no person's", () => {
  expect(bodyFor(2.5, 6)).toMatchObject({ scale: 1, eye: 1.65, step: 0.4 });
  expect(remark(bodyFor(2.5, 6))).toBe("");
  const box = bodyFor(0.55, 0.56); // the Cornell box
  expect(box.eye).toBeCloseTo(0.4125, 10);
  expect(remark(box)).toBe("This scene is too small to stand in, so you are 1 : 4 of a person.");
  expect(remark(bodyFor(300, 4000))).toContain("4 times as large");
});
