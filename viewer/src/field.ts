// Where on a patch, and what the field is there: crates/geometry/src/corners.rs, as the shader has it.

export type Point = [number, number, number];

/** Weights of the four corners at (s, t): bilinear on quads, linear on triangles, whose corners are (0, 0), (1, 0), (1, 1). */
export function cornerWeights(isTriangle: boolean, s: number, t: number): [number, number, number, number] {
  return isTriangle ? [1 - s, s - t, t, 0] : [(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t];
}

/**
 * The coordinates (s, t) of a point of a patch. They are affine on the triangles of corners 0, 1, 2 and 0, 2, 3, which
 * is what is drawn.
 *
 * @param polygons n x 4 x 3.
 */
export function locate(polygons: Float32Array, patch: number, x: number, y: number, z: number): [number, number] {
  const first = barycentric(polygons, patch, 1, 2, x, y, z);
  if (first[0] >= 0) return inSquare(first[0] + first[1], first[1]);
  const second = barycentric(polygons, patch, 2, 3, x, y, z);
  // A triangle has no other half.
  return Number.isFinite(second[0]) ? inSquare(second[0], second[0] + second[1]) : inSquare(first[1], first[1]);
}

/** The inverse of `locate`. */
export function pointAt(polygons: Float32Array, patch: number, s: number, t: number): Point {
  const o = 12 * patch;
  const isFirst = s >= t;
  const far = Math.max(s, t);
  const near = Math.min(s, t);
  const side = o + (isFirst ? 3 : 9);
  const axis = (k: number) => (1 - far) * polygons[o + k] + (far - near) * polygons[side + k] + near * polygons[o + 6 + k];
  return [axis(0), axis(1), axis(2)];
}

/** Coordinates that are spread evenly over the area of a patch if (u, v) are over the unit square. */
export function evenly(polygons: Float32Array, patch: number, u: number, v: number): [number, number] {
  const first = halfArea(polygons, patch, 1, 2);
  const second = halfArea(polygons, patch, 2, 3);
  const split = first / Math.max(first + second, 1e-300);
  const isFirst = u < split;
  const [b, c] = folded(isFirst ? u / split : (u - split) / (1 - split), v);
  return isFirst ? [b + c, c] : [b, b + c];
}

/** Heitz 2019, "A low-distortion map between triangle and square". */
function folded(u: number, v: number): [number, number] {
  return v > u ? [0.5 * u, v - 0.5 * u] : [u - 0.5 * v, 0.5 * v];
}

/** Barycentric coordinates of corners i and j in the triangle 0, i, j; not finite if it has no area. */
function barycentric(
  polygons: Float32Array, patch: number, i: number, j: number, x: number, y: number, z: number,
): [number, number] {
  const o = 12 * patch;
  const a = o + 3 * i;
  const b = o + 3 * j;
  const [ox, oy, oz] = [polygons[o], polygons[o + 1], polygons[o + 2]];
  const [ax, ay, az] = [polygons[a] - ox, polygons[a + 1] - oy, polygons[a + 2] - oz];
  const [bx, by, bz] = [polygons[b] - ox, polygons[b + 1] - oy, polygons[b + 2] - oz];
  const [px, py, pz] = [x - ox, y - oy, z - oz];
  const aa = ax * ax + ay * ay + az * az;
  const ab = ax * bx + ay * by + az * bz;
  const bb = bx * bx + by * by + bz * bz;
  const pa = px * ax + py * ay + pz * az;
  const pb = px * bx + py * by + pz * bz;
  const determinant = aa * bb - ab * ab;
  return determinant > 1e-12 * aa * bb
    ? [(bb * pa - ab * pb) / determinant, (aa * pb - ab * pa) / determinant]
    : [NaN, NaN];
}

function halfArea(polygons: Float32Array, patch: number, i: number, j: number): number {
  const o = 12 * patch;
  const edge = (corner: number, axis: number) => polygons[o + 3 * corner + axis] - polygons[o + axis];
  const part = (k: number, l: number) => edge(i, k) * edge(j, l) - edge(i, l) * edge(j, k);
  return 0.5 * Math.hypot(part(1, 2), part(2, 0), part(0, 1));
}

/** Rounding may have put a point of an edge beside it. */
function inSquare(s: number, t: number): [number, number] {
  return [Math.min(Math.max(s, 0), 1), Math.min(Math.max(t, 0), 1)];
}
