import { expect, test } from "vitest";
import { roundStep, ticks, top } from "../src/range";

test("one part in two hundred of the area exceeds the top", () => {
  const n = 10_000;
  const values = Float32Array.from({ length: n }, (_, i) => ((i * 7919) % n) + 1); // 1 to n in disorder
  const found = top(values, new Float32Array(n).fill(2));
  expect(found / (0.995 * n)).toBeCloseTo(1, 2.7); // bins are 0.1 % wide
});

test("small bright lamps do not count, and the dark does not either", () => {
  const values = Float32Array.from([0, 0, 10, 10, 5000]);
  expect(top(values, Float32Array.from([50, 50, 1, 1, 0.009])) / 10).toBeCloseTo(1, 2.7);
  expect(top(values, Float32Array.from([50, 50, 1, 1, 0.02])) / 5000).toBeCloseTo(1, 2.7);
});

test("without light the scale ends at one; what is no number is passed over", () => {
  expect(top(new Float32Array(4), new Float32Array(4).fill(1))).toBe(1);
  expect(top(Float32Array.from([NaN, Infinity, 8]), new Float32Array(3).fill(1)) / 8).toBeCloseTo(1, 2.7);
});

test("ticks are round", () => {
  expect(ticks(0, 21.4, false)).toEqual([0, 5, 10, 15, 20]);
  expect(ticks(0, 0.3, false, 3)).toEqual([0, 0.1, 0.2, 0.3]);
  expect(ticks(2, 9, false, 4)).toEqual([2, 4, 6, 8]);
  expect(ticks(0.02, 20, true)).toEqual([0.1, 1, 10]);
  expect(ticks(20, 90, true)).toEqual([20, 30, 50, 70]);
  expect(ticks(3, 3, false)).toEqual([3]);
});

test("steps are 1, 2 or 5 times a power of ten", () => {
  expect([0.13, 1, 2.2, 34, 700].map(roundStep)).toEqual([0.2, 1, 5, 50, 1000]);
});
