"""The engine of this repository on the Cornell reference; prints one JSON line per accuracy asked for.

    python -m engine [--accuracies 0.05 0.02 0.01] [--repetitions 4] [--threads 2] [--seed 1]

Timed is everything from arrays in memory to the solution: scene, patches, solve, afresh in each
repetition. Importing, and one small solve that loads the library's pages, are not timed.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from statistics import mean, median
from time import perf_counter, process_time

import numpy as np

import radiosity
from peers.reference import (
    Array,
    Face,
    Reference,
    emit,
    faces,
    load,
    passive,
    rel_rms,
    weighted_mean,
    weighted_rms,
)

ACCURACIES = [0.1, 0.07, 0.05, 0.03, 0.02, 0.014, 0.01, 0.007]


@dataclass(frozen=True)
class FaceArrays:
    """One face of the grid as the engine takes it."""

    name: str
    vertices: Array  # ((nu + 1) * (nv + 1), 3)
    quads: np.ndarray  # (nu * nv, 4) int
    reflectance: Array  # (3,)
    exitance: Array  # (3,)


@dataclass(frozen=True)
class Run:
    """One repetition."""

    seconds: float
    cpu_seconds: float
    solve_seconds: float
    error: float
    estimated: float


def main() -> None:
    """Solve at each accuracy and print what it took and reached."""
    args = arguments()
    ref = load()
    grid = [face_arrays(f, ref) for f in faces(ref)]
    run(ref, grid, max(args.accuracies), args.threads, 0)
    for accuracy in args.accuracies:
        seeds = (100 * args.seed + r for r in range(args.repetitions))
        runs = [run(ref, grid, accuracy, args.threads, seed) for seed in seeds]
        emit(
            settings=f"accuracy {accuracy:g}",
            seconds=median(r.seconds for r in runs),
            cpu_seconds=median(r.cpu_seconds for r in runs),
            error=mean(r.error for r in runs),
            estimated=mean(r.estimated for r in runs),
            solve_seconds=median(r.solve_seconds for r in runs),
        )


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="This engine on the Cornell reference")
    parser.add_argument("--accuracies", type=float, nargs="+", default=ACCURACIES)
    parser.add_argument("--repetitions", type=int, default=4)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    return parser.parse_args()


def face_arrays(face: Face, ref: Reference) -> FaceArrays:
    """The face as a welded grid of quads, patches in the order of the reference."""
    quads = ref["quads"][face.patches].reshape(face.nv, face.nu, 4, 3)
    vertices = np.empty((face.nv + 1, face.nu + 1, 3))
    vertices[:-1, :-1] = quads[:, :, 0]
    vertices[:-1, -1] = quads[:, -1, 1]
    vertices[-1, :-1] = quads[-1, :, 3]
    vertices[-1, -1] = quads[-1, -1, 2]
    index = np.arange(vertices.size // 3).reshape(face.nv + 1, face.nu + 1)
    corners = [index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]]
    return FaceArrays(
        name=face.name,
        vertices=vertices.reshape(-1, 3),
        quads=np.stack(corners, axis=-1).reshape(-1, 4),
        reflectance=face.reflectance,
        exitance=np.pi * face.radiance,
    )


def run(ref: Reference, grid: list[FaceArrays], accuracy: float, threads: int, seed: int) -> Run:
    """One solution from arrays in memory."""
    start, cpu_start = perf_counter(), process_time()
    scene = radiosity.Scene([radiosity.Surface(f.vertices, f.quads, f.reflectance, f.exitance, f.name) for f in grid])
    patches = scene.patches(as_is=True)
    solve_start = perf_counter()
    solution = radiosity.solve(patches, accuracy=accuracy, threads=threads, seed=seed)
    irradiance = np.asarray(solution.irradiance)
    end, cpu_end = perf_counter(), process_time()
    return Run(
        seconds=end - start,
        cpu_seconds=cpu_end - cpu_start,
        solve_seconds=end - solve_start,
        error=rel_rms(irradiance, ref),
        estimated=estimated_error(irradiance, np.asarray(solution.error), ref),
    )


def estimated_error(irradiance: Array, error: Array, ref: Reference) -> float:
    """What the engine believes of itself, in the measure of ``rel_rms``."""
    m = passive(ref)
    area = ref["area"][m]
    return weighted_rms(error[m], area) / weighted_mean(irradiance[m], area)


if __name__ == "__main__":
    main()
