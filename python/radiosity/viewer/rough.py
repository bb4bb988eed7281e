"""Rough light within seconds: progressive refinement on even patches, shown while it comes.

What shoots tells radiosity of fronts only. So the back of a two-sided patch is made a patch of its own here, a hair
behind the front: a sheet becomes a thin slab, whose open rim lets through what is not worth showing.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from radiosity import _native
from radiosity.files import LitModel
from radiosity.patches import Patches
from radiosity.scene import Scene
from radiosity.snapshot import Snapshot

Floats = npt.NDArray[np.float64]

PATCHES = 800
"""About so many are cut, where the faces do not make more; it takes a few milliseconds a patch to shoot from all."""

MOST_SIDES = 60_000
"""More are solved for at once: a shot from one of so many shows little."""

ENOUGH = 0.03
"""Share of the power that may be left unshot."""

ACCURACY = 0.3
"""Of the form factors; it hardly takes less time to do worse."""

_THICKNESS = 1e-4
"""Of a sheet, as a share of the largest extent of the scene."""


def one_sided(patches: Patches) -> Patches:
    """Diffuse patches, with the backs of two-sided ones after them on surfaces "... (back)", as in a lit model."""
    back = np.flatnonzero(patches.two_sided)
    if not len(back) and not patches.is_specular:
        return patches
    extent = float(np.ptp(patches.polygons.reshape(-1, 3), axis=0).max())
    behind = patches.polygons[back] - _THICKNESS * extent * patches.normal[back, None]
    triangle = np.all(patches.polygons[back, 2] == patches.polygons[back, 3], axis=1)
    order = np.where(triangle[:, None], [2, 1, 0, 0], [3, 2, 1, 0])
    scene = patches.scene
    native = _native.Patches(
        np.concatenate([patches.polygons, np.take_along_axis(behind, order[:, :, None], axis=1)]),
        np.concatenate([patches.surface, patches.surface[back] + np.uint32(len(scene.surfaces))]),
        np.concatenate([patches.face, patches.face[back]]),
        np.zeros(len(patches) + len(back), dtype=bool),
        patches.obstructions,
    )
    # Nothing passes yet, and mirrors are black: what shoots takes patches for opaque and diffuse.
    surfaces = [
        replace(s, two_sided=False, diffuse_transmittance=0.0, specular=0.0, transmittance=0.0) for s in scene.surfaces
    ]
    backs = [replace(s, faces=np.asarray(s.faces)[:, ::-1], name=f"{s.name} (back)") for s in surfaces]
    return Patches(Scene([*surfaces, *backs], scene.lights, scene.cameras, scene.name, scene.bands), native)


def unlit(patches: Patches) -> LitModel:
    """Patches with emission and no other light."""
    dark = np.zeros_like(patches.emission)
    return _model(patches, dark, patches.emission, {})


def lit(snapshot: Snapshot) -> LitModel:
    """What a solver has, with the light that is still to come spread evenly."""
    radiosity, patches = snapshot.with_ambient(), snapshot.patches
    rho = snapshot.reflectance
    # What reflects nothing does not tell what arrives: show what arrives on average of what is to come.
    arrived = np.divide(radiosity - patches.emission, rho, out=np.tile(snapshot.ambient, (len(rho), 1)), where=rho > 0)
    return _model(patches, np.maximum(arrived, 0.0), radiosity, {"unshot": snapshot.unshot})


def _model(patches: Patches, irradiance: Floats, radiosity: Floats, report: dict[str, Any]) -> LitModel:
    scene = patches.scene
    surfaces = [
        (s.name, s.material, rho, False, *scene._going_on(s), scene._through(s))
        for s, rho in zip(scene.surfaces, patches._mean_reflectance(), strict=True)
    ]
    unknown = np.full_like(irradiance, np.nan)
    return LitModel(
        patches._native, surfaces, list(scene.bands), patches.emission, irradiance, radiosity, unknown,
        list(scene.cameras), None, report,
    )  # fmt: skip
