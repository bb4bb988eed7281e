"""Inverse lighting: lamps and paint that make the irradiance that is wanted."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from radiosity.factors import FormFactors
from radiosity.inverse.goals import Goals
from radiosity.inverse.levers import Levers
from radiosity.inverse.search import Problem, optimum
from radiosity.patches import Patches
from radiosity.scene import DirectionalLight, Scene, Surface
from radiosity.sensitivity import demand_exchange, unknown
from radiosity.solution import DEFAULT_PATCHES, Progress, Solution, solve

Floats = npt.NDArray[np.float64]
Bounds = tuple[npt.ArrayLike, npt.ArrayLike]

MOST_MEASUREMENTS = 3
"""The exchange of a scene is measured at most so often in search of lamps, and once more to see what they do."""

FINEST = 0.2
"""It is measured to this part of the last accuracy at least."""


@dataclass(frozen=True)
class Target:
    """Irradiance that is wanted on the fronts of a surface.

    Args:
        surface: its name.
        value: W/m2: a number for the mean over area and bands, (n_bands,) for the mean over area in each band, or a row
            for each of the surface's patches, in their order, (m, n_bands) or (m, 1) for the mean over bands.
        weight: how much missing it by a part of itself counts. Zero is missed by parts of the mean of all targets.
        even: whether every patch is to have the value, and not only the mean.
    """

    surface: str
    value: npt.ArrayLike
    weight: float = 1.0
    even: bool = False


@dataclass(frozen=True)
class Variable:
    """What may change, within bounds: one number times a spectrum, or one for each band.

    Args:
        name: of a surface, or of a light without area. All of that name change together.
        bounds: least and most, of the mean over bands; (n_bands,) each where ``per_band``.
        tint: (n_bands,) the spectrum, which is scaled to a mean of 1; that of the scene by default, grey if it is dark.
        per_band: whether every band is free.
    """

    name: str
    bounds: Bounds = (0.0, np.inf)
    tint: npt.ArrayLike | None = None
    per_band: bool = False


@dataclass(frozen=True)
class Emission(Variable):
    """The emission of a surface, W/m2."""


@dataclass(frozen=True)
class Strength(Variable):
    """The strength of a light without area: W/sr, or W/m2 of parallel light."""


@dataclass(frozen=True)
class Reflectance(Variable):
    """The reflectance of a surface. No band exceeds 0.99, which may be nearer than the upper bound."""

    bounds: Bounds = (0.0, 0.99)


Targets = Mapping[str, npt.ArrayLike] | Iterable[Target]
Variables = Mapping[str, Bounds] | Iterable[Variable]


@dataclass(frozen=True, eq=False)
class Outcome:
    """What became of a target.

    Attributes:
        surface: its name.
        wanted, achieved: W/m2, a number or one for each band; of rows by patch and of ``even`` ones the mean by area.
        miss: root mean square over bands, and patches by area where each counts, relative to what is wanted.
        met: whether that is within the tolerance.
    """

    surface: str
    wanted: float | Floats
    achieved: float | Floats
    miss: float
    met: bool


@dataclass(frozen=True, eq=False)
class Design:
    """Lamps and paint that come nearest to what is wanted, made by :func:`design`; prints as a table.

    Attributes:
        solution: the equilibrium with them.
        values: by the name of the variable: the mean over bands, or (n_bands,). Where a name is varied in more than one
            way, it is followed by " emission", " reflectance" or " strength".
        at_bound: likewise "low", "high" or "" for variables that are free; of bands, if any is.
        outcomes: what became of the targets, in their order.
        residual: root mean square of what is missed, relative and weighted.
        history: that residual after each relighting.
        power: W that the varied lamps send, all bands; parallel light counts nothing.
        scene: the scene with these lamps and this paint.
    """

    solution: Solution
    values: dict[str, float | Floats]
    at_bound: dict[str, str]
    outcomes: list[Outcome]
    residual: float
    history: list[float]
    power: float
    scene: Scene

    @property
    def met(self) -> bool:
        """Whether every target is met."""
        return all(outcome.met for outcome in self.outcomes)

    @property
    def achieved(self) -> dict[str, float | Floats]:
        """W/m2 by surface."""
        return {outcome.surface: outcome.achieved for outcome in self.outcomes}

    @property
    def missed(self) -> list[Outcome]:
        """The targets that are not met."""
        return [outcome for outcome in self.outcomes if not outcome.met]

    def __str__(self) -> str:
        width = max(map(len, ("target", *self.values, *(o.surface for o in self.outcomes))))
        lines = [f"{'target':<{width}}  {'wanted':>10} {'achieved':>10}  W/m2"]
        for o in self.outcomes:
            for k, (wanted, achieved) in enumerate(
                zip(np.atleast_1d(o.wanted), np.atleast_1d(o.achieved), strict=True)
            ):
                verdict = "" if k else f"  {'met' if o.met else 'MISSED'}, by {o.miss:.2%}"
                lines.append(f"{'' if k else o.surface:<{width}}  {wanted:>10.5g} {achieved:>10.5g}{verdict}")
        lines += ["", f"{'variable':<{width}}  {'value':>10}"]
        for name, value in self.values.items():
            numbers = " ".join(f"{v:>10.5g}" for v in np.atleast_1d(value))
            bound = f"  at its {self.at_bound[name]}est" if self.at_bound[name] else ""
            lines.append(f"{name:<{width}}  {numbers}{bound}")
        lines += ["", f"power of these lamps {self.power:.5g} W, relit {len(self.history)} times"]
        return "\n".join(lines)


def design(
    scene: Scene | Patches | Solution,
    targets: Targets,
    variables: Variables,
    *,
    economy: float = 0.0,
    tolerance: float = 0.01,
    max_evaluations: int = 50,
    accuracy: float = 0.01,
    progress: Progress | None = None,
    **options: Any,
) -> Design:
    """Find lamps and paint that make the irradiance that is wanted, as nearly as bounds allow.

    Least squares of what is missed, each target relative to itself. Irradiance is linear in lamps: they are found by
    bounded linear least squares, on derivatives of one adjoint solve for each target or one relighting for each lamp,
    whichever are fewer. With paint it takes a few relightings and adjoint solves.

    Args:
        scene: a scene or patches, which are solved with all that may shine shining, and again, more finely, where
            the lamps that were found are so different that the accuracy is not kept; or a solution, whose exchange is
            used as it is.
        targets: irradiance by the name of a surface, W/m2, as ``{"desk": 500.0}``; or a list of :class:`Target`.
        variables: bounds by name, as ``{"lamp 1": (0, 2000)}``: the emission of a surface or the strength of a light;
            or a list of :class:`Emission`, :class:`Strength` and :class:`Reflectance`.
        economy: what it is worth to save power: as much, relative to the power that it takes otherwise, as missing all
            targets by that part. Among lamps that do as well, 0.01 finds those that take least.
        tolerance: a target is met when it is missed by no more than this part of it.
        max_evaluations: most relightings in a search with paint.
        accuracy, progress, options: as in :func:`radiosity.solve`, for a scene.

    Returns:
        The best there is: ``met`` says whether it is good enough, ``missed`` what is not.

    Raises:
        ValueError: there is no such surface or light, bounds or values make no sense, or the solution kept no exchange.
        SceneError, ResourceError: as in :func:`radiosity.solve`.
    """
    start = scene.patches(count=DEFAULT_PATCHES) if isinstance(scene, Scene) else scene
    if isinstance(start, Patches) and isinstance(options.get("transport"), FormFactors):
        # Form factors know no lamps.
        start = solve(start, accuracy=accuracy, progress=progress, **options)
    asked = list(_targets(targets))
    if isinstance(start, Patches):
        start._demand_opaque("a search for lamps and paint", "")
    if isinstance(start, Solution):
        demand_exchange(start)
        free = list(_variables(variables, start.patches.scene))
        levers = Levers.of_solution(start, free)
        problem = Problem(start, Goals.of(start.patches, asked), levers, economy)
        return _design(problem, optimum(problem, levers.start, max_evaluations), asked, tolerance)
    levers = Levers.of_patches(start, list(_variables(variables, start.scene)))
    problem = Problem(None, Goals.of(start, asked), levers, economy)
    x, finer = levers.start, 1.0
    for _ in range(MOST_MEASUREMENTS):
        lit = _with_values(start, levers, levers.shining(x))
        problem.measured = solve(lit, accuracy=finer * accuracy, progress=progress, **options)
        x = optimum(problem, x, max_evaluations)
        error = problem.relit(x).report.estimated_error
        if error <= accuracy or not problem.measured.report.reached:
            break
        # Samples were shared with lamps that are out by now.
        finer *= max(accuracy / error, FINEST)
    if error > accuracy:
        problem.measured = solve(_with_values(start, levers, x), accuracy=accuracy, progress=progress, **options)
    return _design(problem, x, asked, tolerance)


def _targets(targets: Targets) -> Iterable[Target]:
    if isinstance(targets, Mapping):
        return [Target(name, value) for name, value in targets.items()]
    return targets


def _variables(variables: Variables, scene: Scene) -> Iterable[Variable]:
    if not isinstance(variables, Mapping):
        return variables
    return [lamp(scene, name, bounds) for name, bounds in variables.items()]


def lamp(scene: Scene, name: str, bounds: Bounds) -> Variable:
    """The emission of the surface of that name, or the strength of the light.

    Raises:
        ValueError: there is neither.
    """
    surfaces, lights = [s.name for s in scene.surfaces], [light.name for light in scene.lights]
    if name not in surfaces + lights:
        raise unknown("surface or light", name, list(dict.fromkeys(surfaces + lights)))
    return Emission(name, bounds) if name in surfaces else Strength(name, bounds)


def _with_values(patches: Patches, levers: Levers, x: Floats) -> Patches:
    """The same patches of a scene with other lamps and paint."""
    lit = Patches(_scene(patches.scene, levers, x), patches._native, patches.cut)
    lit.__dict__["_enclosure"] = patches._enclosure  # geometry is the same
    return lit


def _scene(scene: Scene, levers: Levers, x: Floats) -> Scene:
    changes = levers.by_name(x)

    def painted(s: Surface) -> Surface:
        emission = changes.get(("emission", s.name), s.emission)
        reflectance = changes.get(("reflectance", s.name), s.reflectance)
        texture = None if ("reflectance", s.name) in changes else s.texture  # other paint covers it
        return dataclasses.replace(s, emission=emission, reflectance=reflectance, texture=texture)

    def dimmed(light: Any) -> Any:
        if ("strength", light.name) not in changes:
            return light
        what = "irradiance" if isinstance(light, DirectionalLight) else "intensity"
        return dataclasses.replace(light, **{what: changes["strength", light.name]})

    return dataclasses.replace(
        scene, surfaces=[painted(s) for s in scene.surfaces], lights=[dimmed(light) for light in scene.lights]
    )


def _design(problem: Problem, x: Floats, targets: Sequence[Target], tolerance: float) -> Design:
    levers, goals, solution = problem.levers, problem.goals, problem.relit(x)
    found = _with_values(solution.patches, levers, x)
    solution.patches = found
    values = goals.values(solution)
    outcomes = []
    for k, target in enumerate(targets):
        miss = goals.miss(k, values)
        wanted, achieved = goals.means(k, values)
        outcomes.append(Outcome(target.surface, wanted, achieved, miss, bool(miss <= tolerance)))
    return Design(
        solution, levers.values(x), levers.at_bound(x), outcomes, goals.residual(values), problem.history,
        float(levers.power @ x), found.scene,
    )  # fmt: skip


__all__ = ["Design", "Emission", "Outcome", "Reflectance", "Strength", "Target", "Variable", "design"]
