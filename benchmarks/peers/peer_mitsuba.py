"""Mitsuba 3: irradiance of the Cornell patches, two ways.

    python -m peers.peer_mitsuba --method ortho|trace [--samples 225 400 ...]

ortho: one orthographic camera per face whose pixels are the patches (flat rectangular faces only).
trace: a wavefront of rays that start just above stratified points of every patch and look
    straight down on it (any mesh).

Either way the path integrator returns rho E / pi with light sampling at the first vertex,
hence E = pi L / rho. Importing, loading and the compilation of kernels are not timed.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import groupby
from math import isqrt
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from peers.reference import (
    Array,
    Face,
    Reference,
    climb,
    faces,
    ladder_arguments,
    load,
    passive,
)

VARIANT = "llvm_ad_rgb"
OLDEST_LLVM = (17, 0, 0)  # 15 and 16 cannot compile Dr.Jit's fminimum and abort the process
LADDER = [225, 400, 1600, 2500, 6400, 10000]  # square numbers: `trace` stratifies each patch


def main() -> None:
    """Climb the ladder with the method asked for."""
    parser = ladder_arguments("Mitsuba 3 on the Cornell reference", LADDER)
    parser.add_argument("--method", choices=METHODS, default="trace")
    args = parser.parse_args()
    start_backend(args.threads)
    ref = load()
    solve = METHODS[args.method](ref)
    for samples in args.samples:
        solve(samples, 0)  # compiles the kernels of this size
    climb(solve, ref, args, "spp {}")


def start_backend(threads: int) -> None:
    """Choose the variant and refuse an LLVM that would abort later."""
    mi.set_variant(VARIANT)
    dr.set_thread_count(threads)
    version = dr.detail.llvm_version()
    if version < OLDEST_LLVM:
        found = ".".join(map(str, version))
        raise SystemExit(f"LLVM {found} is too old for Dr.Jit; install libllvm19 or set DRJIT_LIBLLVM_PATH")


def scene_of(all_faces: list[Face]) -> Any:
    """The scene: one mesh of triangles per material, one rectangle per light."""
    description: dict[str, Any] = {"type": "scene", "integrator": integrator()}
    for material, group in groupby(sorted(all_faces, key=_material), key=_material):
        name, members = f"material{len(description)}", list(group)
        bsdf = diffuse(material[0])
        if any(material[1]):
            for face in members:
                description[f"{name}_{face.start}"] = light(face, bsdf)
        else:
            description[name] = mesh(name, members, bsdf)
    return mi.load_dict(description)


def _material(face: Face) -> tuple[tuple[float, ...], tuple[float, ...]]:
    return face.material


def integrator() -> dict[str, Any]:
    """Unbiased path tracing with Mitsuba's default Russian roulette."""
    return {"type": "path", "max_depth": -1}


def diffuse(reflectance: tuple[float, ...]) -> dict[str, Any]:
    """A two-sided Lambertian material."""
    colour = {"type": "rgb", "value": list(reflectance)}
    return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": colour}}


def light(face: Face, bsdf: dict[str, Any]) -> dict[str, Any]:
    """A rectangle that emits from its normal side."""
    to_world = np.eye(4)
    to_world[:3, :3] = np.stack([face.u / 2, face.v / 2, face.normal], axis=1)
    to_world[:3, 3] = face.origin + face.u / 2 + face.v / 2
    radiance = {"type": "rgb", "value": face.radiance.tolist()}
    return {
        "type": "rectangle",
        "to_world": mi.ScalarTransform4f(to_world),
        "bsdf": bsdf,
        "emitter": {"type": "area", "radiance": radiance},
    }


def mesh(name: str, members: list[Face], bsdf: dict[str, Any]) -> Any:
    """Two triangles for each of the faces."""
    vertices = np.concatenate([face.corners for face in members])
    triangles = 4 * np.arange(len(members))[:, None] + [0, 1, 2, 0, 2, 3]
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict(bsdf)
    result = mi.Mesh(
        name,
        len(vertices),
        2 * len(members),
        has_vertex_normals=False,
        has_vertex_texcoords=False,
        props=properties,
    )
    parameters = mi.traverse(result)
    parameters["vertex_positions"] = vertices.ravel().astype(np.float32)
    parameters["faces"] = triangles.ravel().astype(np.uint32)
    parameters.update()
    return result


def size(ref: Reference) -> float:
    """The longest side of the scene's bounding box."""
    return float(np.ptp(ref["quads"].reshape(-1, 3), axis=0).max())


class Orthographic:
    """One orthographic camera just above each face, box filter, one pixel per patch."""

    def __init__(self, ref: Reference) -> None:
        """Load the scene and place the cameras."""
        self.shape = ref["E"].shape
        every = faces(ref)
        self.scene = scene_of(every)
        above = 1e-4 * size(ref)
        self.cameras = [(f, self.camera(f, above)) for f in every if not f.emits]

    @staticmethod
    def camera(face: Face, above: float) -> Any:
        """A camera that looks down on the face; its film spans +-1 / aspect in y."""
        to_world = np.eye(4)
        right, up = -face.u / 2, face.v / 2 * face.nu / face.nv
        to_world[:3, :3] = np.stack([right, up, -face.normal], axis=1)
        centre = face.origin + face.u / 2 + face.v / 2
        to_world[:3, 3] = centre + 2 * above * face.normal
        film = {
            "type": "hdrfilm",
            "width": face.nu,
            "height": face.nv,
            "rfilter": {"type": "box"},
            "pixel_format": "rgb",
            "component_format": "float32",
        }
        return mi.load_dict(
            {
                "type": "orthographic",
                "to_world": mi.ScalarTransform4f(to_world),
                "near_clip": above / 2,
                "far_clip": 100 * above,
                "sampler": {"type": "independent"},
                "film": film,
            }
        )

    def __call__(self, samples: int, seed: int) -> Array:
        """Irradiance of every patch from ``samples`` paths a pixel, (n, 3)."""
        irradiance = np.zeros(self.shape)
        for k, (face, camera) in enumerate(self.cameras):
            picture = mi.render(self.scene, sensor=camera, spp=samples, seed=1000 * seed + k)
            radiance = np.array(picture)[::-1].reshape(-1, 3)
            irradiance[face.patches] = np.pi * radiance / face.reflectance
        return irradiance


class Wavefront:
    """Rays from stratified points of every patch, all in one wavefront."""

    def __init__(self, ref: Reference) -> None:
        """Load the scene and the patches that do not emit."""
        self.kept = passive(ref)
        self.scene = scene_of(faces(ref))
        self.integrator = mi.load_dict(integrator())
        self.sampler = mi.load_dict({"type": "independent"})
        self.above = 2e-5 * size(ref)
        quads = ref["quads"][self.kept]
        self.corner = points(quads[:, 0])
        self.u = points(quads[:, 1] - quads[:, 0])
        self.v = points(quads[:, 3] - quads[:, 0])
        self.normal = points(ref["normal"][self.kept])
        self.scale = np.pi / ref["reflectance"][self.kept]

    def __call__(self, samples: int, seed: int) -> Array:
        """Irradiance of every patch from ``samples`` (a square number) paths, (n, 3)."""
        side = isqrt(samples)
        count = len(self.scale) * side * side
        self.sampler.seed(seed, count)
        ray = self.rays(dr.arange(mi.UInt32, count), side)
        radiance, _, _ = self.integrator.sample(self.scene, self.sampler, ray, None, True)
        bands = [dr.block_sum(c, side * side) / side**2 for c in radiance]
        dr.eval(*bands)
        irradiance = np.zeros((len(self.kept), 3))
        irradiance[self.kept] = np.stack([np.array(b) for b in bands], axis=1) * self.scale
        return irradiance

    def rays(self, index: Any, side: int) -> Any:
        """One ray for each index, down onto a jittered point of a stratum of its patch."""
        patch, stratum = index // side**2, index % side**2
        jitter = self.sampler.next_2d()
        a = (mi.Float(stratum % side) + jitter.x) / side
        b = (mi.Float(stratum // side) + jitter.y) / side
        corner, u, v, normal = (dr.gather(mi.Point3f, p, patch) for p in (self.corner, self.u, self.v, self.normal))
        origin = corner + a * u + b * v + self.above * normal
        return mi.RayDifferential3f(mi.Ray3f(origin, -mi.Vector3f(normal)))


def points(values: Array) -> Any:
    """An (n, 3) array as Mitsuba points."""
    return mi.Point3f(*(mi.Float(np.ascontiguousarray(c, np.float32)) for c in values.T))


METHODS: dict[str, Callable[[Reference], Callable[[int, int], Array]]] = {
    "ortho": Orthographic,
    "trace": Wavefront,
}

if __name__ == "__main__":
    main()
