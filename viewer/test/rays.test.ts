import * as THREE from "three";
import { expect, test } from "vitest";
import type { Point } from "../src/field";
import type { LitScene } from "../src/light";
import { Rays } from "../src/rays";
import type { Stage } from "../src/stage";
import { cube, lit, tracer } from "./room";

/** What rays need of a stage: the patches as triangles. */
function stage(scene: LitScene): Stage {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(scene.polygons, 3));
  geometry.setIndex(Array.from({ length: 6 * scene.count }, (_, i) => 4 * Math.floor(i / 6) + [0, 1, 2, 0, 2, 3][i % 6]));
  return { lit: scene, mesh: new THREE.Mesh(geometry), afterFrame: [] } as unknown as Stage;
}

test("rays find what testing every triangle finds", () => {
  const scene = lit([...cube(3), { corners: [[0.2, 0.4, 0.2], [0.8, 0.5, 0.3], [0.4, 0.6, 0.9]] }]);
  const rays = new Rays(stage(scene));
  const slow = tracer(scene);
  for (let i = 0; i < 500; i++) {
    const origin = [1, 2, 3].map((k) => 0.1 + 0.8 * ((i * 0.618 * k * k) % 1)) as Point;
    const to = [1, 2, 3].map((k) => ((i * 0.7548 * k + 0.3 * k) % 1) - 0.5);
    const direction = to.map((x) => x / Math.hypot(...to)) as Point;
    const [found, wanted] = [rays.closest(origin, direction)!, slow(origin, direction)!];
    // On a line between two patches either may be found.
    expect(found.distance).toBeCloseTo(wanted.distance, 5);
    expect(found.isFront).toBe(wanted.isFront);
  }
});

test("of the two sides of a sheet a ray finds the one that faces it; nothing beyond all", () => {
  const front: Point[] = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]];
  const scene = lit([{ corners: front }, { corners: [...front].reverse() }]);
  const rays = new Rays(stage(scene));
  expect(rays.closest([0.3, 0.2, 2], [0, 0, -1])).toEqual({ patch: 0, distance: 2, isFront: true });
  expect(rays.closest([0.3, 0.2, -2], [0, 0, 1])).toEqual({ patch: 1, distance: 2, isFront: true });
  expect(rays.closest([0.3, 0.2, 2], [0, 0, 1])).toBeNull();
});
