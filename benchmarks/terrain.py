"""Terrain for the benchmarks: a smooth crater and a rough cratered field, both height fields of triangles.

Coordinates are multiples of 1/1024 m, so that programs in single precision see the same facets.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Faces = NDArray[np.int64]
Mesh = tuple[Array, Faces]

STEP = 1 / 1024  # m


def smooth_crater(cells: int, *, depth: float = 0.2, filled: float = 0.8) -> Mesh:
    """A spherical bowl in a plain, ``cells`` x ``cells`` squares of 1 m and two triangles each, seen from above.

    Args:
        cells: squares along a side.
        depth: depth of the bowl over its diameter.
        filled: diameter of the bowl over the side of the field.

    Returns:
        vertices ((cells + 1)^2, 3) and faces (2 cells^2, 3).
    """
    x, y = lattice(cells)
    radius = filled * cells / 2
    distance = np.hypot(x - cells / 2, y - cells / 2)
    return mesh(x, y, bowl(distance, radius, 2 * radius * depth))


def rough_terrain(cells: int = 32, *, craters: int = 7, roughness: float = 0.12, seed: int = 5) -> Mesh:
    """Overlapping craters with rims, and noise on every vertex; facets hide one another in many ways.

    Args:
        cells: squares along a side, 1 m each.
        craters: how many.
        roughness: standard deviation of the noise, m.
        seed: of craters and noise; the same seed gives the same field.

    Returns:
        vertices ((cells + 1)^2, 3) and faces (2 cells^2, 3).
    """
    rng = np.random.default_rng(seed)
    x, y = lattice(cells)
    height = np.zeros_like(x)
    for _ in range(craters):
        radius = cells * rng.uniform(0.08, 0.25)
        cx, cy = rng.uniform(0.15, 0.85, 2) * cells
        distance = np.hypot(x - cx, y - cy)
        rim = 0.08 * radius * np.exp(-((distance - radius) ** 2) / (0.3 * radius) ** 2)
        height = np.where(distance < radius, 0.4 * height, height) + bowl(distance, radius, 0.5 * radius) + rim
    return mesh(x, y, height + roughness * rng.standard_normal(x.shape))


def lattice(cells: int) -> tuple[Array, Array]:
    """Coordinates x and y of the vertices, (cells + 1, cells + 1) each, the first index along y."""
    line = np.arange(cells + 1.0)
    x, y = np.meshgrid(line, line)
    return x, y


def bowl(distance: Array, radius: float, depth: float) -> Array:
    """Height of a spherical bowl of this rim radius and depth, 0 outside."""
    sphere = (radius**2 + depth**2) / (2 * depth)
    inside = np.sqrt(np.maximum(sphere**2 - distance**2, 0)) - (sphere - depth)
    return np.where(distance < radius, -inside, 0.0)


def mesh(x: Array, y: Array, z: Array) -> Mesh:
    """Two triangles per square, the diagonal alternating, normals up."""
    vertices = np.stack([x, y, np.round(z / STEP) * STEP], axis=-1).reshape(-1, 3)
    index = np.arange(x.size).reshape(x.shape)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    odd = np.add.outer(np.arange(a.shape[0]), np.arange(a.shape[1])) % 2 == 1
    first = np.where(odd[..., None], np.stack([a, b, d], -1), np.stack([a, b, c], -1))
    second = np.where(odd[..., None], np.stack([b, c, d], -1), np.stack([a, c, d], -1))
    return vertices, np.stack([first, second], axis=2).reshape(-1, 3)
