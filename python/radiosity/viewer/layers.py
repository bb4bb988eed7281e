"""Lamps of a scene, and the light of each.

Light is linear: what all lamps send is the sum of what each sends alone. So a page that has the light of each can
switch and dim them without asking anybody.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from radiosity.files import LitModel
from radiosity.patches import Patches
from radiosity.scene import DirectionalLight, Light, SpotLight
from radiosity.solution import Progress, Solution
from radiosity.viewer.messages import LampHead

Floats = npt.NDArray[np.float64]

MOST_LAMPS = 16
"""More than these fit neither a panel nor, as layers, a file."""

_NUMBER = re.compile(r"[\s._-]*\(?\d+\)?$")
"""What tells "spot 3" from "spot 4"."""


@dataclass(frozen=True)
class _Source:
    """Surfaces and lights that shine as one; power in W, for comparing."""

    name: str
    surfaces: tuple[int, ...]
    lights: tuple[int, ...]
    power: float


def lamps(patches: Patches, emission: Floats | None = None, lights: Floats | None = None) -> list[LampHead]:
    """What of a scene is switched and dimmed together; at most :data:`MOST_LAMPS`.

    Args:
        patches: of the scene.
        emission: (n_patches, n_bands) W/m2; the scene's if not given.
        lights: (n_lights, n_bands) strength of the lights without area; the scene's if not given.

    Every emitting surface and every light without area is a lamp of its own while there are few. Of more, surfaces of
    one material are one lamp, and lights whose names differ by a number; if that is still too many, the weakest are
    one.
    """
    sources = [*_surfaces(patches, patches.emission if emission is None else emission), *_lights(patches, lights)]
    if len(sources) > MOST_LAMPS:
        sources = _merged(sources, lambda source: _family(source, patches))
    if len(sources) > MOST_LAMPS:
        strong = set(sorted(sources, key=lambda source: -source.power)[: MOST_LAMPS - 1])
        sources = _merged(sources, lambda source: source if source in strong else "other lamps")
    names = _told_apart([source.name for source in sources])
    return [LampHead(name, list(s.surfaces), list(s.lights)) for name, s in zip(names, sources, strict=True)]


def factors(lamps: list[LampHead], patches: Patches, weights: Floats) -> tuple[Floats, Floats]:
    """What lamps multiply emission and lights by.

    Args:
        lamps: of :func:`lamps`.
        patches: of the scene.
        weights: (n_lamps, n_bands).

    Returns:
        (n_patches, n_bands) and (n_lights, n_bands).
    """
    of_surfaces = np.ones((len(patches.scene.surfaces), weights.shape[1]))
    of_lights = np.ones((len(patches.scene.lights), weights.shape[1]))
    for lamp, weight in zip(lamps, weights, strict=True):
        of_surfaces[lamp.surfaces] = weight
        of_lights[lamp.lights] = weight
    return of_surfaces[patches.surface], of_lights


def layers(solution: Solution, lamps: list[LampHead], model: LitModel) -> list[LitModel]:
    """The light of each lamp alone, on the patches of the model; together they are that of the solution, exactly.

    Args:
        solution: with all lamps.
        lamps: of :func:`lamps`, for the solution's emission and lights.
        model: the lit model of the solution.
    """
    return adding_up([layer(solution, lamps, k, model) for k in range(len(lamps))], model)


def layer(
    solution: Solution, lamps: list[LampHead], which: int, model: LitModel, progress: Progress | None = None
) -> LitModel:
    """The light of one lamp alone, but for what iterative solvers leave; see :func:`layers`."""
    if len(lamps) == 1:
        return model
    weights = np.zeros((len(lamps), len(solution.patches.scene.bands)))
    weights[which] = 1.0
    emitted, shone = factors(lamps, solution.patches, weights)
    other = solution.relight(emission=solution.emission * emitted, lights=solution.lights * shone, progress=progress)
    return model.relit(other)


def adding_up(layers: list[LitModel], model: LitModel) -> list[LitModel]:
    """Layers scaled, patch by patch, by what iterative solvers leave, so that they are the light of the model."""
    if not layers:
        return []
    arrived = _scale([layer.irradiance for layer in layers], model.irradiance)
    reflected = _scale([layer.radiosity - layer.emission for layer in layers], model.radiosity - model.emission)
    return [
        replace(
            layer,
            irradiance=layer.irradiance * arrived,
            radiosity=layer.emission + (layer.radiosity - layer.emission) * reflected,
        )
        for layer in layers
    ]


def _scale(parts: list[Floats], whole: Floats) -> Floats:
    total = np.sum(parts, axis=0)
    return np.asarray(np.divide(whole, total, out=np.ones_like(total), where=total > 0))


def _surfaces(patches: Patches, emission: Floats) -> Iterable[_Source]:
    scene = patches.scene
    sides = patches.area * np.where(patches.two_sided, 2.0, 1.0)
    power = np.bincount(patches.surface, sides * emission.mean(axis=1), len(scene.surfaces))
    for k in np.flatnonzero(power > 0).tolist():
        yield _Source(scene.surfaces[k].name, (k,), (), float(power[k]))


def _lights(patches: Patches, strengths: Floats | None) -> Iterable[_Source]:
    size = float(np.linalg.norm(np.ptp(patches.polygons.reshape(-1, 3), axis=0)))
    for k, light in enumerate(patches.scene.lights):
        own = light.irradiance if isinstance(light, DirectionalLight) else light.intensity
        strength = np.asarray(own, dtype=np.float64) if strengths is None else strengths[k]
        power = float(strength.mean()) * _reach(light, size)
        if power > 0:
            yield _Source(light.name, (), (k,), power)


def _reach(light: Light, size: float) -> float:
    """About what a light of strength 1 sends into a scene of that size, W."""
    if isinstance(light, DirectionalLight):
        return math.pi / 4 * size**2
    return 2 * math.pi * (1 - math.cos(light.outer_angle)) if isinstance(light, SpotLight) else 4 * math.pi


def _family(source: _Source, patches: Patches) -> str:
    """What sources have in common that a person would switch together."""
    materials = [patches.scene.surfaces[k].material for k in source.surfaces]
    return (materials and materials[0]) or _NUMBER.sub("", source.name) or source.name


def _merged(sources: list[_Source], family: Callable[[_Source], Hashable]) -> list[_Source]:
    """One source of each family, in the order of the first of each; of several, it has the family's name."""
    families: dict[Hashable, list[_Source]] = {}
    for source in sources:
        families.setdefault(family(source), []).append(source)
    return [
        those[0]
        if len(those) == 1
        else _Source(
            str(name),
            tuple(k for source in those for k in source.surfaces),
            tuple(k for source in those for k in source.lights),
            sum(source.power for source in those),
        )
        for name, those in families.items()
    ]


def _told_apart(names: list[str]) -> list[str]:
    """Names of which no two are the same."""
    told: list[str] = []
    for name in names:
        name_or_lamp = name or "lamp"
        numbered = (f"{name_or_lamp} {k}" for k in itertools.count(2))
        told.append(next(other for other in itertools.chain([name_or_lamp], numbered) if other not in told))
    return told
