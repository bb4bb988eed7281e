"""How time and memory of this engine grow with the number of patches.

    python benchmarks/scale.py [--counts 10000 30000 100000] [--accuracy 0.02] [--threads 2]

The furnished room is meshed more and more finely and solved to the same accuracy; each count runs
in a process of its own, so that peak memory is its own.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from time import perf_counter

import numpy as np

import radiosity
from ladder import table
from machine import describe


@dataclass(frozen=True)
class Size:
    """One count of patches: what it took and reached."""

    asked: int
    patches: int
    mesh_seconds: float
    solve_seconds: float
    peak_mib: float
    estimated: float


def main() -> None:
    """Measure one count, or start a process for each and print the table."""
    args = arguments()
    if args.child is not None:
        print(json.dumps(asdict(measure(args.child, args))))
        return
    print(describe(), end="\n\n", flush=True)
    sizes = [in_process(count, args) for count in args.counts]
    print(report(sizes))
    if len(sizes) > 1:
        print(exponents(sizes))


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Time and memory against the number of patches")
    parser.add_argument("--counts", type=int, nargs="+", default=[10_000, 30_000, 100_000])
    parser.add_argument("--accuracy", type=float, default=0.02)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--child", type=int, help=argparse.SUPPRESS)
    return parser.parse_args()


def in_process(count: int, args: argparse.Namespace) -> Size:
    """Measure one count in a process of its own."""
    flags = [f"--{name}={getattr(args, name)}" for name in ("accuracy", "threads", "seed")]
    command = [sys.executable, __file__, f"--child={count}", *flags]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"{count} patches: exit status {done.returncode}")
    return Size(**json.loads(done.stdout.splitlines()[-1]))


def measure(count: int, args: argparse.Namespace) -> Size:
    """Mesh and solve the furnished room."""
    scene = radiosity.scenes.furnished_room()
    start = perf_counter()
    patches = scene.patches(count=count)
    meshed = perf_counter()
    solution = radiosity.solve(patches, accuracy=args.accuracy, threads=args.threads, seed=args.seed)
    irradiance, error = np.asarray(solution.irradiance), np.asarray(solution.error)
    solved = perf_counter()
    return Size(
        asked=count,
        patches=len(irradiance),
        mesh_seconds=meshed - start,
        solve_seconds=solved - meshed,
        peak_mib=peak_mib(),
        estimated=relative(error, irradiance, np.asarray(solution.patches.area)),
    )


def peak_mib() -> float:
    """The most memory that this process has held; kilobytes on Linux, bytes on macOS."""
    unit = 2**20 if sys.platform == "darwin" else 2**10
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit


def relative(error: np.ndarray, irradiance: np.ndarray, area: np.ndarray) -> float:
    """Area-weighted RMS of the estimated error over the area-weighted mean irradiance."""
    square = np.average((error**2).mean(axis=1), weights=area)
    return float(np.sqrt(square) / np.average(irradiance.mean(axis=1), weights=area))


def report(sizes: Sequence[Size]) -> str:
    """The table of what was measured."""
    header = ["asked", "patches", "mesh s", "solve s", "us / patch", "peak MiB", "estimated %"]
    rows = [
        [
            f"{s.asked}",
            f"{s.patches}",
            f"{s.mesh_seconds:.2f}",
            f"{s.solve_seconds:.2f}",
            f"{1e6 * s.solve_seconds / s.patches:.1f}",
            f"{s.peak_mib:.0f}",
            f"{100 * s.estimated:.2f}",
        ]
        for s in sizes
    ]
    return table(header, rows)


def exponents(sizes: Sequence[Size]) -> str:
    """The powers of the number of patches that time and memory follow."""
    patches = [s.patches for s in sizes]
    time = exponent(patches, [s.solve_seconds for s in sizes])
    memory = exponent(patches, [s.peak_mib for s in sizes])
    return f"solve time ~ patches^{time:.2f}, peak memory ~ patches^{memory:.2f}"


def exponent(x: Sequence[float], y: Sequence[float]) -> float:
    """Slope of the straight line through log y against log x.

    >>> round(exponent([1, 2, 4], [3, 12, 48]), 6)
    2.0
    """
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


if __name__ == "__main__":
    main()
