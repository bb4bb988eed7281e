"""Scenes whose answers are known."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

import radiosity

Runner = Callable[..., subprocess.CompletedProcess[str]]
"""The fixture ``run`` of conftest.py."""

Call = Callable[..., str]
"""The fixture ``call`` of conftest.py."""

CUBE = np.array([[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)])
"""(8, 3) corners of the unit cube."""

INWARD = {
    "floor": [0, 1, 3, 2],
    "ceiling": [4, 6, 7, 5],
    "front": [0, 4, 5, 1],
    "back": [2, 3, 7, 6],
    "left": [0, 2, 6, 4],
    "right": [1, 5, 7, 3],
}
"""Faces of the cube by name, counter-clockwise seen from inside. Opposite faces are neighbours in this list."""

OPPOSITE, ADJACENT = 0.19982490, 0.20004378
"""Form factors between unit squares (Howell, catalogue of configuration factors, C-11 and C-14); 1 = 1 O + 4 A."""


def square(size: float = 1.0, z: float = 0.0) -> list[list[float]]:
    """(4, 3) corners of a square about the z axis that faces up."""
    h = size / 2
    return [[-h, -h, z], [h, -h, z], [h, h, z], [-h, h, z]]


def cube(reflectance: object = 0.5, emission: dict[str, object] | float = 1.0) -> radiosity.Scene:
    """The unit cube seen from inside, a surface for each face; emission of all or by name."""
    lit = emission if isinstance(emission, dict) else dict.fromkeys(INWARD, emission)
    surfaces = [
        radiosity.Surface(CUBE[corners], [[0, 1, 2, 3]], reflectance, lit.get(name, 0.0), name)
        for name, corners in INWARD.items()
    ]
    return radiosity.Scene(surfaces, name="cube")


def cube_factors() -> np.ndarray:
    """(6, 6) exact form factors of :func:`cube`, one patch per face."""
    exact = np.full((6, 6), ADJACENT)
    for k in range(0, 6, 2):
        exact[k : k + 2, k : k + 2] = [[0, OPPOSITE], [OPPOSITE, 0]]
    return exact


def tiles(n: int) -> list[np.ndarray]:
    """(4, 3) corners of n x n squares on each face of the cube, in the order of INWARD."""
    found = []
    for corners in INWARD.values():
        a, b, _, d = CUBE[corners]
        steps = [((b - a) / n, (d - a) / n, a + (b - a) * i / n + (d - a) * j / n) for i in range(n) for j in range(n)]
        found += [np.array([at, at + u, at + u + v, at + v]) for u, v, at in steps]
    return found


def one_surface(polygons: Iterable[np.ndarray], name: str = "shell") -> radiosity.Surface:
    """Quads as one surface, a face each."""
    corners = np.concatenate(list(polygons))
    return radiosity.Surface(corners, np.arange(len(corners)).reshape(-1, 4), name=name)


def write_stl(path: Path, polygons: Iterable[np.ndarray]) -> None:
    """Quads as text STL, two triangles each."""
    lines = ["solid shell"]
    for a, b, c, d in polygons:
        for triangle in ([a, b, c], [a, c, d]):
            corners = [f"vertex {x:g} {y:g} {z:g}" for x, y, z in triangle]
            lines += ["facet normal 0 0 0", "outer loop", *corners, "endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid shell", ""]))


VIEW3D_CUBE = """T A simple cube
C encl=1 list=3 eps=1e-3 row=4
F 3
V  1   0.   0.   0.
V  2   1.   0.   0.
V  3   1.   1.   0.
V  4   0.   1.   0.
V  5   0.   0.   1.
V  6   1.   0.   1.
V  7   1.   1.   1.
V  8   0.   1.   1.
S  1    1   2   3   4   0   0   0.50  zeq0
S  2    1   4   8   5   0   0   0.50  xeq0
S  3    1   5   6   2   0   0   0.50  yeq0
S  4    7   6   5   8   0   0   0.50  zeq1
S  5    7   3   2   6   0   0   0.50  xeq1
S  6    7   8   4   3   0   0   0.50  yeq1
End of data
"""
"""The example of the user manual of View3D 3.3, section 6.1, whose answer it gives as well."""

HATCH = VIEW3D_CUBE.replace("S  1  ", "V 9 .2 .3 0\nV 10 .7 .3 0\nV 11 .7 .8 0\nV 12 .2 .8 0\nS  1  ").replace(
    "End", "S 7 9 10 11 12 1 0 0.5 hatch\nEnd"
)
"""The same with a square of 0.25 m2 cut from its first face, which leaves a frame of several faces."""
