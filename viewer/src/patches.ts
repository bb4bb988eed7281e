// Patches as triangles.

/** Corners of the two triangles of a patch. */
const CORNERS = [0, 1, 2, 0, 2, 3];

/** The vertices of two triangles a patch: their index is twice the patch's, and one more. */
export function triangles(count: number): Uint32Array {
  const index = new Uint32Array(6 * count);
  for (let patch = 0, at = 0; patch < count; patch++)
    for (let k = 0; k < 6; k++) index[at++] = 4 * patch + CORNERS[k];
  return index;
}
