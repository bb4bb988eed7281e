// The hierarchy over the triangles of patches, and as it goes from one thread to another.

import { BufferAttribute, BufferGeometry } from "three";
import { MeshBVH, type SerializedBVH } from "three-mesh-bvh";
import { triangles } from "./patches";

/** Triangle k is of patch k >> 1. */
export function hierarchy(polygons: Float32Array): MeshBVH {
  // Indirect: the order of the triangles stays, so that their numbers tell the patch.
  return new MeshBVH(geometry(polygons), { indirect: true });
}

export function packed(polygons: Float32Array): SerializedBVH {
  return MeshBVH.serialize(hierarchy(polygons), { cloneBuffers: false });
}

export function unpacked(tree: SerializedBVH, polygons: Float32Array): MeshBVH {
  return MeshBVH.deserialize(tree, geometry(polygons), { setIndex: false });
}

function geometry(polygons: Float32Array): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(polygons, 3));
  geometry.setIndex(new BufferAttribute(triangles(polygons.length / 12), 1));
  return geometry;
}
