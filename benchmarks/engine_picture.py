"""The engine of this repository: a picture of the Cornell box, by radiosity or by its own path tracer.

    python -m engine_picture --method gather|smooth|path

Timed is everything from the scene to the picture, solving included. Importing is not.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

import radiosity
from peers.view import CORNELL, SIZE, Picture, angle, arguments, climb
from radiosity.picture import render

GATHERS = [(0.1, 4), (0.1, 16), (0.1, 32), (0.05, 64), (0.03, 128), (0.03, 256)]
"""Accuracies of the solution and samples of the gather."""

ACCURACIES = [0.1, 0.05, 0.03, 0.02, 0.01]
PATHS = [16, 64, 256, 1024, 4096]

EYE = radiosity.Camera.look_at(CORNELL.position, CORNELL.target, CORNELL.up, angle(CORNELL))


def main() -> None:
    """Climb the ladder of the method asked for."""
    parser = arguments("This engine: a picture of the Cornell box")
    parser.add_argument("--method", choices=("gather", "smooth", "path"), default="gather")
    args = parser.parse_args()
    gathers: dict[str, Callable[[int], Picture]] = {
        f"accuracy {accuracy:g}, {samples} rays": partial(gathered, accuracy, samples, args.threads)
        for accuracy, samples in GATHERS
    }
    smooth = {f"accuracy {accuracy:g}": partial(smoothed, accuracy, args.threads) for accuracy in ACCURACIES}
    paths = {f"{samples} paths": partial(traced, samples, args.threads) for samples in PATHS}
    gathered(0.1, 4, args.threads, 0)
    climb({"gather": gathers, "smooth": smooth, "path": paths}[args.method], args)


def gathered(accuracy: float, samples: int, threads: int, seed: int) -> Picture:
    """Solve and gather."""
    scene = radiosity.scenes.cornell_box()
    solution = radiosity.solve(scene, accuracy=accuracy, threads=threads, seed=seed)
    size = {"width": SIZE, "height": SIZE}
    return np.asarray(render(solution, EYE, mode="gather", samples=samples, threads=threads, seed=seed, **size))  # type: ignore[arg-type]


def smoothed(accuracy: float, threads: int, seed: int) -> Picture:
    """Solve and interpolate."""
    scene = radiosity.scenes.cornell_box()
    solution = radiosity.solve(scene, accuracy=accuracy, threads=threads, seed=seed)
    return np.asarray(render(solution, EYE, samples=64, threads=threads, width=SIZE, height=SIZE))


def traced(samples: int, threads: int, seed: int) -> Picture:
    """Trace paths."""
    scene = radiosity.scenes.cornell_box()
    size = {"width": SIZE, "height": SIZE}
    return np.asarray(radiosity.path_trace(scene, EYE, samples=samples, threads=threads, seed=seed, **size).image)


if __name__ == "__main__":
    main()
