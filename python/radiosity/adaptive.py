"""Solving on a mesh of the engine's own: coarse where light is smooth, fine where it is not.

Solve on a coarse mesh, roughly; compare what arrives in each sixteenth of a patch with the linear field through the
values of patches; cut the patches where that differs most; and again, until the mesh leaves less than its share of the
error asked for. Then sample until the rest does too.

Early solves are only as accurate as it takes to see where the mesh is too coarse: a third of the error that it leaves.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from radiosity import _native
from radiosity.patches import Patches
from radiosity.sensitivity import those_near

if TYPE_CHECKING:
    from radiosity.scene import Scene
    from radiosity.solution import Progress, Solution

Floats = npt.NDArray[np.float64]
Leaves = npt.NDArray[np.uint32]
Solve = Callable[[Patches, float, "Floats | None", "Progress | None"], "Solution"]
"""Solves on patches to an accuracy that leaves out the mesh; an error on each may matter differently."""
OnRefine = Callable[["Solution"], object]
"""Called with the solution on each mesh; the search ends with it if that returns False."""

COARSE = 400
"""Patches to begin with, where the faces do not make more."""

MOST_PATCHES = 100_000
"""The most patches where the caller does not say."""

MESH_SHARE = 0.8
"""What the mesh may leave of the error asked for; the rest, which adds in squares, is for sampling."""

LEFT_BY_CUTTING = (0.0625, 0.2, 0.5)
"""What cutting a patch in four leaves of its squared error: where light is smooth, to begin with, and at a step."""

TO_SEE = 0.33
"""Errors of a third of what the mesh leaves let it be seen."""

AIM = 0.7
"""Cutting aims at this share of the squared error that the mesh may leave."""

AT_ONCE = 0.2
"""One round of cutting aims at no less than this share of the squared error there was."""

MOST_ROUNDS = 24

COST = 1.4
"""The time of a solve goes with this power of one over its accuracy."""


@dataclass(frozen=True)
class Step:
    """One mesh on the way.

    Attributes:
        patches: how many it has.
        mesh_error: what the linear field on it leaves of the light, root mean square over area relative to the mean
            irradiance; the upper end of an interval that holds it nine times in ten.
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
    weigh: Callable[[Solution | None, Patches], Floats] | None = None,
    progress: Progress | None = None,
    on_refine: OnRefine | None = None,
) -> Solution:
    """The solution on the first mesh that is fine enough, or the last that the limits allow.

    Args:
        scene: what to light.
        accuracy: wanted error of the field of irradiance, root mean square over area, relative to the mean.
        solve: see :data:`Solve`.
        limits: see :class:`Limits`.
        weigh: from the last solution, if there is one, how much a squared error on each patch matters; all the same by
            default.
        progress: as in :func:`radiosity.solve`.
        on_refine: see :data:`OnRefine`.
    """
    return _Search(scene, accuracy, solve, limits, weigh, progress, on_refine).run()


@dataclass
class _Search:
    scene: Scene
    accuracy: float
    solve: Solve
    limits: Limits
    weigh: Callable[[Solution | None, Patches], Floats] | None
    progress: Progress | None
    on_refine: OnRefine | None = None
    cut: tuple[float, float] | None = None

    def run(self) -> Solution:
        """Refine and sample in turn."""
        self.begin, self.steps, self.effort = time.monotonic(), list[Step](), 0.0
        self.left = LEFT_BY_CUTTING[1]
        self.mesh = _native.AdaptiveMesh(self.scene._native(), min(COARSE, self.limits.patches))
        finest = self.accuracy * math.sqrt(1 - MESH_SHARE**2)
        patches, leaf = self._patches()
        if len(patches) > self.limits.patches:
            raise _native.ResourceError(
                f"{self.scene.name}: its faces alone make {len(patches):,} patches, and max_patches is "
                f"{self.limits.patches:,}: raise it"
            )
        solution: Solution | None = None
        full: str | None = None
        other = max(finest, min(0.2, 4 * self.accuracy))
        while True:
            importance = None if self.weigh is None else self.weigh(solution, patches)
            other = self._affordable(len(patches), other)
            try:
                solution = self._solve(patches, other, importance)
            except _native.ResourceError:
                if solution is None:
                    raise
                return self._told(solution, "memory")
            if self.on_refine is not None and self.on_refine(solution) is False:
                return self._told(solution, "observer")
            if solution.report.estimated_error <= self.accuracy:
                return self._told(solution, "accuracy")
            if solution.report.limited_by == "memory":
                return self._told(solution, "memory")
            limit, likely = full or self._limit(len(patches)), solution.report.causes["mesh"]
            least, rest = TO_SEE * max(likely, finest), min(other, self.steps[-1].other_error)
            is_sampled = rest <= least or self._is_stuck()
            if limit is None and (likely > MESH_SHARE * self.accuracy or is_sampled):
                marked, is_plain = self._marks(solution, leaf, importance)
                self.mesh.refine(marked)
                finer = self._patches()
                if len(finer[0]) <= self.limits.patches:
                    patches, leaf = finer
                    # What is lost in noise asks for more samples, not for more patches.
                    other = min(other if is_plain else 0.6 * other, max(0.5 * finest, TO_SEE * likely))
                    # Noise that three times fewer errors do not clear stays.
                    other = max(other, TO_SEE * least)
                    if marked.any() or not self._is_stuck():
                        continue
                    limit = "patch_size"
                else:
                    limit = full = "max_patches"
            # The mesh is as fine as it gets: the rest is sampling, which also tells how fine that is.
            if limit == "time" or is_sampled:
                other_limit = solution.report.limited_by
                return self._told(solution, limit or ("patch_size" if other_limit == "accuracy" else other_limit))
            other = max(least, 0.6 * rest)

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

    def _is_stuck(self) -> bool:
        """Whether the last solve was no better than the one before on the same mesh."""
        if len(self.steps) < 2:
            return False
        before, now = self.steps[-2:]
        return before.patches == now.patches and now.other_error > 0.9 * before.other_error

    def _affordable(self, patches: int, other: float) -> float:
        """The accuracy wanted, or what the time left allows."""
        if math.isinf(self.limits.seconds) or not self.effort:
            return other
        left = max(self.limits.seconds - (time.monotonic() - self.begin), 1e-3)
        return max(other, min(float((self.effort * patches / left) ** (1 / COST)), 0.5))

    def _limit(self, patches: int) -> str | None:
        """What forbids another mesh."""
        if time.monotonic() - self.begin > 0.4 * self.limits.seconds:
            return "time"
        if patches >= 0.8 * self.limits.patches:
            return "max_patches"
        return "patch_size" if len(self.steps) >= MOST_ROUNDS else None

    def _marks(self, solution: Solution, leaf: Leaves, importance: Floats | None) -> tuple[npt.NDArray[np.uint8], bool]:
        """How often to cut each leaf: as few as bring the mesh to its share, those with most error first.

        Also whether it was plain which these are.
        """
        error, noise = self._of_leaves(solution, leaf, importance)
        total = float(error.sum())
        if self.cut is not None:
            before, of_them = self.cut
            left = (total - (before - of_them)) / of_them
            self.left = math.sqrt(self.left * min(max(left, LEFT_BY_CUTTING[0]), LEFT_BY_CUTTING[2]))
        # Not too much at once: what a leaf hides shows when it is cut.
        wanted = max(AIM * (MESH_SHARE * self.accuracy) ** 2, AT_ONCE * total)
        # What is not above its noise is no reason to cut.
        certain = np.where(error > 2 * noise, error, 0.0)
        order = np.argsort(-certain, kind="stable")
        twice = self.left / 4 * certain > 2 * wanted / len(error)
        gained = np.cumsum((certain * np.where(twice, 1 - self.left**2, 1 - self.left))[order])
        # A leaf that is cut becomes four, and its neighbours some pieces.
        room = max((self.limits.patches - len(leaf)) // 5, 1)
        chosen = order[: min(int(np.searchsorted(gained, total - wanted)) + 1, room)]
        chosen = chosen[certain[chosen] > 0]
        marked = np.zeros(len(error), dtype=np.uint8)
        marked[chosen] = 1
        if len(chosen) < room // 4:
            marked[chosen[twice[chosen]]] = 2
        self.cut = (total, float(certain[chosen].sum())) if len(chosen) and not (marked == 2).any() else None
        return marked, bool(gained[-1] >= total - wanted)

    @staticmethod
    def _of_leaves(solution: Solution, leaf: Leaves, importance: Floats | None) -> tuple[Floats, Floats]:
        """Squared error by the mesh on each leaf, as a share of the whole, over the squared mean; and its noise."""
        patches = solution.patches
        weight = patches.area if importance is None else patches.area * importance
        if patches.is_specular:  # perfect mirrors take no light, and errors of it do not count
            weight = weight * (patches.specular + patches.transmittance < 1)
        side = np.concatenate([np.arange(len(patches)), np.flatnonzero(patches.two_sided)])
        weight = weight[side] / weight[side].sum()
        irradiance = np.concatenate([solution.irradiance, solution.back_irradiance[patches.two_sided]])
        weight /= max(float(weight @ irradiance.mean(axis=1)) ** 2, 1e-300)
        square, deviation = solution._native.mesh().T
        error: Floats = np.bincount(leaf[side], weight * square).astype(np.float64)
        noise: Floats = np.sqrt(np.bincount(leaf[side], (weight * deviation) ** 2))
        return error, noise

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
"""What the squared error matters at least where it hardly reaches the surface in focus."""


def focus_on(scene: Scene, name: str) -> Callable[[Solution | None, Patches], Floats]:
    """How much a squared error matters where the light on the surface of that name does.

    There it matters as it is. Elsewhere an error of irradiance is reflected and arrives with what the adjoint solution
    says that light from there is worth.

    Raises:
        ValueError: there is no such surface, or light passes through one diffusely.
    """
    names = [surface.name for surface in scene.surfaces]
    through = next((s.name for s in scene.surfaces if np.any(s.diffuse_transmittance)), None)
    if through is not None:
        raise ValueError(
            f"surface '{through}' lets light through diffusely, which no focus can follow: leave out focus"
        )
    if name not in names:
        near = ", ".join(those_near(name, names))
        raise ValueError(f"there is no surface '{name}' to focus on; there are {near}")
    chosen = np.array([other == name for other in names])

    def weigh(solution: Solution | None, patches: Patches) -> Floats:
        weight = np.where(chosen[patches.surface], 1.0, FLOOR)
        if solution is None:
            return weight
        of, area = solution.patches, float(solution.patches.area[chosen[solution.patches.surface]].sum())
        worth = (solution.reflectance * solution.sensitivity(name).importance).mean(axis=1) * area
        # The other mesh is a finer one of the same faces; offset by surface, so that none borrows from another.
        apart = 10 * float(np.ptp(of.centre, axis=0).max())
        key = [np.column_stack([p.centre, apart * p.surface]) for p in (of, patches)]
        nearest = cKDTree(key[0]).query(key[1])[1]
        return np.asarray(np.maximum(weight, worth[nearest] ** 2))

    return weigh


__all__ = ["Limits", "OnRefine", "Step", "focus_on", "solve_adaptively"]
