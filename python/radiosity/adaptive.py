"""Solving on a mesh of the engine's own: coarse where light is smooth, fine where it is not.

Solve on a coarse mesh, roughly; compare what arrives in each sixteenth of a patch with the linear field through the
values of patches; cut the patches where that differs most; and again, until the mesh leaves less than its share of the
error asked for. Then sample until the rest does too.

Early solves are only as accurate as it takes to see where the mesh is too coarse: half the error that it leaves.
"""

from __future__ import annotations

import difflib
import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from radiosity import _native
from radiosity.patches import Patches

if TYPE_CHECKING:
    from radiosity.scene import Scene
    from radiosity.solution import Progress, Solution

Floats = npt.NDArray[np.float64]
Leaves = npt.NDArray[np.uint32]
Solve = Callable[[Patches, float, "Floats | None", "Progress | None"], "Solution"]
"""Solves on patches to an accuracy that leaves out the mesh; an error on each may matter differently."""

COARSE = 400
"""Patches to begin with, where the faces do not make more."""

MOST_PATCHES = 100_000
"""The most patches where the caller does not say."""

MESH_SHARE = 0.75
"""What the mesh may leave of the error asked for; the rest, which adds in squares, is for sampling."""

LEFT_BY_CUTTING = 0.35
"""What cutting a patch in four leaves of its squared error: a sixteenth where light is smooth, half at a step."""

MOST_MESHES = 12

COST = 1.4
"""The time of a solve goes with this power of one over its accuracy."""


@dataclass(frozen=True)
class Step:
    """One mesh on the way.

    Attributes:
        patches: how many it has.
        mesh_error: what the linear field on it leaves of the light, root mean square over area relative to the mean
            irradiance; it stays below nine times in ten.
        other_error: what the other causes add, likewise.
        seconds: since the solve began.
    """

    patches: int
    mesh_error: float
    other_error: float
    seconds: float


@dataclass(frozen=True)
class Limits:
    """What ends refinement before the accuracy is reached."""

    patches: int = MOST_PATCHES
    seconds: float = math.inf


def solve_adaptively(
    scene: Scene,
    accuracy: float,
    solve: Solve,
    limits: Limits,
    weigh: Callable[[Solution, Patches], Floats] | None = None,
    progress: Progress | None = None,
) -> Solution:
    """The solution on the first mesh that is fine enough, or the last that the limits allow.

    Args:
        scene: what to light.
        accuracy: wanted error of the field of irradiance, root mean square over area, relative to the mean.
        solve: see :data:`Solve`.
        limits: see :class:`Limits`.
        weigh: from a solution, how much a squared error on each of other patches matters; all the same by default.
        progress: as in :func:`radiosity.solve`.
    """
    return _Search(scene, accuracy, solve, limits, weigh, progress).run()


@dataclass
class _Search:
    scene: Scene
    accuracy: float
    solve: Solve
    limits: Limits
    weigh: Callable[[Solution, Patches], Floats] | None
    progress: Progress | None

    def run(self) -> Solution:
        """Refine and sample in turn."""
        self.begin, self.steps, self.effort = time.monotonic(), list[Step](), 0.0
        self.mesh = _native.AdaptiveMesh(self.scene._native(), min(COARSE, self.limits.patches))
        finest = self.accuracy * math.sqrt(1 - MESH_SHARE**2)
        patches, leaf = self._patches()
        solution: Solution | None = None
        other = max(finest, min(0.2, 4 * self.accuracy))
        while True:
            importance = None if self.weigh is None or solution is None else self.weigh(solution, patches)
            other = self._affordable(len(patches), other)
            try:
                solution = self._solve(patches, other, importance)
            except _native.ResourceError:
                if solution is None:
                    raise
                return self._told(solution, "memory")
            step = self.steps[-1]
            if solution.report.estimated_error <= self.accuracy and (self.weigh is None or importance is not None):
                return self._told(solution, "accuracy")
            limit = self._limit(len(patches))
            if step.mesh_error > MESH_SHARE * self.accuracy and limit is None:
                self.mesh.refine(self._marks(solution, leaf, importance))
                patches, leaf = self._patches()
                other = max(finest, min(other, 0.5 * math.sqrt(LEFT_BY_CUTTING) * step.mesh_error))
                continue
            # The mesh is as fine as it gets: the rest is sampling, though to be much better than the mesh is no use.
            wanted = max(math.sqrt(max(self.accuracy**2 - step.mesh_error**2, 0.0)), 0.5 * step.mesh_error, finest)
            if limit == "time" or other <= 1.05 * wanted:
                other_limit = solution.report.limited_by
                return self._told(solution, limit or ("patch_size" if other_limit == "accuracy" else other_limit))
            other = wanted

    def _patches(self) -> tuple[Patches, Leaves]:
        native, leaf = self.mesh.patches()
        return Patches(self.scene, native), leaf

    def _solve(self, patches: Patches, other: float, importance: Floats | None) -> Solution:
        before = time.monotonic()
        solution = self.solve(patches, other, importance, self.progress)
        now, report = time.monotonic(), solution.report
        self.effort = (now - before) / len(patches) * other**COST
        rest = math.sqrt(max(report.estimated_error**2 - report.mesh_error**2, 0.0))
        self.steps.append(Step(len(patches), report.mesh_error, rest, now - self.begin))
        return solution

    def _affordable(self, patches: int, other: float) -> float:
        """The accuracy wanted, or what the time left allows."""
        if math.isinf(self.limits.seconds) or not self.effort:
            return other
        left = max(self.limits.seconds - (time.monotonic() - self.begin), 1e-3)
        return max(other, min((self.effort * patches / left) ** (1 / COST), 0.5))

    def _limit(self, patches: int) -> str | None:
        """What forbids another mesh."""
        if time.monotonic() - self.begin > 0.4 * self.limits.seconds:
            return "time"
        if patches >= 0.8 * self.limits.patches:
            return "max_patches"
        return "patch_size" if len(self.steps) >= MOST_MESHES else None

    def _marks(self, solution: Solution, leaf: Leaves, importance: Floats | None) -> npt.NDArray[np.bool_]:
        """The leaves to cut: as few as bring the mesh to its share, those with most error first."""
        patches, leaves = solution.patches, int(leaf[-1]) + 1
        weight = patches.area if importance is None else patches.area * importance
        side = np.concatenate([np.arange(len(patches)), np.flatnonzero(patches.two_sided)])
        weight, leaf = weight[side] / weight[side].sum(), leaf[side]
        square, deviation = solution._native.mesh().T
        error = np.bincount(leaf, weight * square, leaves)
        noise = np.sqrt(np.bincount(leaf, (weight * deviation) ** 2, leaves))
        irradiance = np.concatenate([solution.irradiance, solution.back_irradiance[patches.two_sided]])
        wanted = 0.8 * (MESH_SHARE * self.accuracy * float(weight @ irradiance.mean(axis=1))) ** 2
        # What is not above its noise is no reason to cut.
        certain = np.where(error > 2 * noise, error, 0.0)
        order = np.argsort(-certain, kind="stable")
        gained = np.cumsum((1 - LEFT_BY_CUTTING) * certain[order])
        enough = int(np.searchsorted(gained, float(error.sum()) - wanted)) + 1
        # A leaf that is cut becomes four, and its neighbours some pieces.
        room = max((self.limits.patches - len(patches)) // 5, 1)
        chosen = order[: min(enough, room)]
        marked = np.zeros(leaves, dtype=bool)
        marked[chosen[certain[chosen] > 0]] = True
        if not marked.any():
            marked[np.argmax(error)] = True
        return marked

    def _told(self, solution: Solution, limit: str) -> Solution:
        """The solution with a report on all that was done for it."""
        solution.report = replace(
            solution.report,
            accuracy=self.accuracy,
            limited_by=limit,
            meshes=len(self.steps),
            seconds=time.monotonic() - self.begin,
        )
        solution.refinement = tuple(self.steps)
        return solution


FLOOR = 0.05
"""What the squared error matters on surfaces that are not in focus, besides what their light does to it."""


def focus_on(scene: Scene, name: str) -> Callable[[Solution, Patches], Floats]:
    """What matters where the surface of that name matters.

    Raises:
        ValueError: there is no such surface.
    """
    names = [surface.name for surface in scene.surfaces]
    if name not in names:
        near = difflib.get_close_matches(name, names, 3) or names[:5]
        raise ValueError(f"there is no surface '{name}' to focus on; there are {', '.join(near)}")
    chosen = np.array([other == name for other in names])

    def weigh(solution: Solution, patches: Patches) -> Floats:
        del solution
        return np.where(chosen[patches.surface], 1.0, FLOOR)

    return weigh


__all__ = ["Limits", "Step", "focus_on", "solve_adaptively"]
