"""Irradiance of the scenes of ``known_rooms.py`` by Mitsuba's path tracer, into ``references/known_*.npz``.

    PYTHONPATH=python:validation /path/to/venv-with-mitsuba/bin/python validation/make_known_answers.py [names ...]

Mitsuba 3.9.1 shares no code with the engine. Light is found in two parts, neither of which is biased: lamps are sampled
by area from the point, and cosine-distributed rays, stratified, bring what the path integrator finds, less what a lamp
sends along the ray itself. Eight replicates give standard errors. No test needs this script.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import drjit as dr
import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")

from known_rooms import PATH_TRACED, mesh_of, probes_on  # noqa: E402

import radiosity  # noqa: E402

REPLICATES = 8
PROBES = 500
SIDE = {"points": 72, "patches": 48}
"""Strata of directions along one edge, a replicate."""
WAVE = 1 << 21
OUT = Path(__file__).parent / "references"


def three(values: object, bands: int) -> list[float]:
    """One, two or three bands as Mitsuba's three."""
    spectrum = np.broadcast_to(np.asarray(values, float), (bands,))
    return [float(x) for x in np.resize(spectrum, 3)]


def mesh(surface: radiosity.Surface, bands: int) -> mi.Mesh:
    """A surface as triangles; dark from behind."""
    vertices, faces = np.asarray(surface.vertices), np.asarray(surface.faces)
    triangles = faces if faces.shape[1] == 3 else np.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]])
    properties = mi.Properties()
    reflectance = {"type": "rgb", "value": three(surface.reflectance, bands)}
    properties["bsdf"] = mi.load_dict({"type": "diffuse", "reflectance": reflectance})
    if np.any(surface.emission):
        radiance = {"type": "rgb", "value": [x / np.pi for x in three(surface.emission, bands)]}
        properties["emitter"] = mi.load_dict({"type": "area", "radiance": radiance})
    result = mi.Mesh(surface.name, len(vertices), len(triangles), props=properties)
    parameters = mi.traverse(result)
    parameters["vertex_positions"] = vertices.ravel().astype(np.float32)
    parameters["faces"] = triangles.ravel().astype(np.uint32)
    parameters.update()
    return result


def light(source: radiosity.DirectionalLight, bands: int) -> dict[str, object]:
    """Parallel light."""
    assert isinstance(source, radiosity.DirectionalLight)
    irradiance = {"type": "rgb", "value": three(source.irradiance, bands)}
    return {"type": "directional", "direction": list(source.direction), "irradiance": irradiance}


class Tracer:
    """Irradiance at points of a scene."""

    def __init__(self, scene: radiosity.Scene) -> None:
        self.bands = len(scene.bands)
        description: dict[str, object] = {"type": "scene"}
        for k, surface in enumerate(scene.surfaces):
            description[f"surface{k}"] = mesh(surface, self.bands)
        for k, source in enumerate(scene.lights):
            description[f"light{k}"] = light(source, self.bands)
        self.scene = mi.load_dict(description)
        self.integrator = mi.load_dict({"type": "path", "max_depth": -1, "rr_depth": 8})
        extent = np.concatenate([np.asarray(s.vertices) for s in scene.surfaces])
        self.above = 1e-5 * np.ptp(extent, axis=0).max()

    def irradiance(self, points: np.ndarray, normal: np.ndarray, cells: np.ndarray, side: int, seed: int) -> np.ndarray:
        """(k, bands) one path from each point, its direction in that one of side x side strata."""
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(seed, len(points))
        up = mi.Normal3f(*(mi.Float(normal[:, i].astype(np.float32)) for i in range(3)))
        start = mi.Point3f(*(mi.Float((points + self.above * normal)[:, i].astype(np.float32)) for i in range(3)))
        interaction = dr.zeros(mi.SurfaceInteraction3f, len(points))
        interaction.p, interaction.n = start, up
        to_lamp, weight = self.scene.sample_emitter_direction(interaction, sampler.next_2d(), True)
        found = weight * dr.maximum(dr.dot(to_lamp.d, up), 0)
        stratum = mi.Point2f(*(mi.Float(x.astype(np.float32)) for x in (cells % side, cells // side)))
        local = mi.warp.square_to_cosine_hemisphere((stratum + sampler.next_2d()) / side)
        ray = mi.RayDifferential3f(mi.Ray3f(start, mi.Frame3f(up).to_world(local)))
        radiance, _, _ = self.integrator.sample(self.scene, sampler, ray)
        hit = self.scene.ray_intersect(mi.Ray3f(ray))
        found += dr.pi * (radiance - hit.emitter(self.scene).eval(hit))
        return np.array(found).reshape(3, -1).T[:, : self.bands].astype(float)


def in_triangles(polygons: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """(k, 3) a random point of each quadrilateral, even by area."""
    a, b, c, d = np.moveaxis(polygons, 1, 0)
    areas = [np.linalg.norm(np.cross(q - a, r - a), axis=1) for q, r in ((b, c), (c, d))]
    first = (rng.random(len(a)) * (areas[0] + areas[1]) < areas[0])[:, None]
    s, t = rng.random((2, len(a), 1))
    root = np.sqrt(s)
    return a * (1 - root) + root * ((1 - t) * np.where(first, b, c) + t * np.where(first, c, d))


def measure(tracer: Tracer, polygons: np.ndarray, normal: np.ndarray, side: int, seed: int, what: str) -> tuple:
    """(n, bands) mean and standard error over polygons; of points where all corners are one."""
    n, each = len(polygons), side * side
    rng, means = np.random.default_rng(seed), np.zeros((REPLICATES, n, tracer.bands))
    batch = max(1, WAVE // each)
    begun = time.time()
    for r in range(REPLICATES):
        for first in range(0, n, batch):
            ids = np.repeat(np.arange(first, min(first + batch, n)), each)
            cells = np.tile(np.arange(each), len(ids) // each)
            points = in_triangles(polygons[ids], rng)
            values = tracer.irradiance(points, normal[ids], cells, side, int(rng.integers(2**31)))
            means[r, first : first + batch] = values.reshape(-1, each, tracer.bands).mean(axis=1)
        print(f"  {what} {r + 1}/{REPLICATES} {time.time() - begun:.0f} s", flush=True)
    return means.mean(axis=0), means.std(axis=0, ddof=1) / np.sqrt(REPLICATES)


def make(name: str) -> None:
    """Points and patches of one scene, to its file."""
    scene = PATH_TRACED[name]()
    tracer, patches = Tracer(scene), mesh_of(scene)
    points, surface, normal = probes_on(patches, PROBES)
    mean, error = measure(tracer, patches.polygons, patches.normal, SIDE["patches"], 1, f"{name}, patches")
    shrunk = np.repeat(points[:, None], 4, axis=1)
    value, spread = measure(tracer, shrunk, normal, SIDE["points"], 2, f"{name}, points")
    arrays = {"centre": patches.centre, "mean": mean, "mean_error": error, "points": points, "value": value,
              "value_error": spread}  # fmt: skip
    path = OUT / f"known_{name.replace(' ', '_')}.npz"
    np.savez_compressed(path, surface=surface, **{k: v.astype(np.float32) for k, v in arrays.items()})
    weight = patches.area[:, None] / patches.area.sum()
    for what, e in (
        ("patches", np.sqrt((weight * error**2).sum(axis=0))),
        ("points", np.sqrt((spread**2).mean(axis=0))),
    ):
        print(f"{name}: standard error of {what} over the mean", e / (weight * mean).sum(axis=0), flush=True)


if __name__ == "__main__":
    for chosen in sys.argv[1:] or PATH_TRACED:
        make(chosen)
