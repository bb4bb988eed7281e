"""A scene that is served: solved before one's eyes, relit from the page, and no one else's business."""

from __future__ import annotations

import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from browsing import Open
from playwright.sync_api import Browser, Page

import radiosity

ACCURACY = 0.1


@pytest.fixture
def address() -> Iterator[str]:
    """Of a server of the Cornell box, which is still dark when it begins."""
    command = [sys.executable, "-m", "radiosity", "view", "builtin:cornell-box", "--no-browser"]
    with subprocess.Popen(
        [*command, "--accuracy", str(ACCURACY)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as server:
        assert server.stdout is not None
        for line in server.stdout:
            if found := re.search(r"http://127\.0\.0\.1:\d+/\S+", line):
                yield found[0]
                break
        else:
            pytest.fail("the server printed no address")
        server.terminate()


def until(page: Page, expression: str, seconds: float = 90.0) -> None:
    """Wait; what a page may evaluate by itself is forbidden to it."""
    end = time.monotonic() + seconds
    while not page.evaluate(expression):
        assert time.monotonic() < end, expression
        page.wait_for_timeout(50)


def points(page: Page) -> list[tuple[str, float]]:
    """Stage and error of what the page has heard of the error so far."""
    return [(stage, error) for stage, error in page.evaluate("window.heard.map(({ stage, error }) => [stage, error])")]


def test_a_scene_is_solved_before_ones_eyes_and_relit(open_page: Open, address: str) -> None:
    page = open_page(address, width=1100, height=600, ready=False)
    page.evaluate(
        "(window.heard = []) && radiosity.app.events.on('message', m => m.type === 'convergence' && heard.push(m))"
    )
    page.evaluate("radiosity.ready")
    until(page, "radiosity.app.light.control.canRelight")
    solved = [error for stage, error in points(page) if stage == "solving"]
    assert solved[-1] == min(solved) <= ACCURACY
    shot = [error for stage, error in points(page) if stage == "shooting"]
    assert shot == sorted(shot, reverse=True)

    # The page has the solution that Python finds, and asks for the light in other paint.
    scene = radiosity.scenes.cornell_box()
    solution = radiosity.solve(scene, accuracy=ACCURACY)
    names = [surface.name for surface in scene.surfaces]
    floor = int(np.flatnonzero(solution.patches.surface == names.index("floor"))[0])

    def arrives(patch: int) -> list[float]:
        return [float(x) for x in page.evaluate(f"radiosity.app.lit.of({patch}).irradiance")]

    assert np.allclose(arrives(floor), solution.irradiance[floor], rtol=1e-5)
    page.evaluate(
        "(window.answers = []) && radiosity.app.light.control.relighting.events.on('answered', a => answers.push(a))"
    )
    page.evaluate("radiosity.paint('back', [0.05, 0.05, 0.9])")
    rho = solution.reflectance.copy()
    rho[solution.patches.surface == names.index("back")] = (0.05, 0.05, 0.9)
    expected = solution.relight(reflectance=rho)
    until(page, "answers.length > 0")
    assert page.evaluate("answers[0].took") < 5000  # milliseconds; how many is for the benchmarks

    def is_there(values: Callable[[], list[float]], wanted: np.ndarray) -> bool:
        return bool(np.allclose(values(), wanted, rtol=1e-4))

    end = time.monotonic() + 30
    while not is_there(lambda: arrives(floor), expected.irradiance[floor]):
        assert time.monotonic() < end
        page.wait_for_timeout(50)
    said = page.evaluate("radiosity.app.lit.head.surfaces.map((_, k) => radiosity.app.lit.reflectanceOf(k))")
    assert np.allclose(said[names.index("back")], (0.05, 0.05, 0.9))


def test_another_origin_gets_nothing(browser: Browser, address: str) -> None:
    page = browser.new_context().new_page()
    page.goto("about:blank")
    said = page.evaluate(
        """async address => {
          const socket = new WebSocket(address.replace("http", "ws") + "socket");
          return await new Promise(done => {
            socket.onopen = () => done("open");
            socket.onerror = () => done("refused");
          });
        }""",
        address,
    )
    assert said == "refused"
    page.context.close()
