"""A headless browser with WebGL2 by software: one of this machine, or the one that npm ships."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browsing import Open
from playwright.sync_api import Browser, ConsoleMessage, Page, sync_playwright

from radiosity.viewer.lit import Lit
from radiosity.viewer.page import with_scene

VIEWER = Path(__file__).parents[2] / "viewer"
NAMES = ("chromium", "chromium-browser", "google-chrome")
FLAGS = [
    "--no-sandbox", "--no-first-run", "--disable-quic", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--ignore-gpu-blocklist",
    "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
]  # fmt: skip


def found_browser() -> tuple[str, dict[str, str]]:
    """The executable and the environment it needs."""
    own = os.environ.get("RADIOSITY_CHROMIUM") or next(filter(None, map(shutil.which, NAMES)), None)
    if own:
        return own, {}
    said = json.loads(subprocess.run(["node", VIEWER / "browser.mjs"], check=True, capture_output=True).stdout)
    return said["executable"], {"LD_LIBRARY_PATH": said["libraries"]}


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    executable, environment = found_browser()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=executable, args=FLAGS, env={**os.environ, **environment}, timeout=120_000
        )
        yield browser
        browser.close()


@pytest.fixture
def open_page(browser: Browser) -> Iterator[Open]:
    """Opens an address, waits until there is a picture, and fails the test if the page complained."""
    complaints: list[str] = []
    pages: list[Page] = []

    def hear(message: ConsoleMessage) -> None:
        if message.type == "error":
            complaints.append(message.text)

    def open_(address: str, *, width: int = 512, height: int = 512, offline: bool = False, ready: bool = True) -> Page:
        page = browser.new_context(viewport={"width": width, "height": height}, offline=offline).new_page()
        pages.append(page)
        page.on("console", hear)
        page.on("pageerror", lambda error: complaints.append(error.message))
        page.set_default_timeout(60_000)
        page.goto(address)
        if ready:
            page.evaluate("radiosity.ready")
        return page

    yield open_
    for page in pages:
        page.context.close()
    assert not complaints


@pytest.fixture
def open_lit(open_page: Open, tmp_path: Path) -> Open:
    """Opens the exported page of a lit scene, without a network."""

    def open_(lit: Lit, **options: Any) -> Page:
        path = tmp_path / "page.html"
        path.write_text(with_scene(lit), encoding="utf-8")
        return open_page(path.as_uri(), offline=True, **options)

    return open_
