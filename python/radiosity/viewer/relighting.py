"""Other light on the same patches: paint by relighting, lamps by adding up the light of each where that is known."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from radiosity.files import LitModel
from radiosity.solution import Solution
from radiosity.viewer.layers import adding_up, factors, layer
from radiosity.viewer.lit import Lit
from radiosity.viewer.messages import Relight, Spectrum

Floats = npt.NDArray[np.float64]

KEEPING = ("sampled", "hierarchical", "given")
"""Transports that keep what other light is found with."""


@dataclass
class _Painted:
    """The light in one paint."""

    solution: Solution
    model: LitModel
    layers: list[LitModel] = field(default_factory=list)
    """Of the first lamps, alone."""


class Relighter:
    """Answers to what is asked about one solution.

    Args:
        solution: with all lamps and the scene's paint, by one of the transports of :data:`KEEPING`.
        lit: how it is shown; its lamps are of the solution's emission and lights.
        is_layered: whether light goes out lamp by lamp.
    """

    def __init__(self, solution: Solution, lit: Lit, *, is_layered: bool) -> None:
        self._lit, self._is_layered = lit, is_layered
        self._base = _Painted(solution, lit.model)
        self._last: tuple[Mapping[int, Spectrum], _Painted] = ({}, self._base)

    def answer(self, message: Relight) -> bytes:
        """The light packet for a message."""
        begin = time.monotonic()
        return self._light(message).light_packet(time.monotonic() - begin)

    def scene(self) -> Lit:
        """The light as in the scene, in layers if it is wanted so."""
        return self._light(Relight({}, {}))

    def prepare(self) -> bool:
        """Find the light of one more lamp, so that dimming it takes no time; returns whether there was one."""
        return self._add_layer(self._base)

    def _light(self, message: Relight) -> Lit:
        paint, weights = self._paint(message), self._weights(message)
        is_plain = bool((weights == 1).all())
        painted = self._known(paint)
        if painted is None and (is_plain or self._is_layered or len(weights) == 1):
            painted = self._in_paint(paint)
        while self._is_layered and painted is not None and self._add_layer(painted):
            pass
        if painted is None or not (is_plain or self._is_split(painted)):
            return replace(self._lit, model=self._relit(paint, weights))
        whole = painted.model if is_plain else _weighted(painted.layers, weights, painted.model)
        if not self._is_layered:
            return replace(self._lit, model=whole)
        each = [_weighted([one], [w], painted.model) for one, w in zip(painted.layers, weights, strict=True)]
        return replace(self._lit, model=whole, layers=each)

    def _known(self, paint: Mapping[int, Spectrum]) -> _Painted | None:
        if not paint:
            return self._base
        return self._last[1] if self._last[0] == paint else None

    def _in_paint(self, paint: Mapping[int, Spectrum]) -> _Painted:
        """The light with all lamps in other paint, which is kept for the next question."""
        solution = self._base.solution.relight(reflectance=self._reflectance(paint))
        painted = _Painted(solution, self._base.model.relit(solution))
        if len(self._lit.lamps) == 1:
            painted.layers = [painted.model]
        self._last = (paint, painted)
        return painted

    def _relit(self, paint: Mapping[int, Spectrum], weights: Floats) -> LitModel:
        """The light by the engine itself."""
        solution = self._base.solution
        emitted, shone = factors(list(self._lit.lamps), solution.patches, weights)
        other = solution.relight(
            emission=solution.emission * emitted,
            lights=solution.lights * shone,
            reflectance=self._reflectance(paint),
        )
        return self._base.model.relit(other)

    def _is_split(self, painted: _Painted) -> bool:
        return len(painted.layers) == len(self._lit.lamps)

    def _add_layer(self, painted: _Painted) -> bool:
        if self._is_split(painted):
            return False
        lamps = list(self._lit.lamps)
        painted.layers.append(layer(painted.solution, lamps, len(painted.layers), painted.model))
        if self._is_split(painted):
            painted.layers = adding_up(painted.layers, painted.model)
        return True

    def _paint(self, message: Relight) -> dict[int, Spectrum]:
        """By surface of the scene: backs have the paint of their fronts."""
        n = len(self._base.solution.patches.scene.surfaces)
        order = sorted(message.reflectance, key=int, reverse=True)  # a front has the last word
        return {int(k) % n: message.reflectance[k] for k in order}

    def _reflectance(self, paint: Mapping[int, Spectrum]) -> Floats:
        reflectance = self._base.solution.reflectance.copy()
        for surface, values in paint.items():
            reflectance[self._base.solution.patches.surface == surface] = values
        return reflectance

    def _weights(self, message: Relight) -> Floats:
        weights = np.ones((len(self._lit.lamps), len(self._lit.model.bands)))
        for lamp, values in message.lamps.items():
            weights[int(lamp)] = values
        return weights


def _weighted(layers: list[LitModel], weights: Floats | list[Floats], model: LitModel) -> LitModel:
    """Layers added up, each so much by band, with the paint of the model.

    Errors are added as if all were off in the same way, since all were found by the same rays.
    """

    def total(name: str) -> Floats:
        return np.asarray(sum(w * getattr(one, name) for one, w in zip(layers, weights, strict=True)))

    return replace(
        model,
        emission=total("emission"),
        irradiance=total("irradiance"),
        radiosity=total("radiosity"),
        error=total("error"),
    )
