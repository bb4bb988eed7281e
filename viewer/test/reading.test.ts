import { expect, test } from "vitest";
import { disagreement, reading } from "../src/reading";
import { row } from "../src/row";
import { cube, lit, tracer } from "./room";

// A furnace: e = 1, rho = 0.5, so B = H = 2 everywhere.
const scene = lit(cube(2, () => ({ reflectance: 0.5, emission: [1], irradiance: [2] })));

test("the probe reads a place, its patch and where its light comes from", () => {
  scene.head.origin = [10, 0, -1];
  const point: [number, number, number] = [0, 0.3, 0.6];
  const found = reading(scene, { patch: 1, point, st: [0.2, 0.6] }, row(scene, 1, point, tracer(scene)));
  expect(found.position).toEqual([10, 0.3, 0.6 - 1]);
  expect([found.surface, found.patch, found.area]).toEqual(["sheet 1", 1, 0.25]);
  expect([found.irradiance[0], found.radiosity[0], found.mean.emission[0]]).toEqual([2, 2, 1]);
  expect(found.relativeError).toBe(0.25); // 0.5 of 2
  expect(found.sources.reduce((sum, { share }) => sum + share, 0)).toBeCloseTo(1, 12);
  expect(Math.abs(disagreement(found))).toBeLessThan(0.01);
  expect([found.outside, found.backs]).toEqual([0, 0]);
});

test("before rays were sent the light is read all the same", () => {
  const found = reading(scene, { patch: 0, point: [0, 0, 0], st: [0, 0] }, null);
  expect(found.sources).toEqual([]);
  expect(found.gathered).toEqual([0]);
  expect(found.irradiance).toEqual([2]);
});
