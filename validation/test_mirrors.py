"""Mirrors and clear glass in the transport of light, against images, symmetry, the furnace and closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import radiosity
from radiosity import DirectionalLight, PointLight, Scene, SpotLight, Surface

Floats = npt.NDArray[np.float64]

QUAD = np.array([[0, 1, 2, 3]])


def quad(corner: Any, u: Any, v: Any, **optics: Any) -> Surface:
    """A parallelogram that looks along u x v."""
    c, u, v = (np.asarray(x, dtype=float) for x in (corner, u, v))
    return Surface(np.array([c, c + u, c + u + v, c + v]), QUAD, **{"reflectance": 0.0, **optics})


def box(size: tuple[float, float, float], **walls: dict[str, Any]) -> list[Surface]:
    """The inside of a box from the origin; of walls named x0, x1, y0 ... the optics."""
    x, y, z = np.diag(np.asarray(size, dtype=float))
    o = np.zeros(3)
    faces = {"x0": (o, y, z), "x1": (x, z, y), "y0": (o, z, x), "y1": (y, x, z), "z0": (o, x, y), "z1": (z, y, x)}
    return [quad(*faces[name], name=name, **optics) for name, optics in walls.items()]


def solved(surfaces: list[Surface], lights: Any = (), *, accuracy: float = 0.005, edge: float = 0.25, **options: Any):  # noqa: ANN201
    patches = Scene(surfaces, lights=list(lights)).patches(max_edge=edge)
    return radiosity.solve(patches, accuracy=accuracy, **options)


def of(solution: radiosity.Solution, name: str) -> npt.NDArray[np.bool_]:
    """Which patches are of a surface."""
    names = np.array([s.name for s in solution.patches.scene.surfaces])
    return names[solution.patches.surface] == name


def mean(solution: radiosity.Solution, name: str) -> float:
    """Irradiance of a surface, mean over it and bands."""
    chosen = of(solution, name)
    return float(np.average(solution.irradiance[chosen].mean(axis=1), weights=solution.patches.area[chosen]))


def assert_balanced(solution: radiosity.Solution, within: float) -> None:
    r = solution.report
    out = np.sum([r.absorbed, r.escaped, r.lost_on_backs, r.unfollowed], axis=0)
    into = np.add(r.emitted, r.from_lights)
    assert np.abs(out / into - 1).max() < within
    assert abs(r.imbalance) < within


RECEIVER = quad((-1, 0, 0), (0.5, 0, 0), (0, 0.5, 0), name="receiver")


@pytest.mark.parametrize("specular", [1.0, 0.6])
def test_a_lamp_seen_in_a_mirror_only_is_its_image(specular: float) -> None:
    # The lamp looks up, away from the receiver; its image at twice the height of the mirror looks down.
    lamp = quad((1, 0, 1), (0.5, 0, 0), (0, 0.5, 0), emission=10.0, name="lamp")
    mirror = quad((-2, -2, 2), (0, 5, 0), (5, 0, 0), specular=specular, name="mirror")
    image = quad((1, 0, 3), (0, 0.5, 0), (0.5, 0, 0), emission=10.0, name="lamp")
    seen = solved([RECEIVER, lamp, mirror], accuracy=0.002)
    exact = radiosity.solve(Scene([RECEIVER, image]).patches(max_edge=0.25),
                            transport=radiosity.form_factors(Scene([RECEIVER, image]).patches(max_edge=0.25)))  # fmt: skip
    wanted = specular * exact.irradiance[of(exact, "receiver")]
    error = seen.irradiance[of(seen, "receiver")] / wanted - 1
    assert np.abs(error).max() < 0.01
    assert_balanced(seen, 0.01)
