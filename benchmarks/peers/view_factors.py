"""What every view-factor program of the comparison does alike: read the scene, run, report as one JSON line.

Only NumPy is needed here, so that each program can be run from its own environment.
"""

from __future__ import annotations

import argparse
import resource
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from factor_scenes import Scene, scene
from peers.reference import emit


@dataclass(frozen=True)
class Answer:
    """What a program computed."""

    factors: NDArray[np.floating]  # (n, n), F[i, j] from i to j
    seconds: float  # to compute them, without start-up
    peak: int  # bytes of the process that computed, before anything was converted


def parser(description: str) -> argparse.ArgumentParser:
    """The arguments that every program takes."""
    result = argparse.ArgumentParser(description=description)
    result.add_argument("scene")
    result.add_argument("out", type=Path, help="the factors are written here, as .npy")
    result.add_argument("--threads", type=int, default=2)
    return result


def report(args: argparse.Namespace, factors: Callable[[Scene], Answer], settings: str) -> None:
    """Run the program on the scene, write the factors and print one line."""
    answer = factors(scene(args.scene))
    np.save(args.out, answer.factors)
    emit(settings=settings, seconds=answer.seconds, peak=answer.peak)


def peak_of(who: int = resource.RUSAGE_SELF) -> int:
    """Largest memory so far of this process or of its finished children, bytes."""
    unit = 1 if sys.platform == "darwin" else 1024
    return unit * resource.getrusage(who).ru_maxrss
