"""Solving for the equilibrium of light."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from radiosity import _native
from radiosity.checks import memory_or_most, threads_or_all, whole
from radiosity.choice import choose
from radiosity.factors import FormFactors
from radiosity.patches import Patches
from radiosity.report import Report
from radiosity.scene import Scene
from radiosity.snapshot import OnIterate, handed_to

if TYPE_CHECKING:
    from radiosity.sensitivity import Functional, Sensitivity

Floats = npt.NDArray[np.float64]
Progress = Callable[[int, int], object]
Solver = Literal[
    "conjugate_gradient", "jacobi", "gauss_seidel", "over_relaxation", "southwell", "overshooting", "shooting"
]

Transport = Literal["sampled", "hierarchical"]

SOLVERS: tuple[Solver, ...] = tuple(name for name in get_args(Solver) if name != "shooting")
"""The names of those that solve the equations; shooting has none."""

PROGRESSIVE = ("southwell", "overshooting")
"""Solvers that need rows and no products, and so no matrix."""

MAX_RAYS = 1 << 18
"""Most rays per patch where the caller does not say."""

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
        transport: str = "shooting",
        why: str = "",
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
        self.report = Report(
            **native.report(), seed=options["seed"], bands=list(patches.scene.bands), transport=transport, why=why
        )
        self._native: Any = native
        self._options = options

    def __repr__(self) -> str:
        return f"Solution({len(self.patches)} patches, estimated error {self.report.estimated_error:.2%})"

    def _on_all_patches(self, backs: Floats) -> Floats:
        values = np.full((len(self.patches), backs.shape[1]), np.nan)
        values[self.patches.two_sided] = backs
        return values

    @property
    def lights(self) -> Floats:
        """(n_lights, n_bands) strength of the lights without area: W/sr, or W/m2 of parallel light."""
        given = self._options.get("lights")
        own = np.array([tuple_[-1] for tuple_ in _lamps(self.patches.scene)])
        return own.reshape(-1, len(self.patches.scene.bands)) if given is None else given

    def relight(
        self,
        *,
        emission: npt.ArrayLike | None = None,
        reflectance: npt.ArrayLike | None = None,
        lights: npt.ArrayLike | None = None,
    ) -> Solution:
        """The equilibrium with other lamps or paint on the same geometry, without a new ray.

        Args:
            emission: W/m2, broadcast to (n_patches, n_bands), or (n_surfaces, n_bands) to set whole surfaces.
            reflectance: likewise, in [0, 1).
            lights: strength of the lights without area, broadcast to (n_lights, n_bands).

        Lamps that were dark when the exchange was measured are found by rays only, so their light is noisier than if
        they had shone; ``error`` says how noisy. A light without area that was dark then stays dark.
        """
        new_emission = self.emission if emission is None else _per_patch(self.patches, emission, "emission")
        new_reflectance = (
            self.reflectance if reflectance is None else _per_patch(self.patches, reflectance, "reflectance")
        )
        o = self._options if lights is None else {**self._options, "lights": _per_light(self.lights, lights)}
        native = self._native.relight(
            new_reflectance, new_emission, _lamps(self.patches.scene, o.get("lights")), o["accuracy"], o["solver"],
            o["exact"], o["max_iterations"], o["threads"],
        )  # fmt: skip
        return Solution(
            self.patches, native, new_reflectance, new_emission, o, self.report.transport, self.report.why
        )  # fmt: skip

    def sensitivity(self, target: Functional, *, progress: Progress | None = None) -> Sensitivity:
        """How a mean of irradiance, or another weighted sum of it, changes with every lamp and every paint.

        Derivatives by all emissions, all reflectances and all lights without area, from one solve of the adjoint
        equations: exactly those of the discrete equations on this exchange, so that differences of ``relight`` are
        the same but for what the solver leaves. Bands are apart: what a band of the target owes to the same band.

        Args:
            target: the name of a surface, for the mean irradiance of its fronts by area; or weights of irradiance of
                the fronts, (n_patches,) or (n_patches, n_bands).
            progress: called with (done, total) some twenty times a second.

        Raises:
            ValueError: there is no such surface, weights of another shape, or a solution that kept no exchange (by
                shooting, or on rows drawn on demand).
        """
        from radiosity.sensitivity import of  # noqa: PLC0415

        return of(self, target, progress)

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


def _per_light(old: Floats, values: npt.ArrayLike) -> Floats:
    """Broadcast strengths to (n_lights, n_bands)."""
    array = np.asarray(values, dtype=np.float64)
    try:
        return np.array(np.broadcast_to(array, old.shape))
    except ValueError as e:
        raise ValueError(f"lights of shape {array.shape} do not fit (n_lights, n_bands) = {old.shape}") from e


def _lamps(scene: Scene, strengths: Floats | None = None) -> list[_native.LightTuple]:
    lamps = [light._tuple(len(scene.bands)) for light in scene.lights]
    if strengths is None:
        return lamps
    return [(*lamp[:-1], strength) for lamp, strength in zip(lamps, strengths.tolist(), strict=True)]


def solve(
    scene: Scene | Patches,
    *,
    accuracy: float = 0.01,
    transport: FormFactors | Transport | None = None,
    solver: Solver | None = None,
    max_iterations: int | None = None,
    on_iterate: OnIterate | None = None,
    closure: Literal["balanced", "exact"] = "balanced",
    max_rays: int = MAX_RAYS,
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
        transport: what the equations are solved on. "sampled": samples of what every patch sees, which the answer is
            gathered through once more. "hierarchical": an exchange in blocks made for this light, for many patches;
            it is relit in no time. Or form factors F to solve ``B = E + rho F B`` on, exactly as they are and patch by
            patch. Left out, the engine chooses by size, accuracy and memory; ``report.why`` says why.
        solver: how the equations are solved (default "conjugate_gradient"; where nothing else fits, and ``transport``
            is left out too, the engine chooses "shooting"). "conjugate_gradient" takes fewest products where much is
            reflected. "jacobi" is light bounce by bounce, "gauss_seidel" patch by patch, and "over_relaxation" the
            same with longer steps. "southwell" is progressive refinement: the patch with most unshot power shoots, and
            most of the light is there after a few shots; "overshooting" shoots for what is still to come as well, and
            takes fewer shots where much is reflected. These two need no matrix: without ``transport`` each patch is
            drawn on hemicubes when it shoots, as many as the accuracy takes, and only patches that shoot are.
            "shooting" takes no form factors at all: power is shot as rays until little is left, and memory is about
            400 bytes a patch (three bands) however many rays; for scenes too large for anything else. Its solution can
            be refined, see :class:`radiosity.shooting.ShootingSolution`.
        max_iterations: most products, sweeps or shots; as many as it takes by default. Where they end a solve,
            ``report.converged`` is False and ``report.limited_by`` "solver".
        on_iterate: called with a :class:`Snapshot` before the first iteration and after each; the solve waits for it,
            ends if it returns False, and ends with its exception if it raises one. With ``transport``, or a solver that
            shoots.
        closure: "balanced" scales the rows of the exchange to their known sums within the accuracy, "exact" to 1e-9.
        max_rays: most rays per patch.
        memory_limit: bytes that samples and operator may take (default: four fifths of what is available). With
            ``transport``, what solving takes beside the form factors.
        time_limit: seconds after which "shooting" begins no further round.
        start: a solution by "shooting" of the same patches to go on from.
        threads: default: all cores. The answer does not depend on it.
        seed: the same seed gives the same bytes.
        progress: called with (done, total) some twenty times a second.

    Raises:
        SceneError: the scene cannot be lit.
        ResourceError: not even a first estimate fits the memory limit.
        ValueError: there is no such solver, or ``on_iterate`` for a solve that samples.
    """
    patches = scene if isinstance(scene, Patches) else scene.patches(count=DEFAULT_PATCHES)
    patches.scene.validate()
    memory, why = memory_or_most(memory_limit), ""
    limits_shooting = time_limit is not None or start is not None
    if transport is None and solver is None and closure == "balanced" and max_rays == MAX_RAYS and not limits_shooting:
        way, why = choose(patches, accuracy, memory)
        transport, solver = (None, "shooting") if way == "shooting" else (way, None)
    if solver == "shooting" or (solver is None and limits_shooting):
        if transport is not None:
            raise ValueError("shooting has no transport: leave it out, or choose another solver")
        if max_iterations is not None or on_iterate is not None:
            raise ValueError("shooting has rounds, not iterations: use max_rays or time_limit, and refine to watch it")
        from radiosity.shooting import shoot  # noqa: PLC0415

        return shoot(
            patches, accuracy=accuracy, max_rays=max_rays, memory_limit=memory_limit, time_limit=time_limit,
            start=start, threads=threads, seed=seed, progress=progress, why=why,
        )  # fmt: skip
    solver = solver or "conjugate_gradient"
    if limits_shooting:
        raise ValueError(f"time_limit and start are for solver='shooting', not for '{solver}'")
    exact, threads, seed = _is_exact(closure), threads_or_all(threads), whole(seed, "seed", 0, 2**64 - 1)
    most = None if max_iterations is None else whole(max_iterations, "max_iterations", 0, 2**63 - 1)
    options = {
        "accuracy": float(accuracy), "solver": solver, "max_iterations": most, "exact": exact, "threads": threads,
        "seed": seed,
    }  # fmt: skip
    light = (patches.reflectance, patches.emission, _lamps(patches.scene), accuracy)
    made, run = _way(patches, transport, solver)
    if made == "sampled":
        if on_iterate is not None:
            raise ValueError("a solve that samples has no iterations to show: pass transport, or a solver that shoots")
        rays = whole(max_rays, "max_rays", 1, 2**32 - 1)
        native = _native.solve(
            patches._enclosure, *light, seed, rays, memory, solver, exact, most, threads, progress
        )  # fmt: skip
    else:
        show = handed_to(on_iterate, patches, patches.reflectance)
        native = run(*light, seed, memory, solver, most, threads, progress, show)
    return Solution(patches, native, patches.reflectance, patches.emission, options, made, why)


def _way(
    patches: Patches, transport: FormFactors | Transport | None, solver: str
) -> tuple[str, Callable[..., _native.Solution]]:
    """What the equations are solved on, by name, and what solves on it."""
    if isinstance(transport, FormFactors):
        if transport.patches is not patches:
            raise ValueError("transport was measured on other patches; pass those patches to solve")
        return "given", transport._native.solve
    if transport not in (None, "sampled", "hierarchical"):
        raise ValueError(f"there is no transport '{transport}'; choose sampled or hierarchical, or pass form factors")
    if transport == "hierarchical":
        return "hierarchical", partial(_native.solve_linked, patches._enclosure)
    if solver in PROGRESSIVE:
        if transport == "sampled":
            raise ValueError(f"{solver} shoots from rows, not samples: leave out transport, or pass form factors")
        return "on_demand", partial(_native.solve_on_demand, patches._enclosure)
    return "sampled", partial(_native.solve, patches._enclosure)


def _is_exact(closure: str) -> bool:
    if closure not in ("balanced", "exact"):
        raise ValueError(f"there is no closure '{closure}'; choose balanced or exact")
    return closure == "exact"


__all__ = ["DEFAULT_PATCHES", "PROGRESSIVE", "SOLVERS", "Solution", "solve"]
