"""Blender Cycles (bpy): a lightmap bake of the Cornell box whose texels line up with the patches.

    python -m peers.peer_cycles [--k 4] [--samples 9 16 ...]

Direct and indirect diffuse light without colour, k x k texels a patch; E = pi * texel mean.
A whole bake is timed; importing bpy, building the scene and one bake of one sample are not.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from peers.reference import Array, Face, Reference, climb, faces, ladder_arguments, load

LADDER = [9, 16, 64, 100, 256, 400]
WIDTH = 512  # texels
PADDING = 2  # texels between faces
METRES = 6.0  # size of the scene in Blender


@dataclass(frozen=True)
class Placed:
    """A face and its first texel in the lightmap."""

    face: Face
    x: int
    y: int


def main() -> None:
    """Climb the ladder."""
    parser = ladder_arguments("Blender Cycles on the Cornell reference", LADDER)
    parser.add_argument("--k", type=int, default=4, help="texels along a patch")
    args = parser.parse_args()
    ref = load()
    lightmap = Lightmap(ref, args.k)
    configure(args.threads)
    lightmap(1, 0)
    climb(lightmap, ref, args, f"spp {{}} x {args.k**2} texels")


def configure(threads: int) -> None:
    """Plain unbiased settings: no clamping, no denoising, no adaptive sampling."""
    render = bpy.context.scene.render
    render.engine = "CYCLES"
    render.threads_mode = "FIXED"
    render.threads = threads
    cycles = bpy.context.scene.cycles
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.max_bounces = cycles.diffuse_bounces = 32


class Lightmap:
    """The box as one mesh with one lightmap."""

    def __init__(self, ref: Reference, k: int) -> None:
        """Build the mesh; every patch gets k x k texels."""
        self.shape, self.k = ref["E"].shape, k
        self.placed, self.height = pack(faces(ref), k)
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.image = bpy.data.images.new("lightmap", WIDTH, self.height, float_buffer=True, is_data=True)
        scale = METRES / np.ptp(ref["quads"].reshape(-1, 3), axis=0).max()
        self.build(scale)

    def build(self, scale: float) -> None:
        """Make the object, select it and give it its materials and texture coordinates."""
        data = bpy.data.meshes.new("box")
        thing = bpy.data.objects.new("box", data)
        bpy.context.scene.collection.objects.link(thing)
        vertices = scale * np.concatenate([p.face.corners for p in self.placed])
        polygons = np.arange(len(vertices)).reshape(-1, 4)
        data.from_pydata(vertices.tolist(), [], polygons.tolist())
        coordinates = np.concatenate([self.texture(p) for p in self.placed])
        data.uv_layers.new(name="lightmap").data.foreach_set("uv", coordinates.ravel())
        slots: dict[Any, int] = {}
        for polygon, place in zip(data.polygons, self.placed, strict=True):
            if place.face.material not in slots:
                slots[place.face.material] = len(slots)
                data.materials.append(material(place.face, self.image))
            polygon.material_index = slots[place.face.material]
        bpy.context.view_layer.objects.active = thing
        thing.select_set(True)

    def texture(self, place: Placed) -> Array:
        """Texture coordinates of the face's corners, (4, 2)."""
        x0, y0 = place.x, place.y
        x1, y1 = x0 + place.face.nu * self.k, y0 + place.face.nv * self.k
        return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)]) / (WIDTH, self.height)

    def __call__(self, samples: int, seed: int) -> Array:
        """Bake, and irradiance of every patch, (n, 3)."""
        cycles = bpy.context.scene.cycles
        cycles.samples, cycles.seed = samples, seed
        passes = {"DIRECT", "INDIRECT"}
        bpy.ops.object.bake(type="DIFFUSE", pass_filter=passes, margin=0, use_clear=True)
        return np.pi * self.patch_means()

    def patch_means(self) -> Array:
        """Mean of each patch's texels, (n, 3)."""
        pixels = np.empty(WIDTH * self.height * 4, np.float32)
        self.image.pixels.foreach_get(pixels)
        texels = pixels.reshape(self.height, WIDTH, 4)[..., :3].astype(float)
        result, k = np.zeros(self.shape), self.k
        for place in self.placed:
            nu, nv = place.face.nu, place.face.nv
            block = texels[place.y : place.y + nv * k, place.x : place.x + nu * k]
            means = block.reshape(nv, k, nu, k, 3).mean(axis=(1, 3))
            result[place.face.patches] = means.reshape(-1, 3)
        return result


def pack(all_faces: list[Face], k: int) -> tuple[list[Placed], int]:
    """Place the faces on shelves at whole texels, tallest first; also the height needed."""
    placed = []
    x = y = shelf = 0
    for face in sorted(all_faces, key=lambda f: -f.nv):
        width, height = face.nu * k + 2 * PADDING, face.nv * k + 2 * PADDING
        if x + width > WIDTH:
            x, y, shelf = 0, y + shelf, 0
        placed.append(Placed(face, x + PADDING, y + PADDING))
        x, shelf = x + width, max(shelf, height)
    return placed, y + shelf


def material(face: Face, image: Any) -> Any:
    """A diffuse or emitting material that bakes into the image."""
    result = bpy.data.materials.new(f"of {face.name}")
    result.use_nodes = True
    tree = result.node_tree
    tree.nodes.clear()
    shader = emission(tree, face) if face.emits else diffuse(tree, face)
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    tree.nodes.active = texture
    return result


def emission(tree: Any, face: Face) -> Any:
    """An emitter of the face's radiance."""
    node, strength = tree.nodes.new("ShaderNodeEmission"), face.radiance.max()
    node.inputs["Color"].default_value = (*(face.radiance / strength), 1)
    node.inputs["Strength"].default_value = strength
    return node


def diffuse(tree: Any, face: Face) -> Any:
    """A Lambertian surface of the face's reflectance."""
    node = tree.nodes.new("ShaderNodeBsdfDiffuse")
    node.inputs["Color"].default_value = (*face.reflectance, 1)
    return node


if __name__ == "__main__":
    main()
