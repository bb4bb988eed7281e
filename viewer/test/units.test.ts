import { expect, test } from "vitest";
import { bandWeights, conversion, EFFICACY, scalar, unitOf } from "../src/units";

test("a watt of white is 179 lumens, and the other way round", () => {
  expect(conversion("W/m2", "lux")).toBe(EFFICACY);
  expect(conversion("lux", "lux")).toBe(1);
  expect(conversion("lux", "W/m2") * EFFICACY).toBeCloseTo(1, 12);
  expect(scalar("lux", [1, 1, 1])).toBeCloseTo(1, 12);
});

test("brightness is green above all; other bands count alike", () => {
  expect(scalar("lux", [0, 1, 0])).toBe(0.67);
  expect(scalar("W/m2", [3, 0, 0])).toBe(1);
  expect(bandWeights("lux", 2)).toEqual([0.5, 0.5]);
});

test("light that leaves is not in lux", () => {
  expect(unitOf("irradiance", "lux")).toBe("lux");
  expect(unitOf("radiosity", "lux")).toBe("lm/m²");
  expect(unitOf("error", "W/m2")).toBe("W/m²");
  expect(unitOf("reflectance", "lux")).toBe("");
});
