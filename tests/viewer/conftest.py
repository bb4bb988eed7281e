"""Small scenes with lamps of every kind, a page to serve, and a server of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from rooms import lamp_room

import radiosity
from radiosity.viewer import page
from radiosity.viewer.server import Server
from radiosity.viewer.session import Session
from radiosity.viewer.settings import Settings

PAGE = "<!doctype html>\n<html><head><title>radiosity</title></head>\n<body>\n<p>page</p></body></html>\n"


@pytest.fixture
def built(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A page as ``make viewer`` leaves it, where there are no sources of it."""
    bundle = tmp_path / "bundle.html"
    bundle.write_text(PAGE)
    monkeypatch.setattr(page, "BUNDLE", bundle)
    monkeypatch.setattr(page, "SOURCES", tmp_path / "no checkout")
    return bundle


@pytest.fixture(scope="session")
def lit_room() -> radiosity.Solution:
    """The room, on a few hundred patches."""
    return radiosity.solve(lamp_room().patches(count=300), accuracy=0.05)


Serve = Callable[..., Server]


@pytest.fixture
def serve(built: Path) -> Iterator[Serve]:
    """Serve something until the end of the test."""
    running: list[Server] = []

    def serve(what: object, **settings: object) -> Server:
        server = Server(Session(what, Settings(**settings)))  # type: ignore[arg-type]
        server.__enter__()
        running.append(server)
        return server

    yield serve
    for server in running:
        server.__exit__(None, None, None)
