"""A solution that many tests look at, and ways to run the command line."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from known import Call, Runner

import radiosity
from radiosity.cli.app import app


@pytest.fixture(scope="session")
def cornell() -> radiosity.Solution:
    """The Cornell box to 5 %, on some 800 patches."""
    return radiosity.solve(radiosity.scenes.cornell_box().patches(count=800), accuracy=0.05)


@pytest.fixture
def run(tmp_path: Path) -> Runner:
    """Run the command line in an empty folder and collect what it says."""

    def run(*arguments: object, **options: object) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "radiosity", *map(str, arguments)]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False, **options)

    return run


@pytest.fixture
def call(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Call:
    """Run a command within this process, for what needs no process of its own; returns its stdout."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RAYON_NUM_THREADS", "2")  # which commands set for good

    def call(*arguments: object) -> str:
        assert not app(args=list(map(str, arguments)), standalone_mode=False)
        return capsys.readouterr().out

    return call


@pytest.fixture
def start(tmp_path: Path) -> Callable[..., subprocess.Popen[str]]:
    """Start the command line in an empty folder, with Ctrl-C as a terminal would have it."""

    def listen() -> None:
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    def start(*arguments: object) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", "radiosity", *map(str, arguments)]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        return subprocess.Popen(command, cwd=tmp_path, text=True, preexec_fn=listen, **pipes)  # noqa: PLW1509

    return start
