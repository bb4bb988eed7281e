import { expect, test } from "vitest";
import { QUANTITIES, type Quantity } from "../src/light";
import { cube, lit } from "./room";

const CUBE = cube(2, (face) => ({
  reflectance: 0.1 * face, emission: face === 2 ? [7, 1] : [0, 0], irradiance: [1 + face, 2], field: [1, 2, 3, 4],
}));

/** What the picture is made of agrees with what is said of one patch. */
test.each<Quantity>(QUANTITIES.filter((quantity) => quantity !== "patches"))("fills %s with what patches have", (quantity) => {
  const scene = lit(CUBE, 2);
  scene.mix(1, [0.5]);
  const out = new Float32Array(2 + 12 * scene.count).fill(-1);
  scene.fill(quantity, 0, false, out, 2, 3);
  for (let patch = 0; patch < scene.count; patch++)
    for (let k = 0; k < 4; k++) expect(out[2 + 3 * (4 * patch + k)]).toBeCloseTo(scene.of(patch)[quantity as "error"][0], 5);
  expect(out[0]).toBe(-1);
  expect(out[3]).toBe(-1);
});

test("corners have the field", () => {
  const scene = lit(CUBE, 2);
  scene.mix(1, [0.5]);
  const out = new Float32Array(4 * scene.count);
  scene.fill("radiosity", 0, true, out, 0, 1);
  const corners = [[0, 0], [1, 0], [1, 1], [0, 1]];
  for (let patch = 0; patch < scene.count; patch++)
    corners.forEach(([s, t], k) => expect(out[4 * patch + k]).toBeCloseTo(scene.radiosityAt(patch, s, t)[0], 5));
});

test("lamps do not count in the area where they are few", () => {
  const scene = lit(cube(4, () => ({ reflectance: 0.5, irradiance: [1] })));
  expect(scene.areaWithoutLamps()).toEqual(scene.area);
  const sheets = cube(4, () => ({ reflectance: 0.5, irradiance: [1] }));
  sheets[5].emission = [3];
  expect(lit(sheets).areaWithoutLamps().indexOf(0)).toBe(5);
  const hot = lit(cube(4, () => ({ reflectance: 0.5, irradiance: [1], emission: [3] })));
  expect(hot.areaWithoutLamps()).toEqual(hot.area);
});
