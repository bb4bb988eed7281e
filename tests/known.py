"""Scenes whose answers are known."""

from __future__ import annotations

import subprocess
from collections.abc import Callable

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
