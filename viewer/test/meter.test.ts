import { expect, test } from "vitest";
import { exposureOf } from "../src/meter";

test("the logarithmic mean of what is not black becomes middle grey, as crates/picture/src/tone.rs has it", () => {
  const pixels = Float32Array.from([0, 1, 4, 16].flatMap((x) => [x, x, x, 1]));
  expect(exposureOf(pixels)).toBeCloseTo(0.18 / 4, 6);
  expect(exposureOf(new Float32Array(16))).toBe(1);
});
