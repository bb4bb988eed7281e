import { describe, expect, test } from "vitest";
import { origins, row, sources, total } from "../src/row";
import { cube, lit, tracer, type Sheet } from "./room";
import type { Point } from "../src/field";

const floor = (half: number): Sheet => ({
  corners: [[-half, 0, half], [half, 0, half], [half, 0, -half], [-half, 0, -half]],
  reflectance: 0.5,
});

/** A rectangle above the origin, looking down, a by b around the axis at a height, cut into k by k. */
function ceiling(a: number, b: number, height: number, k: number, sheet: Partial<Sheet>): Sheet[] {
  return Array.from({ length: k * k }, (_, i) => {
    const [x, z] = [-a / 2 + (a * (i % k)) / k, -b / 2 + (b * Math.floor(i / k)) / k];
    const [w, d] = [a / k, b / k];
    return { corners: [[x, height, z], [x + w, height, z], [x + w, height, z + d], [x, height, z + d]], ...sheet };
  });
}

/** From a point to a parallel rectangle with a corner above it: Howell's catalogue, B-3. */
function corner(a: number, b: number, height: number): number {
  const [x, y] = [a / height, b / height];
  const [p, q] = [Math.sqrt(1 + x * x), Math.sqrt(1 + y * y)];
  return ((x / p) * Math.atan(y / p) + (y / q) * Math.atan(x / q)) / (2 * Math.PI);
}

describe("a row of F", () => {
  // Four corners above the point make a rectangle around it. Independent rays would err by sqrt(F (1 - F) / 4096), up to
  // 8e-3; a sequence of low discrepancy must do better than half as much.
  test.each([[1, 1, 1], [2, 1, 0.5], [0.5, 3, 2]])("of a point below a rectangle %d x %d at %d", (a, b, height) => {
    const scene = lit([floor(3), ...ceiling(a, b, height, 1, {})]);
    const [{ surface, factor }] = sources(scene, row(scene, 0, [0, 0, 0], tracer(scene)));
    expect(surface).toBe(1);
    expect(Math.abs(factor - 4 * corner(a / 2, b / 2, height))).toBeLessThan(3e-3);
  });

  test("of a small lamp is found by area, to one part in a thousand", () => {
    const scene = lit([floor(3), ...ceiling(0.02, 0.02, 2, 2, { emission: [1000] })]);
    const found = sources(scene, row(scene, 0, [0, 0, 0], tracer(scene)));
    const factor = found.reduce((sum, source) => sum + source.factor, 0);
    const irradiance = found.reduce((sum, source) => sum + source.irradiance[0], 0);
    const exact = 4 * corner(0.01, 0.01, 2);
    expect(exact).toBeLessThan(1 / 4096); // rays alone would miss it, or not
    expect(Math.abs(factor / exact - 1)).toBeLessThan(1e-3);
    expect(Math.abs(irradiance / (1000 * exact) - 1)).toBeLessThan(1e-3);
  });

  test("counts lamps once, large or small, cut finely or not", () => {
    for (const k of [1, 4]) {
      const scene = lit([floor(3), ...ceiling(2, 2, 1, k, { emission: [1] })]);
      const made = row(scene, 0, [0, 0, 0], tracer(scene), 8192);
      const sum = total(sources(scene, made).map((source) => source.factor));
      expect(Math.abs(sum - 4 * corner(1, 1, 1))).toBeLessThan(2e-3);
      expect(Math.abs(made.outside + sum - 1)).toBeLessThan(2e-3);
    }
  });

  test("a lamp that is hidden sends nothing", () => {
    const blocker = ceiling(0.2, 0.2, 1, 1, {})[0];
    const scene = lit([floor(3), ...ceiling(0.02, 0.02, 2, 1, { emission: [1000] }), blocker]);
    const found = sources(scene, row(scene, 0, [0, 0, 0], tracer(scene)));
    expect(found.find((source) => source.surface === 1)).toBeUndefined();
    // Its other side does not look here: the point sees a black back.
    expect(row(scene, 0, [0, 0, 0], tracer(scene)).backs).toBeCloseTo(0, 12);
  });

  test("sees nothing in the backs of what looks away", () => {
    const away = ceiling(1, 1, 1, 1, { emission: [5] })[0];
    const scene = lit([floor(3), { ...away, corners: [...away.corners].reverse() }]);
    const made = row(scene, 0, [0, 0, 0], tracer(scene));
    expect(sources(scene, made)).toEqual([]);
    expect(Math.abs(made.backs - 4 * corner(0.5, 0.5, 1))).toBeLessThan(3e-3);
  });

  test("adds up to one in a closed box, and to its light", () => {
    // A furnace: every surface has the radiosity e / (1 - rho) and so has the irradiance of every point.
    const scene = lit(cube(4, () => ({ reflectance: 0.5, emission: [1], irradiance: [2] })));
    const point: Point = [0, 0.3, 0.6];
    const made = row(scene, 5, point, tracer(scene));
    const found = sources(scene, made);
    expect(made.outside).toBe(0);
    // Nearby patches are left to rays, the others are sampled by area: 1,024 samples of a smooth integrand.
    expect(Math.abs(total(found.map((source) => source.factor)) - 1)).toBeLessThan(0.01);
    expect(Math.abs(total(found.map((source) => source.irradiance[0])) - 2)).toBeLessThan(0.02);
  });

  test("stays while light changes, and is the same whenever it is asked", () => {
    const lamp: Sheet = { corners: ceiling(1, 1, 1, 1, {})[0].corners, emission: [1, 0] };
    const other: Sheet = { corners: [[-2, 0, -2], [2, 0, -2], [2, 2, -2], [-2, 2, -2]], emission: [0, 1] };
    const scene = lit([floor(3), lamp, other], 2);
    const made = row(scene, 0, [0, 0, 0], tracer(scene));
    expect(row(scene, 0, [0, 0, 0], tracer(scene))).toEqual(made);
    const before = new Map(sources(scene, made).map((source) => [source.surface, source.irradiance[0]]));
    scene.mix(0, [3]);
    scene.mix(1, [0]);
    const after = new Map(sources(scene, made).map((source) => [source.surface, source.irradiance[0]]));
    expect(after.get(1)).toBeCloseTo(3 * before.get(1)!, 10);
    expect(after.get(2)).toBe(0);
  });

  test("tells where on a surface its light is from, facing by facing", () => {
    const scene = lit(cube(2, (face) => ({ reflectance: 0.5, irradiance: [face === 3 ? 4 : 1] })));
    scene.surface.fill(0);
    const found = origins(scene, row(scene, 8, [0.5, 0, 0.5], tracer(scene)), 12);
    expect(found.length).toBe(5);
    expect(found[0].point[1]).toBeCloseTo(1, 6); // face 3 is the ceiling, y = 1
    expect(Math.hypot(found[0].point[0] - 0.5, found[0].point[2] - 0.5)).toBeLessThan(0.1);
  });
});
