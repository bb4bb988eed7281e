"""Other light on the same patches: paint by relighting, lamps by adding up the light of each where that is known."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from radiosity.files import LitModel, passed_through
from radiosity.solution import Solution
from radiosity.viewer.layers import adding_up, factors, layer
from radiosity.viewer.lit import Lit
from radiosity.viewer.messages import Relight, Spectrum

Floats = npt.NDArray[np.float64]

KEEPING = ("sampled", "hierarchical", "given")
"""Transports that keep what other light is found with."""


SOON = 0.25
"""Seconds that nobody minds to wait for light."""


class Outdated(Exception):  # noqa: N818 - no error
    """What was asked is no longer wanted."""


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
        self._took = math.inf
        self._on_sides: dict[bytes, Floats | None] = {}
        self._is_outdated: Callable[[], bool] = lambda: False

    def answer(self, message: Relight, is_outdated: Callable[[], bool] = lambda: False) -> bytes:
        """The light packet for a message.

        Raises:
            Outdated: another message counts now.
        """
        self._is_outdated, begin = is_outdated, time.monotonic()
        light = self._light(message)
        self._took = time.monotonic() - begin
        return light.light_packet(self._took)

    def glimpse(self, message: Relight) -> bytes | None:
        """A light packet for a message that is nearly right and there at once; None if the answer is there as soon.

        The light that is known, changed as it changes where patches see each other as wholes.
        """
        paint, weights = self._paint(message), self._weights(message)
        begin = time.monotonic()
        if self._took < SOON or (self._known(paint) is not None and self._is_split(self._base)):
            return None
        reflectance = self._reflectance(paint)
        if not self._is_layered:
            whole = self._glimpsed(self._base.model, reflectance, weights)
            if whole is None:
                return None
            return replace(self._lit, model=whole).light_packet(time.monotonic() - begin, is_final=False)
        alone = np.eye(len(weights))[:, :, None] * weights[None]
        each = [
            self._glimpsed(layer, reflectance, mixed, np.broadcast_to(one[:, None], weights.shape))
            for layer, mixed, one in zip(self._base.layers, alone, np.eye(len(weights)), strict=True)
        ]
        layers = [layer for layer in each if layer is not None]
        if len(layers) < len(each) or not layers:
            return None
        whole = _weighted(layers, [np.ones(weights.shape[1])] * len(layers), layers[0])
        lit = replace(self._lit, model=whole, layers=layers)
        return lit.light_packet(time.monotonic() - begin, is_final=False)

    def _glimpsed(
        self, known: LitModel, reflectance: Floats, weights: Floats, of_known: Floats | None = None
    ) -> LitModel | None:
        """Light that is known to be of lamps with weights ``of_known``, in the scene's paint, made that of others."""
        base, lamps = self._base.solution, list(self._lit.lamps)

        def on_sides(rho: Floats, weights: Floats) -> Floats | None:
            emitted, shone = factors(lamps, base.patches, weights)
            return base._irradiance_on_sides(base.emission * emitted, rho, base.lights * shone)

        key = (np.ones_like(weights) if of_known is None else of_known).tobytes()
        if key not in self._on_sides:
            self._on_sides[key] = on_sides(base.reflectance, np.frombuffer(key).reshape(weights.shape))
        before, after = self._on_sides[key], on_sides(reflectance, weights)
        if before is None or after is None:
            return None
        # In proportion where whole patches know the light well, since their noise is that of factors to lamps.
        is_near = (known.irradiance < 2 * before) & (before < 2 * known.irradiance)
        ratio = np.divide(after, before, out=np.ones_like(after), where=is_near)
        irradiance = np.where(is_near, known.irradiance * ratio, np.maximum(known.irradiance + after - before, 0.0))
        back = np.flatnonzero(base.patches.two_sided)
        emitted, _ = factors(lamps, base.patches, weights)
        emission, rho = (np.concatenate([a, a[back]]) for a in (base.emission * emitted, reflectance))
        return known.with_light(emission, irradiance, rho, passed_through(base.patches, irradiance))

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
        solution = self._base.solution.relight(reflectance=self._reflectance(paint), progress=self._heed)
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
            progress=self._heed,
        )
        return self._base.model.relit(other)

    def _heed(self, _done: int, _total: int) -> None:
        if self._is_outdated():
            raise Outdated

    def _is_split(self, painted: _Painted) -> bool:
        return len(painted.layers) == len(self._lit.lamps)

    def _add_layer(self, painted: _Painted) -> bool:
        if self._is_split(painted):
            return False
        lamps = list(self._lit.lamps)
        painted.layers.append(layer(painted.solution, lamps, len(painted.layers), painted.model, progress=self._heed))
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
