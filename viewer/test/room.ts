// Scenes for tests, as packets have them, and a tracer that tests every triangle.

import type { Point } from "../src/field";
import { LitScene } from "../src/light";
import type { LampHead, SceneHead } from "../src/messages";
import { Packet } from "../src/packet";
import type { Closest, Sight } from "../src/row";

export interface Sheet {
  /** Three or four corners; the normal follows the right hand rule. */
  corners: Point[];
  reflectance?: number;
  /** One value a layer. */
  emission?: number[];
  /** One value a layer. */
  irradiance?: number[];
  /** As `irradiance`, at the corners, of every layer. */
  field?: number[];
}

/** A scene of one band and a surface a sheet. */
export function lit(sheets: Sheet[], layers = 1, bands = 1, lamps: LampHead[] = []): LitScene {
  return new LitScene(packet(sheets, layers, bands, lamps));
}

export function packet(sheets: Sheet[], layers = 1, bands = 1, lamps: LampHead[] = []): Packet {
  const n = sheets.length;
  const spread = (per: number, value: (layer: number, sheet: Sheet, k: number) => number) =>
    Float32Array.from({ length: layers * n * per * bands }, (_, i) => {
      const row = Math.floor(i / bands);
      return value(Math.floor(row / (n * per)), sheets[Math.floor(row / per) % n], row % per);
    });
  const head: SceneHead = {
    version: 1, title: "test", bands: Array.from({ length: bands }, (_, b) => "RGBX"[b]), unit: "W/m2",
    origin: [0, 0, 0], up: [0, 1, 0], lamps, cameras: [], is_layered: layers > 1, is_lit: true, is_field: false,
    report: {}, type: "scene",
    surfaces: sheets.map((sheet, k) => ({
      name: `sheet ${k}`, material: "", reflectance: Array(bands).fill(sheet.reflectance ?? 0),
      emission: Array(bands).fill(sheet.emission?.[0] ?? 0), area: 1,
    })),
  };
  const polygons = Float32Array.from(sheets.flatMap(({ corners: [a, b, c, d] }) => [a, b, c, d ?? c].flat()));
  const array = (shape: number[], numbers: Float32Array | Uint32Array) => ({ shape, numbers });
  return new Packet(head, {
    polygons: array([n, 4, 3], polygons),
    surface: array([n], Uint32Array.from(sheets.keys())),
    emission: array([layers, n, bands], spread(1, (l, s) => s.emission?.[l] ?? 0)),
    irradiance: array([layers, n, bands], spread(1, (l, s) => s.irradiance?.[l] ?? 0)),
    corner_irradiance: array([layers, n, 4, bands], spread(4, (l, s, k) => s.field?.[k] ?? s.irradiance?.[l] ?? 0)),
    error: array([n, bands], new Float32Array(n * bands).fill(0.5)),
  });
}

/** The six faces of the unit cube, each cut into k x k, looking inward. */
export function cube(k: number, change: (face: number) => Partial<Sheet> = () => ({})): Sheet[] {
  const sheets: Sheet[] = [];
  for (let face = 0; face < 6; face++) {
    const axis = face >> 1;
    const isHigh = face & 1;
    const at = (u: number, v: number): Point => {
      const p: Point = [0, 0, 0];
      p[axis] = isHigh;
      [p[(axis + 1) % 3], p[(axis + 2) % 3]] = [u / k, v / k];
      return p;
    };
    for (let i = 0; i < k; i++)
      for (let j = 0; j < k; j++) {
        const corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        sheets.push({ corners: isHigh ? corners.reverse() : corners, ...change(face) });
      }
  }
  return sheets;
}

/** Tests every triangle: Moeller and Trumbore 1997. Of two that coincide the front is what is found. */
export function tracer({ polygons, count, normal, isTriangle }: LitScene): Closest {
  const triangles: { patch: number; corner: Point; e: Point; f: Point }[] = [];
  for (let patch = 0; patch < count; patch++) {
    const corners = [0, 3, 6, 9].map((k) => [...polygons.subarray(12 * patch + k, 12 * patch + k + 3)] as Point);
    for (const [i, j] of isTriangle[patch] ? [[1, 2]] : [[1, 2], [2, 3]])
      triangles.push({ patch, corner: corners[0], e: minus(corners[i], corners[0]), f: minus(corners[j], corners[0]) });
  }
  return (origin, direction) => {
    let best: Sight | null = null;
    for (const { patch, corner, e, f } of triangles) {
      const p = cross(direction, f);
      const determinant = dot(e, p);
      if (Math.abs(determinant) < 1e-14) continue;
      const from = minus(origin, corner);
      const q = cross(from, e);
      const u = dot(from, p) / determinant;
      const v = dot(direction, q) / determinant;
      const distance = dot(f, q) / determinant;
      if (u < 0 || v < 0 || u + v > 1 || distance <= 0 || distance > (best?.distance ?? Infinity) + 1e-9) continue;
      const isFront = dot(direction, [normal[3 * patch], normal[3 * patch + 1], normal[3 * patch + 2]]) < 0;
      if (!best || distance < best.distance - 1e-9 || isFront) best = { patch, distance, isFront };
    }
    return best;
  };
}

function minus(a: Point, b: Point): Point {
  return [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
}

function cross(a: Point, b: Point): Point {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

function dot(a: Point, b: Point): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
