"""A build that is killed at any moment goes on, and ends in the same bytes."""

from __future__ import annotations

import random
import subprocess
import sys
import time
from pathlib import Path

import pytest

BUILD = """
import sys, radiosity
patches = radiosity.scenes.cornell_box().patches(count=int(sys.argv[2]))
radiosity.form_factors(patches, method=sys.argv[3], tolerance=1e-3, checkpoint=sys.argv[1])
"""

BUILDS = {"auto": 1200, "hierarchical": 8000}
"""Methods that write block by block, and patches for which that takes some seconds."""


def start(path: Path, method: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen([sys.executable, "-c", BUILD, str(path), str(BUILDS[method]), method])


def size(path: Path) -> int:
    return path.stat().st_size if path.exists() else 0


def kill_at(process: subprocess.Popen[bytes], partial: Path, delay: float, wait_for_blocks: bool) -> None:
    """Kill a build after ``delay`` seconds, counted from its start or from when it has appended something."""
    begun = size(partial)
    while wait_for_blocks and process.poll() is None and size(partial) <= begun:
        time.sleep(0.001)
    time.sleep(delay)
    process.kill()
    process.wait()


@pytest.mark.slow
@pytest.mark.parametrize("method", BUILDS)
def test_killed_twenty_times(tmp_path: Path, method: str) -> None:
    start(tmp_path / "whole.exchange", method).wait()
    content = (tmp_path / "whole.exchange").read_bytes()
    path, rng, kills, whole = tmp_path / "F.exchange", random.Random(4), 0, 0
    partial = path.with_name("F.exchange.partial")
    grown = []
    while kills < 20:
        # Half of them as the process starts, opens the partial file and checks it; half soon after a block.
        soon = rng.random() < 0.5
        kill_at(start(path, method), partial, rng.uniform(0, 1.0) if soon else rng.uniform(0, 0.1), not soon)
        kills += 1
        grown.append(size(partial))
        if path.exists():
            assert path.read_bytes() == content
            path.unlink()
            whole += 1
    start(path, method).wait()
    assert path.read_bytes() == content
    assert not partial.exists()
    assert len(set(grown)) > 5, "builds were killed at different places"
