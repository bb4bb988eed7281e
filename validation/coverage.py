"""How the errors that solutions report compare with those that they have, on scenes with known answers.

    .venv/bin/python validation/coverage.py [--ways sampled hierarchical shooting] [--accuracies 0.05 0.02] [--seeds 3]
        [--scenes NAME ...] [--count 600] [--markdown]

Prints a row for every way, scene and accuracy: the median over seeds of the reported and of the true error, the least,
median and largest ratio of the two, and the signed error of the mean irradiance over its reported error. A ratio below
1 means that the report was too kind; with three seeds, and errors that are themselves estimates from four replicates,
ratios within some 0.8 to 1.3 are what an honest report gives.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from functools import cache

import numpy as np
from known_answers import KNOWN, Known, Means, true_error_of_means

import radiosity

WAYS = ("sampled", "hierarchical", "shooting")


@dataclass(frozen=True)
class Try:
    """One solve: what it says of itself and what is true, relative to the mean irradiance."""

    reported: float
    true: float
    discretisation: float
    bias: float
    limited_by: str
    seconds: float

    @property
    def ratio(self) -> float:
        """Reported over true; an error below rounding counts as known."""
        return self.reported / self.true if self.true > 1e-7 else np.inf


@cache
def truth_of(known: Known, count: int) -> tuple[radiosity.Patches, Means]:
    """The mesh and its truth, which take longer than a solve."""
    patches = known.mesh(count)
    return patches, known.patch_means(patches)


def tried(known: Known, way: str, accuracy: float, seed: int, count: int) -> Try:
    """Solve once and compare."""
    patches, truth = truth_of(known, count)
    chosen: dict[str, str] = {"solver": way} if way == "shooting" else {"transport": way}
    begun = time.perf_counter()
    solution = radiosity.solve(patches, accuracy=accuracy, seed=seed, **chosen)  # type: ignore[arg-type]
    seconds, report = time.perf_counter() - begun, solution.report
    counts = known.counts(patches)
    weight = (patches.area * counts)[:, None]
    level = (weight * truth.value).sum()
    return Try(
        report.estimated_error, true_error_of_means(patches, solution.irradiance, truth, counts),
        report.discretisation_error, (weight * solution.irradiance).sum() / level - 1, report.limited_by or "", seconds,
    )  # fmt: skip


def row(name: str, way: str, accuracy: float, tries: list[Try]) -> list[str]:
    """One line of the table."""
    ratios = np.array([t.ratio for t in tries])
    middle = {
        key: np.median([getattr(t, key) for t in tries]) for key in ("reported", "true", "discretisation", "bias")
    }
    return [
        name, way, f"{accuracy:.0%}", f"{middle['reported']:.2%}", f"{middle['true']:.2%}",
        f"{middle['discretisation']:.2%}", f"{ratios.min():.2f}", f"{np.median(ratios):.2f}", f"{ratios.max():.2f}",
        f"{middle['bias']:+.2%}", tries[0].limited_by, f"{np.median([t.seconds for t in tries]):.2f}",
    ]  # fmt: skip


HEAD = ["scene", "way", "asked", "reported", "true", "of which size", "least", "ratio", "most", "bias", "limit", "s"]


def summary(way: str, tries: list[Try]) -> str:
    """How many were too kind, of all solves of one way."""
    ratios = np.array([t.ratio for t in tries])
    shares = ", ".join(f"{np.mean(ratios < limit):.0%} below {limit}" for limit in (1, 0.8, 0.5))
    above = f"{np.mean(ratios > 2):.0%} above 2"
    return f"{way}: {len(ratios)} solves, median ratio {np.median(ratios):.2f}; {shares}; {above}"


def main() -> None:
    """Solve everything and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ways", nargs="+", choices=WAYS, default=WAYS)
    parser.add_argument("--accuracies", nargs="+", type=float, default=[0.05, 0.02])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--scenes", nargs="+", choices=sorted(KNOWN), default=list(KNOWN))
    parser.add_argument("--count", type=int, default=600, help="patches, where the mesh is free")
    parser.add_argument("--markdown", action="store_true")
    args = parser.parse_args()
    between = " | " if args.markdown else "  "
    widths = [22, 12, 5, 8, 7, 13, 6, 6, 6, 7, 10, 6]

    def show(cells: list[str]) -> None:
        print(between.join(cell.ljust(width) for cell, width in zip(cells, widths, strict=True)), flush=True)

    show(HEAD)
    if args.markdown:
        show(["---"] * len(HEAD))
    said = []
    for way in args.ways:
        every = []
        for name in args.scenes:
            for accuracy in args.accuracies:
                tries = [tried(KNOWN[name], way, accuracy, seed, args.count) for seed in range(1, args.seeds + 1)]
                show(row(name, way, accuracy, tries))
                every += tries
        said.append(summary(way, every))
    print("\n".join(["", *said]))


if __name__ == "__main__":
    main()
