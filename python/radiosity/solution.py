"""Solving for the equilibrium of light."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from radiosity import _native
from radiosity.certificate import Certificate
from radiosity.checks import memory_or_most, threads_or_all, whole
from radiosity.choice import choose
from radiosity.factors import FormFactors
from radiosity.patches import Patches
from radiosity.report import Report
from radiosity.scene import Scene
from radiosity.snapshot import OnIterate, handed_to

if TYPE_CHECKING:
    from radiosity.adaptive import OnRefine, Step
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
        irradiance, radiosity, emission: (n_patches, n_bands) W/m2, of the fronts, means over patches.
        error: (n_patches, n_bands) estimated standard error of irradiance, W/m2: of the field over each patch where the
            engine chose the mesh, of the mean over each patch otherwise.
        back_irradiance, back_radiosity, back_error: the same of the backs; NaN where a patch is one-sided.
        reflectance: (n_patches, n_bands).
        report: energy balance, closure, error, effort.
        certificate: the error by cause.
        refinement: the meshes on the way, where the engine chose the mesh.
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
        if self.report.of_field:
            reached = self.report.estimated_error <= options["wanted"]
            limit = "accuracy" if reached else self.report.limited_by
            self.report = replace(self.report, accuracy=options["wanted"], limited_by=limit)
        self.refinement: tuple[Step, ...] = ()
        self._native: Any = native
        self._options = options

    def __repr__(self) -> str:
        return f"Solution({len(self.patches)} patches, estimated error {self.report.estimated_error:.2%})"

    def _on_all_patches(self, backs: Floats) -> Floats:
        values = np.full((len(self.patches), backs.shape[1]), np.nan)
        values[self.patches.two_sided] = backs
        return values

    @cached_property
    def certificate(self) -> Certificate:
        """The error of the fronts by cause."""
        causes = self._native.causes() if isinstance(self._native, _native.Solution) else []
        return Certificate.of(self.report, self.error, {cause: fronts for cause, (fronts, _) in causes})

    @cached_property
    def corner_irradiance(self) -> Floats:
        """(n_patches, 4, n_bands) W/m2 at the corners of the fronts: the continuous field that is linear over patches.

        A triangle repeats its last corner. The field is continuous within smooth surfaces and tends to its own limit at
        creases, borders, and lines on which another surface stands.
        """
        return _native.corner_field(self.patches._native, np.ascontiguousarray(self.irradiance))

    def irradiance_at(self, points: npt.ArrayLike, normals: npt.ArrayLike) -> Floats:
        """The field of irradiance at points of surfaces.

        Args:
            points: (k, 3) metres.
            normals: (k, 3) the way each surface looks there; backs are not looked for.

        Returns:
            (k, n_bands) W/m2; NaN where no surface is.
        """
        places = np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 3)
        up = np.ascontiguousarray(np.broadcast_to(np.asarray(normals, dtype=np.float64), places.shape))
        reach = 1e-5 * float(np.ptp(self.patches.polygons.reshape(-1, 3), axis=0).max())
        patch, weights = self.patches._enclosure.locate(places, up, reach)
        values = np.einsum("kc,kcb->kb", weights, self.corner_irradiance[patch])
        values[patch < 0] = np.nan
        return np.asarray(values)

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
        progress: Progress | None = None,
    ) -> Solution:
        """The equilibrium with other lamps or paint on the same geometry, without a new ray.

        Args:
            emission: W/m2, broadcast to (n_patches, n_bands), or (n_surfaces, n_bands) to set whole surfaces.
            reflectance: likewise, in [0, 1).
            lights: strength of the lights without area, broadcast to (n_lights, n_bands).
            progress: called with (done, total) some twenty times a second; what it raises ends the work.

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
            o["exact"], o["max_iterations"], o["threads"], progress, self.report.of_field,
            diffuse_transmittance=self.patches._through,
        )  # fmt: skip
        return Solution(
            self.patches, native, new_reflectance, new_emission, o, self.report.transport, self.report.why
        )  # fmt: skip

    def _irradiance_on_sides(self, emission: Floats, reflectance: Floats, lights: Floats) -> Floats | None:
        """(n_sides, n_bands) irradiance as the exchange between whole patches has it, fronts before backs.

        In a few products, for those who cannot wait; differences of these are nearly those of relights. None where
        relighting itself takes a few products, or nothing was kept to do it with.
        """
        if self.report.transport != "sampled":
            return None
        o = self._options
        return self._native.on_sides(  # type: ignore[no-any-return]
            reflectance, emission, _lamps(self.patches.scene, lights), o["accuracy"], o["solver"], o["threads"],
            self.patches._through,
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
    on_refine: OnRefine | None = None,
    closure: Literal["balanced", "exact"] = "balanced",
    max_rays: int = MAX_RAYS,
    memory_limit: int | None = None,
    time_limit: float | None = None,
    max_patches: int | None = None,
    focus: str | None = None,
    start: Solution | None = None,
    threads: int | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Solution:
    """Find the equilibrium of light to an accuracy.

    Args:
        scene: a scene, or patches. A scene is cut into patches by the engine: coarsely where light is smooth, finely
            where it is not, until the field that is linear over them is as accurate as asked. Patches are solved on as
            they are, and what is as accurate as asked are their means. (With a transport or solver that takes no mesh
            of the engine's own, or of very many faces, a scene is cut evenly into about 5,000 patches.)
        accuracy: wanted error of irradiance, root mean square over area and bands, relative to its mean. The engine
            works until its own estimate of the error is below; ``report.reached`` says whether it got there.
        transport: what the equations are solved on. "sampled": samples of what every patch sees, which the answer is
            gathered through once more, and that alone follows light by mirrors and clear glass, and through what lets
            light through diffusely. "hierarchical": an exchange in blocks made for this light, for many patches; it is
            relit in no time. Or form factors F to solve ``B = E + rho F B`` on, exactly as they are and patch by patch.
            Left out, the engine chooses by size, accuracy and memory; ``report.why`` says why.
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
        on_refine: called with the :class:`Solution` on each mesh of the engine's own as soon as it is there; the solve
            waits for it, ends with that solution if it returns False, and ends with its exception if it raises one.
            Never called where the mesh is given, or even.
        closure: "balanced" scales the rows of the exchange to their known sums within the accuracy, "exact" to 1e-9.
        max_rays: most rays per patch.
        memory_limit: bytes that samples and operator may take (default: four fifths of what is available). With
            ``transport``, what solving takes beside the form factors.
        time_limit: seconds after which "shooting" begins no further round, and after which a mesh of the engine's own
            is neither refined nor sampled further; what comes out then depends on the machine.
        max_patches: most patches of a mesh of the engine's own (default 100,000).
        focus: the name of a surface that matters: the accuracy is that of the field on it, relative to its mean, and
            mesh and samples go where they serve it. On a mesh of the engine's own.
        start: a solution by "shooting" of the same patches to go on from.
        threads: default: all cores. The answer does not depend on it.
        seed: the same seed gives the same bytes.
        progress: called with (done, total) some twenty times a second.

    Raises:
        SceneError: the scene cannot be lit.
        ResourceError: not even a first estimate fits the memory limit.
        ValueError: there is no such solver, ``on_iterate`` for a solve that samples, or mirrors, glass or diffuse
            transmittance for one that does not.
    """
    memory, why = memory_or_most(memory_limit), ""
    if isinstance(scene, Scene) and _is_adaptable(scene, transport, solver, start, on_iterate):
        sampling = Sampling(solver or "conjugate_gradient", max_iterations, closure, max_rays, memory, threads, seed)
        return _solve_adaptively(scene, accuracy, sampling, max_patches, time_limit, focus, progress, on_refine)
    if focus is not None or (max_patches is not None and isinstance(scene, Patches)):
        raise ValueError("max_patches and focus are for a mesh of the engine's own: pass a scene, without a transport")
    patches = (
        scene
        if isinstance(scene, Patches)
        else scene.patches(count=min(DEFAULT_PATCHES, max_patches or DEFAULT_PATCHES))
    )
    patches.scene.validate()
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
    made, run = _way(patches, transport, solver)
    sampling = Sampling(solver, max_iterations, closure, max_rays, memory, threads, seed)
    if run is None:
        if on_iterate is not None:
            raise ValueError("a solve that samples has no iterations to show: pass transport, or a solver that shoots")
        return sampling.solve(patches, accuracy, progress, why=why)
    options = sampling.options(accuracy)
    native = run(
        *_light(patches), accuracy, options["seed"], memory, solver, options["max_iterations"], options["threads"],
        progress, handed_to(on_iterate, patches, patches.reflectance),
    )  # fmt: skip
    return Solution(patches, native, patches.reflectance, patches.emission, options, made, why)


@dataclass(frozen=True)
class Sampling:
    """How to solve by samples."""

    solver: str
    max_iterations: int | None
    closure: str
    max_rays: int
    memory: int
    threads: int | None
    seed: int

    def options(self, accuracy: float) -> dict[str, Any]:
        """What another solve on the same exchange needs to know."""
        most = None if self.max_iterations is None else whole(self.max_iterations, "max_iterations", 0, 2**63 - 1)
        return {
            "accuracy": float(accuracy), "solver": self.solver, "max_iterations": most,
            "exact": _is_exact(self.closure),
            "threads": threads_or_all(self.threads), "seed": whole(self.seed, "seed", 0, 2**64 - 1),
        }  # fmt: skip

    def solve(
        self,
        patches: Patches,
        accuracy: float,
        progress: Progress | None,
        *,
        wanted: float | None = None,
        importance: Floats | None = None,
        why: str = "",
    ) -> Solution:
        """Solve on patches; as a field, if an accuracy is wanted of it, and to "accuracy" but for the mesh."""
        options = self.options(accuracy) | ({} if wanted is None else {"wanted": wanted})
        native = _native.solve(
            patches._enclosure, *_light(patches), accuracy, options["seed"],
            whole(self.max_rays, "max_rays", 1, 2**32 - 1), self.memory, self.solver, options["exact"],
            options["max_iterations"], options["threads"], progress, wanted is not None, importance, patches._through,
        )  # fmt: skip
        return Solution(patches, native, patches.reflectance, patches.emission, options, "sampled", why)


def _light(patches: Patches) -> tuple[Floats, Floats, list[_native.LightTuple]]:
    return patches.reflectance, patches.emission, _lamps(patches.scene)


MOST_FACES = 15_000
"""Scenes of more faces are not given a mesh of the engine's own: their faces are small already."""


def _is_adaptable(
    scene: Scene,
    transport: FormFactors | Transport | None,
    solver: str | None,
    start: Solution | None,
    on_iterate: OnIterate | None,
) -> bool:
    """Whether the mesh can be the engine's own."""
    samples = transport in (None, "sampled") and start is None and on_iterate is None
    takes_products = solver is None or (solver in SOLVERS and solver not in PROGRESSIVE)
    return samples and takes_products and sum(np.shape(surface.faces)[0] for surface in scene.surfaces) <= MOST_FACES


def _solve_adaptively(
    scene: Scene,
    accuracy: float,
    sampling: Sampling,
    max_patches: int | None,
    time_limit: float | None,
    focus: str | None,
    progress: Progress | None,
    on_refine: OnRefine | None,
) -> Solution:
    from radiosity import adaptive  # noqa: PLC0415

    scene.validate()
    if not accuracy > 0:
        raise ValueError(f"accuracy must be a positive number such as 0.01, not {accuracy}")
    if time_limit is not None and not time_limit > 0:
        raise ValueError(f"time_limit must be a positive number of seconds, not {time_limit}")
    most = adaptive.MOST_PATCHES if max_patches is None else whole(max_patches, "max_patches", 1, 2**31 - 1)

    def solve_on(patches: Patches, other: float, importance: Floats | None, progress: Progress | None) -> Solution:
        return sampling.solve(patches, other, progress, wanted=float(accuracy), importance=importance)

    limits = adaptive.Limits(most, math.inf if time_limit is None else float(time_limit))
    weigh = None if focus is None else adaptive.focus_on(scene, focus)
    return adaptive.solve_adaptively(scene, float(accuracy), solve_on, limits, weigh, progress, on_refine)


def _way(
    patches: Patches, transport: FormFactors | Transport | None, solver: str
) -> tuple[str, Callable[..., _native.Solution] | None]:
    """What the equations are solved on, by name, and what solves on it unless it is samples."""
    if isinstance(transport, FormFactors):
        if transport.patches is not patches:
            raise ValueError("transport was measured on other patches; pass those patches to solve")
        return "given", transport._native.solve
    if transport not in (None, "sampled", "hierarchical"):
        raise ValueError(f"there is no transport '{transport}'; choose sampled or hierarchical, or pass form factors")
    if transport == "hierarchical":
        return "hierarchical", partial(_native.solve_linked, patches._diffuse_enclosure("a hierarchical exchange"))
    if solver in PROGRESSIVE:
        if transport == "sampled":
            raise ValueError(f"{solver} shoots from rows, not samples: leave out transport, or pass form factors")
        enclosure = patches._diffuse_enclosure(f"{solver}, which draws hemicubes,")
        return "on_demand", partial(_native.solve_on_demand, enclosure)
    return "sampled", None


def _is_exact(closure: str) -> bool:
    if closure not in ("balanced", "exact"):
        raise ValueError(f"there is no closure '{closure}'; choose balanced or exact")
    return closure == "exact"


__all__ = ["DEFAULT_PATCHES", "PROGRESSIVE", "SOLVERS", "Solution", "solve"]
