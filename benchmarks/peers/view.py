"""The picture of the Cornell box that renderers are held to, and how far another is off.

Only NumPy is needed here, so that each tool can import it from its own environment.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from math import radians
from pathlib import Path
from statistics import mean, median
from time import perf_counter, process_time

import numpy as np
from numpy.typing import NDArray

from peers.reference import emit

Picture = NDArray[np.float64]

SIZE = 128  # pixels a side
REFERENCE = Path(__file__).resolve().parents[1] / ".peers" / "pictures" / f"cornell_{SIZE}.npz"
MOST = 3.0  # W/m2/sr: pixels that show more than this, or are beside one, show the lamp


@dataclass(frozen=True)
class View:
    """A perspective camera, metres; full vertical angle of view in degrees."""

    position: tuple[float, float, float]
    target: tuple[float, float, float]
    up: tuple[float, float, float]
    angle: float


CORNELL = View((0.278, 0.273, -0.8), (0.278, 0.273, 0.0), (0.0, 1.0, 0.0), 39.3077)


@dataclass(frozen=True)
class Reference:
    """A converged picture, (SIZE, SIZE, 3), and half of the difference of its halves, as large as its noise."""

    picture: Picture
    noise: Picture

    @classmethod
    def load(cls) -> Reference:
        """Read the file that the reference tool wrote."""
        with np.load(REFERENCE) as arrays:
            return cls(arrays["picture"], arrays["noise"])

    def off(self, picture: Picture) -> float:
        """Relative RMS error: over pixels that do not show the lamp and bands, over their mean.

        The reference's own noise is subtracted in squares.
        """
        kept = ~self.shows_lamp()
        square = np.mean((picture - self.picture)[kept] ** 2) - np.mean(self.noise[kept] ** 2)
        return float(np.sqrt(max(square, 0.0)) / self.picture[kept].mean())

    def shows_lamp(self) -> NDArray[np.bool_]:
        """Pixels that show the lamp, and those beside them: there the edge of the lamp is all that counts."""
        bright = np.pad(self.picture.max(axis=2) > MOST, 1)
        near = [bright[i : i + SIZE, j : j + SIZE] for i in range(3) for j in range(3)]
        return np.asarray(np.any(near, axis=0))


def arguments(description: str) -> argparse.ArgumentParser:
    """The arguments that every tool takes."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--repetitions", type=int, default=2)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    return parser


def climb(rungs: dict[str, Callable[[int], Picture]], args: argparse.Namespace) -> None:
    """Time every rung, a function of the seed, and print a line for each."""
    reference = Reference.load()
    for settings, draw in rungs.items():
        seconds, cpu_seconds, errors = [], [], []
        for repetition in range(args.repetitions):
            start, cpu_start = perf_counter(), process_time()
            picture = draw(100 * args.seed + repetition)
            seconds.append(perf_counter() - start)
            cpu_seconds.append(process_time() - cpu_start)
            errors.append(reference.off(np.asarray(picture, dtype=np.float64)))
        emit(settings=settings, seconds=median(seconds), cpu_seconds=median(cpu_seconds), error=mean(errors))


def angle(view: View) -> float:
    """The angle of view in radians."""
    return radians(view.angle)
