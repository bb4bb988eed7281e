"""What is behind the page: progress, relighting, stopping."""

from __future__ import annotations

import itertools
import json
import queue
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from rooms import lamp_room

import radiosity
from radiosity.files import LitModel
from radiosity.viewer import solving
from radiosity.viewer.mailbox import Post
from radiosity.viewer.messages import Relight, Stop
from radiosity.viewer.packet import unpack
from radiosity.viewer.session import Session, What
from radiosity.viewer.settings import Settings

PATIENCE = 60.0

Heard = tuple[dict[str, Any], dict[str, np.ndarray]]
"""A message, or the head of a packet and its arrays."""


class Page:
    """Listens to a session as a page does, and keeps all it hears."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self._posts: queue.Queue[Post] = queue.Queue()
        self.heard: list[Heard] = []
        session.join(self.hear)

    def hear(self, _kind: str, post: Post) -> None:
        self._posts.put(post)

    def next(self) -> Heard:
        post = self._posts.get(timeout=PATIENCE)
        self.heard.append(unpack(post) if isinstance(post, bytes) else (json.loads(post), {}))
        return self.heard[-1]

    def until(self, **wanted: object) -> Heard:
        """The next that says so."""
        while True:
            head, arrays = self.next()
            if wanted.items() <= head.items():
                return head, arrays

    def ask(self, reflectance: dict[str, list[float]], lamps: dict[str, list[float]]) -> Heard:
        """The light for other paint and lamps."""
        self.session.take(Relight(reflectance, lamps), self.hear)
        answer = self.until(type="light", is_final=True)
        self.until(stage="ready")
        return answer


@pytest.fixture
def sessions() -> Iterator[list[Session]]:
    running: list[Session] = []
    yield running
    for session in running:
        session.close()


def begin(sessions: list[Session], what: What, **settings: Any) -> Page:
    session = Session(what, Settings(**settings))
    sessions.append(session)
    page = Page(session)
    session.start()
    return page


def test_a_lit_model_is_shown_as_it_is(sessions: list[Session], lit_room: radiosity.Solution) -> None:
    page = begin(sessions, LitModel.of(lit_room))
    scene, arrays = page.next()
    assert (scene["type"], scene["is_lit"], scene["lamps"]) == ("scene", True, [])
    assert len(arrays["surface"]) == len(lit_room.patches) + lit_room.patches.two_sided.sum()
    status, _ = page.until(type="status", stage="ready")
    assert not status["can_relight"]
    assert "open the scene file" in status["text"]
    page.session.take(Relight({}, {}), page.hear)
    assert "cannot be changed now: this is a lit model" in page.until(type="failed")[0]["message"]


def test_a_scene_is_lit_before_your_eyes(sessions: list[Session]) -> None:
    page = begin(sessions, radiosity.scenes.cornell_box(), accuracy=0.1)
    scene, arrays = page.next()
    assert (scene["type"], scene["is_lit"]) == ("scene", False)
    assert not arrays["irradiance"].any()
    assert arrays["emission"].any()
    status, _ = page.until(type="status", stage="ready")
    assert status["can_relight"]
    heads = [head for head, _ in page.heard]
    stages = [head["stage"] for head in heads if head["type"] == "status"]
    assert list(dict.fromkeys(stages)) == ["shooting", "solving", "ready"]
    for stage in ("shooting", "solving"):
        errors = [head["error"] for head in heads if head["type"] == "convergence" and head["stage"] == stage]
        assert len(errors) > 1
        assert all(after < before for before, after in itertools.pairwise(errors))
        done = [head["done"] for head in heads if head["type"] == "status" and head["stage"] == stage]
        assert done == sorted(done) or stage == "shooting"
        assert max(done) <= 1
    assert errors[-1] <= 0.1
    last = next(head for head in reversed(heads) if head["type"] in ("scene", "light"))
    assert last["report"]["limited_by"] == "accuracy"
    assert last.get("is_final") or last.get("is_lit")
    # Light comes in while it is shot: never less of it.
    shot = [arrays["irradiance"].sum() for head, arrays in page.heard if head["type"] == "light"]
    assert len(shot) > 1


def test_who_comes_later_sees_what_there_is(sessions: list[Session]) -> None:
    page = begin(sessions, radiosity.scenes.cornell_box(), accuracy=0.2)
    page.until(type="status", stage="ready")
    late = Page(page.session)
    late.until(type="status", stage="ready")
    scene, arrays = late.heard[0]
    assert (scene["type"], scene["is_lit"]) == ("scene", True)
    points = [head for head, _ in page.heard if head["type"] == "convergence"]
    assert [head for head, _ in late.heard if head["type"] == "convergence"] == points
    lights = [arrays for head, arrays in late.heard if head["type"] == "light"]
    assert all(light["error"].shape == arrays["error"].shape for light in lights)


@pytest.mark.parametrize("transport", ["sampled", "hierarchical"])
def test_relighting_is_the_engines_own(sessions: list[Session], transport: str) -> None:
    solution = radiosity.solve(lamp_room().patches(count=150), transport=transport, accuracy=0.05)  # type: ignore[arg-type]
    page = begin(sessions, solution)
    page.until(type="status", stage="ready")
    n = len(solution.patches)
    # Paint and lamps at once, and paint alone, are relit; backs have the paint of their fronts.
    paint, dimmed = [0.1, 0.2, 0.3], [0.5, 0.0, 2.0]
    sheet_back = str(1 + len(solution.patches.scene.surfaces))
    reflectance = solution.reflectance.copy()
    reflectance[solution.patches.surface == 1] = paint
    emission = solution.emission.copy()
    emission[solution.patches.surface == 2] *= dimmed
    lights = solution.lights * [[1, 1, 1], [0, 0, 0]]
    for lamps in ({}, {"0": dimmed, "4": [0.0, 0.0, 0.0]}):
        is_plain = not lamps
        expected = solution.relight(
            reflectance=reflectance,
            emission=None if is_plain else emission,
            lights=None if is_plain else lights,
        )
        head, found = page.ask({sheet_back: paint}, lamps)
        assert head["is_final"]
        assert head["seconds"] > 0
        assert head["reflectance"][1] == head["reflectance"][int(sheet_back)] == pytest.approx(paint)
        np.testing.assert_array_equal(found["irradiance"][0, :n], expected.irradiance.astype(np.float32))
        np.testing.assert_array_equal(found["emission"][0, :n], expected.emission.astype(np.float32))
    # Lamps alone may be mixed from the light of each: the same but for what the solver leaves.
    for _ in range(2):
        _, found = page.ask({}, {"0": dimmed, "4": [0.0, 0.0, 0.0]})
        expected = solution.relight(emission=emission, lights=lights)
        scale = expected.irradiance.max()
        np.testing.assert_allclose(found["irradiance"][0, :n], expected.irradiance, atol=2e-3 * scale)
        np.testing.assert_allclose(found["emission"][0, :n], expected.emission, rtol=1e-6)
        time.sleep(1)  # by then, the light of each may be there
    _, found = page.ask({}, {})
    np.testing.assert_array_equal(found["irradiance"][0, :n], solution.irradiance.astype(np.float32))


@pytest.mark.parametrize("is_layered", [False, True])
def test_a_glimpse_comes_first_and_is_nearly_right(sessions: list[Session], is_layered: bool) -> None:
    solution = radiosity.solve(radiosity.scenes.cornell_box().patches(count=800), transport="sampled", accuracy=0.03)
    page = begin(sessions, solution, is_layered=is_layered)
    page.until(type="status", stage="ready")
    names = [surface.name for surface in solution.patches.scene.surfaces]
    page.session.take(Relight({str(names.index("floor")): [0.1, 0.2, 0.9]}, {"0": [0.5, 1.0, 2.0]}), page.hear)
    glimpse, early = page.until(type="light")
    answer, late = page.until(type="light")
    assert (glimpse["is_final"], answer["is_final"]) == (False, True)
    np.testing.assert_allclose(glimpse["reflectance"], answer["reflectance"])

    def rms(values: np.ndarray) -> float:
        return float(np.sqrt((solution.patches.area[:, None] * values**2).sum() / solution.patches.area.sum()))

    now, then = early["irradiance"].sum(axis=0), late["irradiance"].sum(axis=0)
    # What is left out is how much elements and the gather change the difference: a few parts in a hundred of it.
    assert rms(now - then) < 0.05 * rms(then - solution.irradiance)
    np.testing.assert_allclose(early["emission"], late["emission"], rtol=1e-6)


def test_layers_are_sent_and_repainted(sessions: list[Session], lit_room: radiosity.Solution) -> None:
    page = begin(sessions, lit_room, is_layered=True)
    page.until(type="status", stage="ready")
    head, arrays = [(head, arrays) for head, arrays in page.heard if head["type"] == "scene"][-1]
    assert head["is_layered"]
    assert len(arrays["irradiance"]) == len(head["lamps"]) == 5
    n, rho = len(lit_room.patches), lit_room.reflectance.copy()
    rho[lit_room.patches.surface == 0] = 0.1
    _, found = page.ask({"0": [0.1] * 3}, {})
    expected = lit_room.relight(reflectance=rho).irradiance
    np.testing.assert_allclose(found["irradiance"].sum(axis=0)[:n], expected, rtol=1e-5, atol=1e-5)
    _, half = page.ask({"0": [0.1] * 3}, {"1": [0.5] * 3})
    np.testing.assert_allclose(half["irradiance"][1], 0.5 * found["irradiance"][1], rtol=1e-5)
    np.testing.assert_allclose(half["irradiance"][0], found["irradiance"][0], rtol=1e-5)


def test_stop_keeps_the_best_so_far(sessions: list[Session], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solving, "BUDGET", 0.1)
    page = begin(sessions, radiosity.scenes.cornell_box(), accuracy=0.004)
    page.until(type="scene", is_lit=True)
    page.session.take(Stop(), page.hear)
    status, _ = page.until(type="status", stage="ready")
    assert status["can_relight"]
    assert "it was told to stop" in status["text"]
    last = next(head for head, _ in reversed(page.heard) if head["type"] in ("scene", "light"))
    assert last["report"]["limited_by"] == "observer"
    page.ask({}, {"0": [0.5] * 3})


def test_stop_leaves_rough_light(sessions: list[Session], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solving, "BUDGET", 1e9)
    page = begin(sessions, lamp_room())
    _, arrays = page.until(type="light")
    page.session.take(Stop(), page.hear)
    status, _ = page.until(type="status", stage="ready")
    assert not status["can_relight"]
    assert "open the scene again" in status["text"]
    assert arrays["irradiance"].any()


def test_the_latest_question_counts(sessions: list[Session], lit_room: radiosity.Solution) -> None:
    page = begin(sessions, lit_room)
    page.until(type="status", stage="ready")
    lamp = np.flatnonzero(lit_room.patches.surface == 2)[0]
    for k in range(1000):
        page.session.take(Relight({"0": [k / 2000] * 3}, {"0": [k] * 3}), page.hear)
    answers, shines = 0, 0.0
    while shines < 999:
        _, arrays = page.until(type="light")
        shines = arrays["emission"][0, lamp, 0] / lit_room.emission[lamp, 0]
        answers += 1
    assert answers < 100


def test_answers_go_to_who_asked(sessions: list[Session], lit_room: radiosity.Solution) -> None:
    page = begin(sessions, lit_room)
    page.until(type="status", stage="ready")
    other = Page(page.session)
    other.until(type="status", stage="ready")
    page.ask({}, {"0": [0.0] * 3})
    assert other._posts.empty()


def test_a_solve_that_fails_says_so(sessions: list[Session], monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise radiosity.ResourceError("no memory for this")

    monkeypatch.setattr(radiosity, "solve", fail)
    page = begin(sessions, radiosity.scenes.cornell_box())
    assert page.until(type="failed")[0]["message"] == "no memory for this"
    status, _ = page.until(type="status", stage="ready")
    assert (status["can_relight"], status["text"]) == (False, "the solve failed: no memory for this")


def test_a_relight_that_fails_says_so(
    sessions: list[Session], lit_room: radiosity.Solution, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = begin(sessions, lit_room)
    page.until(type="status", stage="ready")

    def fail(*_: object, **__: object) -> None:
        raise MemoryError

    monkeypatch.setattr(radiosity.Solution, "relight", fail)
    page.session.take(Relight({"0": [0.1] * 3}, {}), page.hear)
    assert "relighting failed: out of memory" in page.until(type="failed")[0]["message"]
    assert page.until(type="status", stage="ready")[0]["can_relight"]
    monkeypatch.undo()
    page.ask({"0": [0.1] * 3}, {})


def test_a_scene_that_cannot_be_lit_is_refused() -> None:
    with pytest.raises(radiosity.SceneError):
        Session(radiosity.Scene([]), Settings())


def test_layers_need_more_than_a_lit_model(lit_room: radiosity.Solution) -> None:
    with pytest.raises(ValueError, match="for layers, give the scene"):
        Session(LitModel.of(lit_room), Settings(is_layered=True))
