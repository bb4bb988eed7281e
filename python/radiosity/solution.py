"""Solving for the equilibrium of light."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from radiosity import _native
from radiosity.checks import memory_or_most, threads_or_all, whole
from radiosity.factors import FormFactors
from radiosity.patches import Patches
from radiosity.report import Report
from radiosity.scene import Scene

Floats = npt.NDArray[np.float64]
Progress = Callable[[int, int], object]
Solver = Literal["conjugate_gradient", "jacobi", "shooting"]

DEFAULT_PATCHES = 5000
"""Patches that a scene is cut into when the caller does not say."""


class Solution:
    """The equilibrium of light on patches, and the measured exchange to find another one with.

    Attributes:
        patches: what it is on.
        irradiance, radiosity, emission: (n_patches, n_bands) W/m2, of the fronts.
        error: (n_patches, n_bands) estimated standard error of irradiance, W/m2.
        back_irradiance, back_radiosity, back_error: the same of the backs; NaN where a patch is one-sided.
        reflectance: (n_patches, n_bands).
        report: energy balance, closure, error, effort.
    """

    def __init__(
        self,
        patches: Patches,
        native: _native.Solution | _native.ShotSolution,
        reflectance: Floats,
        emission: Floats,
        options: dict[str, Any],
    ) -> None:
        self.patches = patches
        self.reflectance = reflectance
        self.emission = emission
        self.irradiance: Floats = native.irradiance
        self.radiosity: Floats = native.radiosity
        self.error: Floats = native.error
        self.back_irradiance, self.back_radiosity, self.back_error = (
            self._on_all_patches(values) for values in native.backs()
        )
        self.report = Report(**native.report(), seed=options["seed"], bands=list(patches.scene.bands))
        self._native: Any = native
        self._options = options

    def __repr__(self) -> str:
        return f"Solution({len(self.patches)} patches, estimated error {self.report.estimated_error:.2%})"

    def _on_all_patches(self, backs: Floats) -> Floats:
        values = np.full((len(self.patches), backs.shape[1]), np.nan)
        values[self.patches.two_sided] = backs
        return values

    def relight(self, *, emission: npt.ArrayLike | None = None, reflectance: npt.ArrayLike | None = None) -> Solution:
        """The equilibrium with other lamps or paint on the same geometry, without a new ray.

        Args:
            emission: W/m2, broadcast to (n_patches, n_bands), or (n_surfaces, n_bands) to set whole surfaces.
            reflectance: likewise, in [0, 1).

        Lamps that were dark when the exchange was measured are found by rays only, so their light is noisier than if
        they had shone; ``error`` says how noisy.
        """
        new_emission = self.emission if emission is None else _per_patch(self.patches, emission, "emission")
        new_reflectance = (
            self.reflectance if reflectance is None else _per_patch(self.patches, reflectance, "reflectance")
        )
        o = self._options
        native = self._native.relight(
            new_reflectance, new_emission, _lamps(self.patches.scene), o["accuracy"], o["solver"], o["exact"],
            o["threads"],
        )  # fmt: skip
        return Solution(self.patches, native, new_reflectance, new_emission, self._options)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the solution: ``.glb`` (a lit model), ``.npz`` (all arrays) or ``.vtp`` (ParaView).

        The file appears whole or not at all.

        Raises:
            ValueError: another suffix.
            OSError: the disk is full, the folder is missing ...
        """
        from radiosity.files import save  # noqa: PLC0415

        save(self, path)


def _per_patch(patches: Patches, values: npt.ArrayLike, what: str) -> Floats:
    """Broadcast values per scene, surface or patch to (n_patches, n_bands)."""
    array = np.asarray(values, dtype=np.float64)
    shape = (len(patches), len(patches.scene.bands))
    if array.ndim == 2 and array.shape[0] == len(patches.scene.surfaces) != len(patches):
        array = array[patches.surface]
    try:
        return np.ascontiguousarray(np.broadcast_to(array, shape))
    except ValueError as e:
        raise ValueError(f"{what} of shape {array.shape} does not fit (n_patches, n_bands) = {shape}") from e


def _lamps(scene: Scene) -> list[_native.LightTuple]:
    return [light._tuple(len(scene.bands)) for light in scene.lights]


def solve(
    scene: Scene | Patches,
    *,
    accuracy: float = 0.01,
    transport: FormFactors | None = None,
    solver: Solver = "conjugate_gradient",
    closure: Literal["balanced", "exact"] = "balanced",
    max_rays: int = 1 << 18,
    memory_limit: int | None = None,
    time_limit: float | None = None,
    start: Solution | None = None,
    threads: int | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Solution:
    """Find the equilibrium of light to an accuracy.

    Args:
        scene: a scene (cut into about 5,000 patches) or patches.
        accuracy: wanted error of irradiance, root mean square over area and bands, relative to its mean. The engine
            samples until its own estimate of the error is below; ``report.reached`` says whether it got there.
        transport: form factors F to solve ``B = E + rho F B`` on, exactly as they are and patch by patch, instead of
            measuring the exchange to the accuracy.
        solver: how the equations are solved. "shooting" takes no form factors at all: power is shot as rays until
            little is left, and memory is about 400 bytes a patch (three bands) however many rays; for scenes too
            large for anything else. Its solution can be refined, see :class:`radiosity.shooting.ShootingSolution`.
        closure: "balanced" scales the rows of the exchange to their known sums within the accuracy, "exact" to 1e-9.
        max_rays: most rays per patch.
        memory_limit: bytes that samples and operator may take (default: four fifths of what is available).
        time_limit: seconds after which "shooting" begins no further round.
        start: a solution by "shooting" of the same patches to go on from.
        threads: default: all cores. The answer does not depend on it.
        seed: the same seed gives the same bytes.
        progress: called with (done, total) some twenty times a second.

    Raises:
        SceneError: the scene cannot be lit.
        ResourceError: not even a first estimate fits the memory limit.
    """
    patches = scene if isinstance(scene, Patches) else scene.patches(count=DEFAULT_PATCHES)
    patches.scene.validate()
    if solver == "shooting":
        from radiosity.shooting import shoot  # noqa: PLC0415

        if transport is not None:
            raise ValueError("shooting needs no form factors: leave out transport, or choose another solver")
        return shoot(
            patches, accuracy=accuracy, max_rays=max_rays, memory_limit=memory_limit, time_limit=time_limit,
            start=start, threads=threads, seed=seed, progress=progress,
        )  # fmt: skip
    if time_limit is not None or start is not None:
        raise ValueError(f"time_limit and start are for solver='shooting', not for '{solver}'")
    exact, threads, seed = _is_exact(closure), threads_or_all(threads), whole(seed, "seed", 0, 2**64 - 1)
    options = {"accuracy": float(accuracy), "solver": solver, "exact": exact, "threads": threads, "seed": seed}
    lamps = _lamps(patches.scene)
    if transport is not None:
        if transport.patches is not patches:
            raise ValueError("transport was measured on other patches; pass those patches to solve")
        native = transport._native.solve(
            patches.reflectance, patches.emission, lamps, accuracy, solver, seed, threads, progress
        )
    else:
        native = _native.solve(
            patches._enclosure, patches.reflectance, patches.emission, lamps, accuracy, seed,
            whole(max_rays, "max_rays", 1, 2**32 - 1), memory_or_most(memory_limit), solver, exact, threads, progress,
        )  # fmt: skip
    return Solution(patches, native, patches.reflectance, patches.emission, options)


def _is_exact(closure: str) -> bool:
    if closure not in ("balanced", "exact"):
        raise ValueError(f"there is no closure '{closure}'; choose balanced or exact")
    return closure == "exact"


__all__ = ["DEFAULT_PATCHES", "Solution", "solve"]
