"""What is behind the page: a scene that is solved and relit in a thread of its own, so that no page waits for light."""

from __future__ import annotations

import threading
from collections.abc import Callable

import radiosity
from radiosity.files import LitModel
from radiosity.patches import Patches
from radiosity.report import Report
from radiosity.scene import Scene
from radiosity.solution import Solution
from radiosity.viewer import rough
from radiosity.viewer.board import LIGHT, SCENE, Board, Hear
from radiosity.viewer.layers import lamps
from radiosity.viewer.lit import Lit, up_axis
from radiosity.viewer.mailbox import written
from radiosity.viewer.messages import Failed, Relight, Status, Stop, percent
from radiosity.viewer.reading import Known
from radiosity.viewer.relighting import KEEPING, Outdated, Relighter
from radiosity.viewer.settings import Settings
from radiosity.viewer.solving import Solving, rough_patches

What = LitModel | Solution | Scene | Patches

NO_LAYERS = "a lit model has the light of all lamps together: for layers, give the scene that it was made from"

IDLE = 0.5
"""Seconds without a question before the light of a lamp is found ahead of questions."""


class Session:
    """One scene, for any number of pages.

    Args:
        what: a lit model, which is shown as it is; a solution, which can be relit; or a scene or patches, to solve
            first.
        settings: how.

    Raises:
        SceneError: the scene cannot be lit.
        ValueError: layers of a lit model, which has the light of all lamps together only.
    """

    def __init__(self, what: What, settings: Settings) -> None:
        if settings.is_layered and isinstance(what, LitModel):
            raise ValueError(NO_LAYERS)
        self._what, self._settings = what, settings
        self._board = Board()
        self._relighter: Relighter | None = None
        self._asked: dict[Hear, Relight] = {}
        self._news = threading.Condition()
        self._is_closed = self._is_stopped = False
        self._lit = self._first(what)
        self._status = Status("solving", -1.0, False, "the session begins")
        self._thread = threading.Thread(target=self._work, name="radiosity-session", daemon=True)

    @property
    def known(self) -> Known:
        """What messages may speak of."""
        model = self._lit.model
        return Known(len(model.surfaces), len(self._lit.lamps), len(model.bands))

    def start(self) -> None:
        """Begin to work."""
        self._board.show(SCENE, self._lit.scene_packet())
        self._thread.start()

    def close(self, seconds: float = 0.5) -> None:
        """End the work; waits for it so long at most."""
        with self._news:
            self._is_closed = self._is_stopped = True
            self._news.notify()
        self._thread.join(seconds)

    def join(self, hear: Hear) -> None:
        """Have a page hear all there is, and all that comes."""
        self._board.join(hear)

    def leave(self, hear: Hear) -> None:
        """Have it hear no more."""
        self._board.leave(hear)
        with self._news:
            self._asked.pop(hear, None)

    def take(self, message: Relight | Stop, hear: Hear) -> None:
        """Take what a page says: of its questions, the latest counts. Answers go to that page."""
        with self._news:
            if isinstance(message, Stop):
                self._is_stopped = True
            elif not self._status.can_relight:
                hear("failed", written(Failed(f"Lamps and paint cannot be changed now: {self._status.text}")))
            else:
                self._asked[hear] = message
                self._news.notify()

    def _first(self, what: What) -> Lit:
        """What is shown at the beginning."""
        settings = self._settings
        if isinstance(what, Scene | Patches):
            (what.scene if isinstance(what, Patches) else what).validate()
            self._rough = rough_patches(what)
            model, heads = rough.unlit(self._rough), lamps(self._rough)
        elif isinstance(what, Solution):
            model, heads = LitModel.of(what), lamps(what.patches, what.emission, what.lights)
        else:
            model, heads = what, []
        is_lit = not isinstance(what, Scene | Patches)
        return Lit(model, (), heads, settings.unit, settings.title, is_lit, up_axis(model.cameras))

    def _work(self) -> None:
        self._doing("the solve failed", self._begin)
        is_prepared = self._relighter is None
        while True:
            with self._news:
                self._news.wait_for(lambda: self._asked or self._is_closed, None if is_prepared else IDLE)
                if self._is_closed:
                    return
                hear = next(iter(self._asked), None)
                message = self._asked.pop(hear) if hear is not None else None
            if hear is not None and message is not None:
                self._answer(hear, message)
            else:
                is_prepared = not self._prepare()

    def _doing(self, what: str, work: Callable[[], None]) -> None:
        """Do work whose failure ends it, but not the session."""
        try:
            work()
        except Exception as error:
            self._board.say(Failed(_sentence(error)))
            self._ready(f"{what}: {_sentence(error)}", can_relight=False)

    def _begin(self) -> None:
        what = self._what
        if isinstance(what, LitModel):
            text = "this is a lit model, whose lamps and paint are fixed; open the scene file to change them"
            self._ready(text, can_relight=False)
        elif isinstance(what, Solution):
            self._finish(what, self._lit, SCENE if self._settings.is_layered else None)
        else:
            self._solve(what)

    def _solve(self, target: Scene | Patches) -> None:
        solving = Solving(target, self._lit, self._settings, self._board, lambda: self._is_stopped)
        solution = solving.run(self._rough)
        if self._is_closed:
            return
        if solution is None:
            self._ready("stopped with rough light only; open the scene again to have it solved", can_relight=False)
            return
        is_same = solving.is_shown(solution) and not self._settings.is_layered
        self._finish(solution, solving.fitting(solution), LIGHT if is_same else SCENE)

    def _finish(self, solution: Solution, lit: Lit, shown: str | None) -> None:
        """Show a solution by such a packet, and be ready to relight it."""
        report = solution.report
        if report.transport not in KEEPING:
            self._show(lit, shown, report.seconds)
            self._ready(
                f"this is light by {report.solver or report.transport}, which keeps nothing to relight with; "
                "to change lamps or paint, ask for fewer patches",
                can_relight=False,
            )
            return
        relighter = Relighter(solution, lit, is_layered=self._settings.is_layered and bool(lit.lamps))
        if self._settings.is_layered:
            self._say("relighting", "finding the light of each lamp", can_relight=False)
            lit = relighter.scene()
        self._show(lit, shown, report.seconds)
        self._relighter = relighter
        self._ready(_told(report), can_relight=True)

    def _show(self, lit: Lit, kind: str | None, seconds: float) -> None:
        if kind == SCENE:
            self._board.show(SCENE, lit.scene_packet())
        elif kind == LIGHT:
            self._board.show(LIGHT, lit.light_packet(seconds))
        self._lit = lit

    def _answer(self, hear: Hear, message: Relight) -> None:
        """Find the light that a page asks for."""
        if self._relighter is None:
            return
        hear("status", written(Status("relighting", -1.0, True, "relighting")))
        try:
            glimpse = self._relighter.glimpse(message)
            if glimpse is not None:
                hear(LIGHT, glimpse)
            hear(LIGHT, self._relighter.answer(message, lambda: self._is_closed or hear in self._asked))
        except Outdated:
            return
        except Exception as error:
            hear("failed", written(Failed(f"relighting failed: {_sentence(error)}")))
        hear("status", written(self._status))

    def _prepare(self) -> bool:
        """Do one piece of work ahead of questions; whether there may be more."""
        try:
            return self._relighter is not None and self._relighter.prepare()
        except Exception:
            # Questions are answered without it, and say what is wrong.
            return False

    def _ready(self, text: str, *, can_relight: bool) -> None:
        self._say("ready", text, can_relight=can_relight)

    def _say(self, stage: str, text: str, *, can_relight: bool) -> None:
        status = Status(stage, 1.0 if stage == "ready" else -1.0, can_relight, text)
        with self._news:
            self._status = status
        self._board.say(status)


def _told(report: Report) -> str:
    error = f"estimated error {percent(report.estimated_error)}"
    return f"ready: {error}" + ("" if report.reached else f", not {percent(report.accuracy)}: {report.limit}")


def _sentence(error: Exception) -> str:
    """What an exception says, for people."""
    if isinstance(error, MemoryError):
        return "out of memory: ask for fewer patches"
    if isinstance(error, ValueError | radiosity.ResourceError | OSError):
        return str(error)
    return f"internal error, {type(error).__name__}: {error}"
