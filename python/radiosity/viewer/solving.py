"""From a dark scene to a solution, while a board shows how it comes about."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace

import radiosity
from radiosity.files import LitModel
from radiosity.patches import Patches
from radiosity.scene import Scene
from radiosity.snapshot import Snapshot
from radiosity.solution import Solution
from radiosity.viewer import rough
from radiosity.viewer.board import LIGHT, SCENE, Board
from radiosity.viewer.lit import Lit
from radiosity.viewer.messages import Convergence, Status, percent
from radiosity.viewer.settings import Settings

BUDGET = 3.0
"""Seconds after which rough light is good enough, however much is unshot: what is to come is shown spread evenly."""

OFTEN = 0.25
"""Seconds between packets, at least; and drawing them up takes no more than a fifth of the time."""


class Stopped(Exception):  # noqa: N818 - what was asked for
    """Ends a solve that was told to stop."""


class Solving:
    """The solve of one scene.

    Args:
        target: a scene, for the engine to choose the mesh, or patches.
        lit: how it is shown, on the patches of :func:`rough_patches`, dark.
        settings: what is asked for.
        board: where it is shown.
        is_stopped: whether to stop; asked many times a second.
    """

    def __init__(
        self, target: Scene | Patches, lit: Lit, settings: Settings, board: Board, is_stopped: Callable[[], bool]
    ) -> None:
        self._target, self._lit, self._settings = target, lit, settings
        self._board, self._is_stopped = board, is_stopped
        self._begin = time.monotonic()
        self._pace = _Pace()
        self._best: Solution | None = None
        self._best_lit: Lit | None = None
        self._climb = _Climb(settings.accuracy)

    def run(self, patches: Patches) -> Solution | None:
        """Shoot on the rough patches, then solve; None if it was stopped before there was a solution."""
        if len(patches) <= rough.MOST_SIDES:
            self._shoot(patches)
        if self._is_stopped():
            return None
        try:
            solution = self._solve()
        except Stopped:
            if self._best is None:
                return None
            solution = self._best
            solution.report = replace(solution.report, limited_by="observer")
        if not self.is_shown(solution):
            self._converged(solution)
        return solution

    def _shoot(self, patches: Patches) -> None:
        self._say("shooting", -1, "shooting light from the brightest patches")
        settings = self._settings
        try:
            radiosity.solve(
                patches, solver="southwell", accuracy=rough.ACCURACY, threads=settings.threads, seed=settings.seed,
                on_iterate=self._shot, progress=self._shooting,
            )  # fmt: skip
        except (Stopped, radiosity.ResourceError):
            # Rough light is for the eye: what did not fit the memory here may fit the solve.
            return

    def _shooting(self, _done: int, _total: int) -> None:
        if self._is_stopped():
            raise Stopped

    def _shot(self, snapshot: Snapshot) -> bool:
        unshot, seconds = snapshot.unshot or 0.0, self._seconds
        is_enough = unshot <= rough.ENOUGH or seconds > BUDGET
        if is_enough or self._pace.is_due():
            with self._pace:
                done = math.log(max(unshot, rough.ENOUGH)) / math.log(rough.ENOUGH)
                self._say(
                    "shooting", max(done, seconds / BUDGET), f"shooting: {percent(unshot)} of the light is unshot"
                )
                self._board.say(
                    Convergence("shooting", seconds, unshot, len(snapshot.patches), snapshot.iteration, rough.ENOUGH)
                )
                lit = replace(self._lit, model=rough.lit(snapshot))
                self._board.show(LIGHT, lit.light_packet(seconds, is_final=False))
        return not is_enough

    def _solve(self) -> Solution:
        self._pace = _Pace()
        self._say("solving", 0, "solving")
        settings = self._settings
        most = None if isinstance(self._target, Patches) else settings.max_patches
        return radiosity.solve(
            self._target, accuracy=settings.accuracy, threads=settings.threads, seed=settings.seed, max_patches=most,
            on_refine=self._refined, progress=self._solving,
        )  # fmt: skip

    def _solving(self, done: int, total: int) -> None:
        if self._is_stopped():
            raise Stopped
        if self._pace.is_due():
            with self._pace:
                self._say("solving", self._climb.within(done / max(total, 1)), self._text())

    def _refined(self, solution: Solution) -> bool:
        """Show a mesh on the way."""
        lit, error = self.fitting(solution), solution.report.estimated_error
        if self._best is None or self._best.patches is not solution.patches:
            self._board.show(SCENE, lit.scene_packet())
        else:
            self._board.show(LIGHT, lit.light_packet(self._seconds, is_final=False))
        self._best, self._best_lit = solution, lit
        self._climb.reached(error)
        self._say("solving", self._climb.within(0.0), self._text())
        self._converged(solution)
        return not self._is_stopped()

    def _converged(self, solution: Solution) -> None:
        """A point of the plot."""
        report, wanted = solution.report, self._settings.accuracy
        self._board.say(
            Convergence("solving", self._seconds, report.estimated_error, report.patches, report.iterations, wanted)
        )

    def _text(self) -> str:
        wanted = percent(self._settings.accuracy)
        if self._best is None:
            return f"solving for an error of {wanted}"
        return f"solving: estimated error {percent(self._best.report.estimated_error)}, wanted {wanted}"

    def fitting(self, solution: Solution) -> Lit:
        """How a solution is shown, on the same patches as before if it is on them."""
        shown = self._best_lit
        if shown is not None and self._best is not None and self._best.patches is solution.patches:
            return replace(shown, model=shown.model.relit(solution))
        return replace(self._lit, model=LitModel.of(solution), is_lit=True)

    def is_shown(self, solution: Solution) -> bool:
        """Whether the board shows the patches of a solution."""
        return self._best is not None and self._best.patches is solution.patches

    @property
    def _seconds(self) -> float:
        return time.monotonic() - self._begin

    def _say(self, stage: str, done: float, text: str) -> None:
        self._board.say(Status(stage, min(done, 1.0), False, text))


class _Pace:
    """When to show something again; as a context, it learns how long that takes."""

    def __init__(self) -> None:
        self._next = 0.0

    def is_due(self) -> bool:
        return time.monotonic() >= self._next

    def __enter__(self) -> None:
        self._begin = time.monotonic()

    def __exit__(self, *_: object) -> None:
        now = time.monotonic()
        self._next = now + max(OFTEN, 4 * (now - self._begin))


class _Climb:
    """How far an error has fallen to what is wanted, on a logarithmic scale: 0 to 1, never back."""

    STEP = 0.2
    """What a mesh brings, as far as is known beforehand."""

    def __init__(self, wanted: float) -> None:
        self._wanted, self._first, self._at, self._said = wanted, 0.0, 0.0, 0.0

    def reached(self, error: float) -> None:
        self._first = self._first or error
        if error <= self._wanted or self._first <= self._wanted:
            self._at = 1.0
        else:
            self._at = math.log(self._first / error) / math.log(self._first / self._wanted)

    def within(self, share: float) -> float:
        """With that share of what is being solved done."""
        if not self._first:
            # One stage after another, as the engine tells it: it may be the only solve.
            return share
        self._said = max(self._said, min(self._at + self.STEP * share, 1.0))
        return self._said


def rough_patches(target: Scene | Patches) -> Patches:
    """What is shot on first: few patches, one-sided."""
    scene = target.scene if isinstance(target, Patches) else target
    if isinstance(target, Patches) and len(target) <= rough.PATCHES:
        return rough.one_sided(target)
    return rough.one_sided(scene.patches(count=rough.PATCHES))
