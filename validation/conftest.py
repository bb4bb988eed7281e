"""Shared pieces of the validation suite, which asks whether it is true."""

from __future__ import annotations

import numpy as np
import pytest
from pieces import REFERENCES

import radiosity


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
