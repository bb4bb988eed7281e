"""Pieces that validations are made of: rectangles, means over surfaces, where references are."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import radiosity

REFERENCES = Path(__file__).parent / "references"


def rectangle(
    origin: list[float],
    u: list[float],
    v: list[float],
    reflectance: object = 0.0,
    emission: object = 0.0,
    name: str = "",
    cells: tuple[int, int] = (1, 1),
) -> radiosity.Surface:
    """A grid of quads spanned by u and v, its normal along u x v."""
    o, u_, v_ = (np.asarray(a, float) for a in (origin, u, v))
    nu, nv = cells
    s, t = np.meshgrid(np.linspace(0, 1, nu + 1), np.linspace(0, 1, nv + 1))
    vertices = o + s.reshape(-1, 1) * u_ + t.reshape(-1, 1) * v_
    i, j = np.meshgrid(np.arange(nu), np.arange(nv))
    first = (j * (nu + 1) + i).ravel()
    faces = np.stack([first, first + 1, first + nu + 2, first + nu + 1], axis=1)
    return radiosity.Surface(vertices, faces, reflectance, emission, name)


def mean_irradiance(solution: radiosity.Solution, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Area-weighted mean irradiance of a surface and an upper bound of its standard error (errors fully correlated)."""
    names = [s.name for s in solution.patches.scene.surfaces]
    mask = solution.patches.surface == names.index(name)
    weight = solution.patches.area[mask] / solution.patches.area[mask].sum()
    return weight @ solution.irradiance[mask], weight @ solution.error[mask]
