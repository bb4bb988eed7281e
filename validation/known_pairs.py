"""Pairs of polygons whose form factor is known in closed form."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

import radiosity
from radiosity import catalogue

PLATE = 0.09950629459898
"""From the lower to the upper of two unit squares at gap 1, a centred plate of half the size midway.

A smooth four-dimensional integral, the unoccluded factor less what passes through the plate, by Gauss-Legendre.
"""


def patches_of(*polygons: object, two_sided: Sequence[int] = ()) -> radiosity.Patches:
    """One patch a polygon, (3 or 4, 3) corners each, in their order; some of them seen from both sides."""
    surfaces = []
    for k, polygon in enumerate(polygons):
        corners = np.asarray(polygon, dtype=np.float64)
        faces = [list(range(len(corners)))]
        surfaces.append(radiosity.Surface(corners, faces, name=f"polygon {k}", two_sided=k in two_sided))
    return radiosity.Scene(surfaces).patches(as_is=True)


def flat(x: tuple[float, float], y: tuple[float, float], z: float, *, down: bool = False) -> np.ndarray:
    """(4, 3) a rectangle at a height, facing up or down."""
    corners = np.array([[x[0], y[0], z], [x[1], y[0], z], [x[1], y[1], z], [x[0], y[1], z]])
    return corners[::-1] if down else corners


def hinged(width: float, length: float, angle: float) -> np.ndarray:
    """(4, 3) a rectangle that rises from the y axis at an angle with the plane x > 0, facing it."""
    tip = width * np.array([np.cos(angle), 0, np.sin(angle)])
    along = np.array([0, length, 0])
    return np.array([0 * tip, along, along + tip, tip])


def parallel(x: float, y: float) -> tuple[np.ndarray, np.ndarray]:
    """Equal rectangles at gap 1."""
    return flat((0, x), (0, y), 0), flat((0, x), (0, y), 1, down=True)


def standing(height: float) -> tuple[np.ndarray, np.ndarray]:
    """A unit square and a rectangle that stands on one of its edges."""
    return flat((0, 1), (0, 1), 0), hinged(height, 1, np.pi / 2)


@dataclass(frozen=True)
class KnownPair:
    """Two polygons that see each other unoccluded, and the form factor from the first to the second."""

    first: np.ndarray
    second: np.ndarray
    factor: float

    def found(self, **options: object) -> float:
        """What the engine says."""
        return float(radiosity.form_factors(patches_of(self.first, self.second), threads=1, **options).row(0)[1])


def _standing(height: float) -> KnownPair:
    factor = catalogue.perpendicular_rectangles_with_common_edge(width_1=1, width_2=height, length=1)
    return KnownPair(*standing(height), factor)


def _parallel(x: float, y: float) -> KnownPair:
    return KnownPair(*parallel(x, y), catalogue.equal_parallel_rectangles(width=x, length=y, gap=1))


def _hinged(degrees: float) -> KnownPair:
    angle = np.deg2rad(degrees)
    factor = catalogue.hinged_rectangles(width_1=1, width_2=1, length=1, angle=angle)
    return KnownPair(flat((0, 1), (0, 1), 0), hinged(1, 1, angle), factor)


KNOWN_PAIRS = {
    "parallel 1 x 1": _parallel(1, 1),
    "parallel 2 x 1": _parallel(2, 1),
    "parallel 10 x 10": _parallel(10, 10),
    "touching, h/w 1": _standing(1),
    "touching, h/w 0.5": _standing(0.5),
    "touching, h/w 2": _standing(2),
    "hinged at 60 degrees": _hinged(60),
    "hinged at 150 degrees": _hinged(150),
}
"""Rectangles at gap 1 (Howell C-11), with a common edge at a right angle (C-14) and at others (C-16)."""

SEPARATED, TOUCHING = KNOWN_PAIRS["parallel 1 x 1"], KNOWN_PAIRS["touching, h/w 1"]
"""The two that methods with a rate are shown on."""


def plate() -> radiosity.Patches:
    """Two unit squares that face each other at gap 1, and a plate between; see ``PLATE``."""
    return patches_of(*parallel(1, 1), flat((0.25, 0.75), (0.25, 0.75), 0.5), two_sided=[2])
