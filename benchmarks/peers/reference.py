"""The Cornell reference, its rectangular faces and the error measure that every tool is held to.

Only NumPy is needed here, so that each tool can import it from its own environment.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from statistics import mean, median
from time import perf_counter, process_time
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Reference = dict[str, NDArray[Any]]

REPOSITORY = Path(__file__).resolve().parents[2]
CORNELL = REPOSITORY / "validation" / "references" / "cornell_irradiance.npz"


@dataclass(frozen=True)
class Face:
    """A rectangle of nu x nv patches; patch (i, j) has index ``start + j * nu + i``."""

    name: str
    origin: Array  # (3,) corner of patch (0, 0)
    u: Array  # (3,) first edge
    v: Array  # (3,) second edge; u x v points to the lit side
    nu: int
    nv: int
    start: int
    reflectance: Array  # (3,)
    radiance: Array  # (3,) emitted

    @property
    def emits(self) -> bool:
        """Whether the face is a light."""
        return bool(self.radiance.any())

    @property
    def normal(self) -> Array:
        """Unit normal of the lit side, (3,)."""
        n = np.cross(self.u, self.v)
        return n / np.linalg.norm(n)

    @property
    def corners(self) -> Array:
        """The four corners, right-hand rule about the normal, (4, 3)."""
        o = self.origin
        return np.array([o, o + self.u, o + self.u + self.v, o + self.v])

    @property
    def patches(self) -> slice:
        """Where the patches of this face stand among all patches."""
        return slice(self.start, self.start + self.nu * self.nv)

    @property
    def material(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Reflectance and radiance; faces that share them share a material."""
        return tuple(self.reflectance.tolist()), tuple(self.radiance.tolist())


def load() -> Reference:
    """Read the Cornell reference."""
    with np.load(CORNELL) as arrays:
        return dict(arrays)


def faces(ref: Reference) -> list[Face]:
    """The rectangular faces in the order of their patches."""
    return [
        _face(ref, str(name), *(int(n) for n in grid))
        for name, grid in zip(ref["face_name"], ref["face_grid"], strict=True)
    ]


def _face(ref: Reference, name: str, nu: int, nv: int, start: int) -> Face:
    quads = ref["quads"][start : start + nu * nv]
    origin = quads[0, 0]
    return Face(
        name=name,
        origin=origin,
        u=quads[nu - 1, 1] - origin,
        v=quads[-nu, 3] - origin,
        nu=nu,
        nv=nv,
        start=start,
        reflectance=ref["reflectance"][start],
        radiance=ref["emission"][start],
    )


def passive(ref: Reference) -> NDArray[np.bool_]:
    """The patches that emit nothing, which are the ones that count."""
    return np.asarray(ref["emission"].sum(axis=1) == 0, dtype=np.bool_)


def rel_rms(irradiance: Array, ref: Reference) -> float:
    """Area-weighted RMS error over the three bands / area-weighted mean of the reference.

    Emitting patches are left out: no renderer bakes light onto a black emitter.
    """
    m = passive(ref)
    return weighted_rms(irradiance[m] - ref["E"][m], ref["area"][m]) / weighted_mean(ref["E"][m], ref["area"][m])


def weighted_rms(values: Array, area: Array) -> float:
    """Root of the area-weighted mean square over patches and bands."""
    return float(np.sqrt(np.average((values**2).mean(axis=1), weights=area)))


def weighted_mean(values: Array, area: Array) -> float:
    """Area-weighted mean over patches and bands."""
    return float(np.average(values.mean(axis=1), weights=area))


def emit(**row: object) -> None:
    """Print one JSON line for the process that reads this tool."""
    print(json.dumps(row), flush=True)


def ladder_arguments(description: str, samples: list[int]) -> argparse.ArgumentParser:
    """The arguments that every peer takes; ``samples`` is its usual ladder."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--samples", type=int, nargs="+", default=samples, metavar="N")
    parser.add_argument("--repetitions", type=int, default=2)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    return parser


def climb(solve: Callable[[int, int], Array], ref: Reference, args: argparse.Namespace, settings: str) -> None:
    """Time ``solve(samples, seed)`` on every rung of the ladder and print a line for each.

    ``settings`` describes a rung; ``{}`` in it stands for the number of samples.
    """
    for samples in args.samples:
        runs = list(_timed(solve, samples, args.seed, args.repetitions))
        emit(
            settings=settings.format(samples),
            seconds=median(s for s, _, _ in runs),
            cpu_seconds=median(c for _, c, _ in runs),
            error=mean(rel_rms(e, ref) for _, _, e in runs),
        )


def _timed(
    solve: Callable[[int, int], Array], samples: int, seed: int, repetitions: int
) -> Iterator[tuple[float, float, Array]]:
    """Wall seconds, processor seconds of all threads, and irradiance of each repetition."""
    for repetition in range(repetitions):
        start, cpu_start = perf_counter(), process_time()
        irradiance = solve(samples, 100 * seed + repetition)
        yield perf_counter() - start, process_time() - cpu_start, irradiance
