"""Light with other paint and lamps, quickly."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from radiosity import solution as solving
from radiosity.choice import TOO_MANY_SIDES
from radiosity.files import LitModel
from radiosity.solution import Progress, Solution
from radiosity.viewer.layers import Lamp, lamps_of, layers_of, light_of
from radiosity.viewer.lit import Lit
from radiosity.viewer.look import Look, up_axis
from radiosity.viewer.messages import Relight

Floats = npt.NDArray[np.float64]

QUICK_RAYS = 2_000_000
"""Samples of so many rays are relit in about half a second on two cores, of many more no longer while one waits."""

FINEST_OF_BLOCKS = 5e-3
"""More accurate blocks take long to make."""


@dataclass(frozen=True)
class Relighter:
    """A solution, and how it is shown with other paint and lamps.

    Attributes:
        solution: what is relit.
        look: how it is shown.
        lamps: of its scene, by which layers are made.
    """

    solution: Solution
    look: Look
    lamps: tuple[Lamp, ...]

    @classmethod
    def of(cls, solution: Solution, look: Look) -> Relighter:
        """For a solution as it is lit."""
        return cls(solution, look, tuple(lamps_of(solution.patches.scene)))

    def lit(self, on_layer: Callable[[int], object] | None = None) -> Lit:
        """The light as it was found, in layers if the look wants them."""
        solution = self.solution
        layers = layers_of(solution, self.lamps, on_layer) if self.look.is_layered else []
        return self._shown(LitModel.of(solution), layers)

    def relit(self, change: Relight, on_layer: Callable[[int], object] | None = None) -> Lit:
        """The light with what is changed.

        Paint of the back of a surface is paint of the surface: both sides have one. Layers are multiplied as the lamps.
        """
        paint, factors = self._reflectance(change), self._factors(change)
        scene, patches = self.solution.patches.scene, self.solution.patches
        emission, lights = light_of(scene, patches, zip(self.lamps, factors, strict=True))
        other = self.solution.relight(reflectance=paint, emission=emission, lights=lights)
        if not self.look.is_layered:
            return self._shown(LitModel.of(other), [])
        layers = []
        for k, (lamp, factor) in enumerate(zip(self.lamps, factors, strict=True)):
            emission, lights = light_of(scene, patches, [(lamp, factor)])
            layers.append(LitModel.of(other.relight(emission=emission, lights=lights)))
            if on_layer is not None:
                on_layer(k + 1)
        return self._shown(LitModel.of(other), layers)

    def _reflectance(self, change: Relight) -> Floats:
        """(n, bands) of patches: as in the solution but for surfaces that are painted."""
        reflectance, patches = self.solution.reflectance.copy(), self.solution.patches
        for index, values in change.reflectance.items():
            reflectance[patches.surface == int(index) % len(patches.scene.surfaces)] = values
        return reflectance

    def _factors(self, change: Relight) -> list[list[float]]:
        """What multiplies each lamp, by band."""
        as_it_is = [1.0] * len(self.solution.patches.scene.bands)
        return [change.lamps.get(str(k), as_it_is) for k in range(len(self.lamps))]

    def _shown(self, model: LitModel, layers: list[LitModel]) -> Lit:
        scene = self.solution.patches.scene
        heads = [lamp.head(scene) for lamp in self.lamps]
        up = up_axis(scene.cameras)
        return Lit(model, layers, heads, self.look.unit, self.look.title, up=up)


def why_fixed(solution: Solution) -> str:
    """Why a solution cannot be relit while somebody waits; empty if it can."""
    if solution.report.transport == "shooting":
        return "it was found by shooting, which keeps no exchange: another light would take as long as the first"
    return ""


def is_slow(solution: Solution) -> bool:
    """Whether a relight would keep people waiting.

    Every relight of a sampled solution goes through all its samples again, for the accuracy that they have. Blocks have
    the same exchange in a small part of the bytes.
    """
    report = solution.report
    is_sampled = report.transport == "sampled" and report.rays + report.shadow_rays > QUICK_RAYS
    return is_sampled and report.sides < TOO_MANY_SIDES


def in_blocks(solution: Solution, progress: Progress | None = None) -> Solution:
    """The same light on the same patches by a hierarchical exchange, which is relit in no time.

    The accuracy is that of the solution, but no finer than blocks get quickly.
    """
    report, options = solution.report, solution._options
    accuracy = max(report.accuracy, report.estimated_error, FINEST_OF_BLOCKS)
    return solving.solve(
        solution.patches, accuracy=float(accuracy), transport="hierarchical", seed=options["seed"],
        threads=options["threads"], progress=progress,
    )  # fmt: skip
