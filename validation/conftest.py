"""Shared pieces of the validation suite, which asks whether it is true."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import radiosity

REFERENCES = Path(__file__).parent / "references"


@pytest.fixture(scope="session")
def cornell() -> dict[str, np.ndarray]:
    """The reference irradiance of the Cornell box on 1,920 patches; see references/README.md."""
    return dict(np.load(REFERENCES / "cornell_irradiance.npz"))


@pytest.fixture(scope="session")
def cornell_patches(cornell: dict[str, np.ndarray]) -> radiosity.Patches:
    """The reference's patches in its order: one surface per face."""
    surfaces = []
    for name, (nu, nv, start) in zip(cornell["face_name"], cornell["face_grid"], strict=True):
        quads = cornell["quads"][start : start + nu * nv]
        surfaces.append(
            radiosity.Surface(
                quads.reshape(-1, 3),
                np.arange(4 * len(quads)).reshape(-1, 4),
                cornell["reflectance"][start],
                np.pi * cornell["emission"][start],
                str(name),
            )
        )
    return radiosity.Scene(surfaces, name="cornell").patches(as_is=True)


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
