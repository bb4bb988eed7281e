"""How a hierarchical exchange grows: time to build, bytes, time of a product, and error.

    python benchmarks/hierarchy.py [--scenes crater room] [--counts 1000 4000 ... 1000000] [--tolerance 0.02]

The error is that of row sums, root mean square over area, against rays that the exchange was not
made from; and against all pairs, measured to a tenth of the tolerance, where there are few enough.
Each size runs in a process of its own, so that peak memory is its own.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from dataclasses import asdict, dataclass
from time import perf_counter

import numpy as np

import radiosity
from ladder import table
from machine import describe
from scale import peak_mib

MOST_PAIRS = 4_500
"""Patches that all pairs are measured of to compare with."""


@dataclass(frozen=True)
class Size:
    """One size: what it took and how wrong it is. Errors are of row sums, which are at most 1."""

    scene: str
    sides: int
    build_seconds: float
    bytes_per_side: float
    product_ms: float
    mean_sum: float
    error_by_rays: float
    error_of_pairs: float | None
    peak_mib: float


def main() -> None:
    """Measure one size, or start a process for each and print the tables."""
    args = arguments()
    if args.child is not None:
        print(json.dumps(asdict(measure(args.scenes[0], args.child, args))))
        return
    print(describe(), end="\n\n", flush=True)
    for scene in args.scenes:
        sizes = [in_process(scene, count, args) for count in args.counts]
        print(report(sizes), flush=True)
        print(exponents(sizes), end="\n\n", flush=True)


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Growth of a hierarchical exchange")
    parser.add_argument("--scenes", nargs="+", choices=["crater", "room"], default=["crater", "room"])
    parser.add_argument("--counts", type=int, nargs="+", default=[1_000, 4_000, 16_000, 64_000, 250_000, 1_000_000])
    parser.add_argument("--tolerance", type=float, default=0.02)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--child", type=int, help=argparse.SUPPRESS)
    return parser.parse_args()


def in_process(scene: str, count: int, args: argparse.Namespace) -> Size:
    """Measure one size by itself."""
    command = [sys.executable, __file__, "--scenes", scene, "--child", str(count)]
    command += ["--tolerance", str(args.tolerance), "--threads", str(args.threads)]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    size = Size(**json.loads(done.stdout.splitlines()[-1]))
    print(f"  {size}", file=sys.stderr, flush=True)
    return size


def measure(scene: str, count: int, args: argparse.Namespace) -> Size:
    """Build, multiply, compare."""
    patches = (
        radiosity.scenes.crater(count).patches(as_is=True)
        if scene == "crater"
        else radiosity.scenes.furnished_room().patches(count=count)
    )
    _ = patches._enclosure  # the ray hierarchy, which all methods need
    start = perf_counter()
    F = radiosity.form_factors(patches, method="hierarchical", tolerance=args.tolerance, threads=args.threads)
    seconds = perf_counter() - start
    peak = peak_mib()
    x = np.random.default_rng(1).random(F.shape[0])
    F @ x
    start = perf_counter()
    for _ in range(5):
        F @ x
    product = (perf_counter() - start) / 5
    sums = F.closure()
    return Size(
        scene, F.shape[0], seconds, F.report.memory_bytes / F.shape[0], 1e3 * product,
        float(np.average(sums, weights=F.area)), F.report.estimated_error,
        against_pairs(F, patches, args) if F.shape[0] <= MOST_PAIRS else None, peak,
    )  # fmt: skip


def against_pairs(F: radiosity.FormFactors, patches: radiosity.Patches, args: argparse.Namespace) -> float:
    """Root mean square error of row sums against all pairs."""
    exact = radiosity.form_factors(patches, method="auto", tolerance=0.1 * args.tolerance, threads=args.threads)
    return float(np.sqrt(np.average((F.closure() - exact.closure()) ** 2, weights=F.area)))


def report(sizes: list[Size]) -> str:
    """A table, one line a size."""
    header = ["scene", "sides", "build", "bytes a side", "product", "mean sum", "error (rays)", "(pairs)", "peak"]
    rows = [
        [
            s.scene, f"{s.sides:,}", f"{s.build_seconds:.2f} s", f"{s.bytes_per_side:.0f}", f"{s.product_ms:.1f} ms",
            f"{s.mean_sum:.3f}", f"{s.error_by_rays:.1e}",
            "" if s.error_of_pairs is None else f"{s.error_of_pairs:.1e}", f"{s.peak_mib:.0f} MiB",
        ]
        for s in sizes
    ]  # fmt: skip
    return table(header, rows)


def exponents(sizes: list[Size]) -> str:
    """Powers of the number of sides that time and memory grow with, least squares over all sizes."""
    n = np.log([s.sides for s in sizes])

    def power(values: list[float]) -> float:
        return float(np.polyfit(n, np.log(values), 1)[0])

    return (
        f"exponents: build {power([s.build_seconds for s in sizes]):.2f}, "
        f"memory {power([s.sides * s.bytes_per_side for s in sizes]):.2f}, "
        f"product {power([s.product_ms for s in sizes]):.2f}"
    )


if __name__ == "__main__":
    main()
