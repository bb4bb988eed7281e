import { describe, expect, test } from "vitest";
import { cornerWeights, evenly, locate, pointAt, type Point } from "../src/field";
import { FRAGMENT } from "../src/shaders";
import { lit } from "./room";

const SQUARE: Point[] = [[0, 0, 0], [2, 0, 0], [2, 0, -1], [0, 0, -1]];
const KITE: Point[] = [[0, 0, 0], [2, 0.3, 0], [1.5, 1.4, 0], [-0.2, 1, 0]];
const TRIANGLE: Point[] = [[0, 0, 0], [1, 0, 0], [0.2, 1, 0.5]];

describe("a place on a patch", () => {
  test.each([SQUARE, KITE, TRIANGLE])("is found again", (...corners) => {
    const { polygons, isTriangle } = lit([{ corners }]);
    for (const [s, t] of [[0, 0], [1, 0], [1, 1], [0.7, 0.2], [0.5, 0.5], [0.9, 0.89]]) {
      const found = locate(polygons, 0, ...pointAt(polygons, 0, s, t));
      expect(found[0]).toBeCloseTo(s, 5);
      expect(found[1]).toBeCloseTo(t, 5);
    }
    if (!isTriangle[0]) expect(locate(polygons, 0, ...pointAt(polygons, 0, 0.2, 0.7))[1]).toBeCloseTo(0.7, 5);
  });

  test("beside an edge, by rounding, is on it", () => {
    const { polygons } = lit([{ corners: TRIANGLE }]);
    expect(locate(polygons, 0, -1e-7, 0, 0)).toEqual([0, 0]);
  });

  test("takes areas evenly", () => {
    // The mean of evenly spread points is the centroid; that of a kite by its two triangles.
    const { polygons } = lit([{ corners: KITE }]);
    const mean = [0, 0];
    const n = 64;
    for (let i = 0; i < n * n; i++) {
      const p = pointAt(polygons, 0, ...evenly(polygons, 0, ((i % n) + 0.5) / n, (Math.floor(i / n) + 0.5) / n));
      mean[0] += p[0] / n ** 2;
      mean[1] += p[1] / n ** 2;
    }
    const cross = (a: Point, b: Point) => a[0] * b[1] - a[1] * b[0];
    const [first, second] = [cross(KITE[1], KITE[2]), cross(KITE[2], KITE[3])];
    const centroid = [0, 1].map(
      (k) => (first * (KITE[1][k] + KITE[2][k]) + second * (KITE[2][k] + KITE[3][k])) / 3 / (first + second),
    );
    // Cells along the split and the folds err by half a cell at most, over an edge's length of cells.
    expect(Math.abs(mean[0] - centroid[0])).toBeLessThan(2 / n);
    expect(Math.abs(mean[1] - centroid[1])).toBeLessThan(2 / n);
  });
});

describe("the field at a place", () => {
  /** The weights as the shader writes them: its own expressions, evaluated. */
  const shader = (isTriangle: boolean, s: number, t: number): number[] => {
    const expressions = [...FRAGMENT.matchAll(/[?:] vec4\((.*)\)[;\n]/g)].map((match) => match[1]);
    const text = expressions[isTriangle ? 0 : 1];
    return new Function("at", `return [${text}]`)({ x: s, y: t }) as number[];
  };

  test.each([[0.3, 0.2], [0.9, 0.1], [0.5, 0.5]])("is weighed as the picture weighs it at %d, %d", (s, t) => {
    for (const isTriangle of [true, false])
      cornerWeights(isTriangle, s, t).forEach((w, k) => expect(w).toBeCloseTo(shader(isTriangle, s, t)[k], 12));
  });

  test("is bilinear on quads, linear on triangles", () => {
    const scene = lit([
      { corners: SQUARE, field: [1, 2, 4, 8], reflectance: 0.5, emission: [3] },
      { corners: TRIANGLE, field: [1, 2, 4, 4] },
    ]);
    expect(scene.irradianceAt(0, 0.5, 0.5)[0]).toBeCloseTo(15 / 4, 6);
    expect(scene.radiosityAt(0, 0.5, 0.5)[0]).toBeCloseTo(3 + 15 / 8, 6);
    const third = locate(scene.polygons, 1, 0.4, 1 / 3, 0.5 / 3);
    expect(scene.irradianceAt(1, ...third)[0]).toBeCloseTo(7 / 3, 5);
  });
});
