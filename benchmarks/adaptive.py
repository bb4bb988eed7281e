"""Meshes that adapt beside even ones: true error of the field of irradiance against patches and against time.

    python benchmarks/adaptive.py [--scenes NAME ...] [--plot adaptive.png]

Scenes are those of `validation/known_answers.py` whose light is known at any point, and the Cornell box, whose light at
probes is gathered by tens of thousands of independent rays each from a fine solution. Even meshes are drawn twice: with
one value a patch, and with the linear field that the engine makes of the same values. They are given an advantage: each
is sampled once, to a third of the error that its mesh leaves, which is found out beforehand and not timed. Meshes that
adapt are timed from the scene to the answer, with all that leads there.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.stats import qmc

import radiosity
from radiosity.solution import Sampling

sys.path.insert(0, str(Path(__file__).parent.parent / "validation"))
from known_answers import KNOWN, normals_of

from machine import describe

Floats = npt.NDArray[np.float64]

SCENES = ("lamp and screen", "window and box", "standing lamp", "cornell")
EVEN = (500, 1000, 2000, 4000, 8000, 16_000, 32_000)
ACCURACIES = (0.08, 0.05, 0.03, 0.02, 0.015, 0.012, 0.01)
TARGET = 0.01


@dataclass(frozen=True)
class Truth:
    """Irradiance at points, measured twice by independent rays where it is not exact."""

    points: Floats
    normals: Floats
    first: Floats
    second: Floats

    def error(self, values: Floats) -> float:
        """Root mean square relative to the mean; the noise of the truth averages out."""
        square = ((values - self.first) * (values - self.second)).mean()
        return float(np.sqrt(max(square, 0.0)) / (0.5 * (self.first + self.second)).mean())


@dataclass(frozen=True)
class Run:
    """One mesh."""

    patches: int
    seconds: float
    error: float
    reported: float


def known(name: str) -> tuple[radiosity.Scene, Truth]:
    """A scene with its light in closed form at probes."""
    scene, probes = KNOWN[name].scene(), KNOWN[name].probes(1500)
    return scene, Truth(probes.points, normals_of(scene, probes.points, probes.surface), probes.value, probes.value)


def cornell() -> tuple[radiosity.Scene, Truth]:
    """The box with its light at probes, gathered from a fine solution."""
    scene = radiosity.scenes.cornell_box()
    fine = radiosity.solve(scene.patches(count=12_000), accuracy=0.006, seed=77)
    patches, rng = fine.patches, np.random.default_rng(0)
    chosen = rng.choice(len(patches), 1500, p=patches.area / patches.area.sum())
    corners, (u, v) = patches.polygons[chosen], rng.random((2, 1500, 1))
    points = corners[:, 0] + u * (corners[:, 1] - corners[:, 0]) + v * (corners[:, 3] - corners[:, 0])
    normals = patches.normal[chosen]
    halves = [gathered(fine, points, normals, seed) for seed in (1, 2)]
    return scene, Truth(points, normals, *halves)


def gathered(fine: radiosity.Solution, points: Floats, normals: Floats, seed: int) -> Floats:
    """Irradiance at points: lamps by area, the rest by cosine-distributed rays on the field of a fine solution."""
    patches, emission = fine.patches, fine.emission
    lamps = np.flatnonzero(emission.sum(axis=1) > 0)
    size = float(np.ptp(patches.polygons.reshape(-1, 3), axis=0).max())
    reflected = fine.corner_irradiance * fine.reflectance[:, None]
    share = np.cumsum(patches.area[lamps]) / patches.area[lamps].sum()

    def seen(origin: Floats, ways: Floats) -> tuple[npt.NDArray[np.int64], Floats]:
        return patches._enclosure.locate(origin + 2 * size * ways, -ways, 2 * size)

    total = np.zeros((len(points), emission.shape[1]))
    for k, (point, up) in enumerate(zip(points, normals, strict=True)):
        origin = point + 1e-6 * size * up
        side = np.cross(up, [0.0, 1, 0] if abs(up[0]) > 0.9 else [1.0, 0, 0])
        side /= np.linalg.norm(side)
        s, t = qmc.Sobol(2, seed=seed + 7 * k).random(512).T
        across = np.sqrt(s)[:, None] * (
            np.cos(2 * np.pi * t)[:, None] * side + np.sin(2 * np.pi * t)[:, None] * np.cross(up, side)
        )
        patch, weights = seen(origin, across + np.sqrt(1 - s)[:, None] * up)
        hit = patch >= 0
        total[k] = np.einsum("rc,rcb->b", weights[hit], reflected[patch[hit]]) / len(s)
        q, s, t = qmc.Sobol(3, seed=seed + 7 * k + 3).random(512).T
        lamp = lamps[np.searchsorted(share, q).clip(0, len(lamps) - 1)]
        corners = patches.polygons[lamp]
        to = (
            corners[:, 0]
            + s[:, None] * (corners[:, 1] - corners[:, 0])
            + t[:, None] * (corners[:, 3] - corners[:, 0])
            - origin
        )
        length = np.linalg.norm(to, axis=1)
        ways = to / length[:, None]
        kernel = (
            np.maximum(ways @ up, 0) * np.maximum(-(ways * patches.normal[lamp]).sum(axis=1), 0) / (np.pi * length**2)
        )
        shines = kernel > 0
        if shines.any():
            found, _ = seen(origin, ways[shines])
            kernel[shines] *= np.isin(found, lamps)
        total[k] += (kernel[:, None] * emission[lamp]).mean(axis=0) * patches.area[lamps].sum()
    return total


def sampling(seed: int) -> Sampling:
    """As `radiosity.solve` samples where nothing is said."""
    return Sampling("conjugate_gradient", None, "balanced", 1 << 18, 1 << 40, None, seed)


def even(scene: radiosity.Scene, truth: Truth, count: int) -> tuple[Run, Run]:
    """One value a patch, and the linear field, on an even mesh."""
    patches = scene.patches(count=count)
    rough = sampling(3).solve(patches, 0.03, None, wanted=1.0)
    begin = time.perf_counter()
    solution = sampling(4).solve(
        patches, float(np.clip(rough.report.causes["mesh"] / 3, 0.002, 0.03)), None, wanted=1.0
    )
    seconds = time.perf_counter() - begin
    size = float(np.ptp(patches.polygons.reshape(-1, 3), axis=0).max())
    patch, _ = patches._enclosure.locate(truth.points, truth.normals, 1e-5 * size)
    steps = truth.error(solution.irradiance[patch])
    linear = truth.error(solution.irradiance_at(truth.points, truth.normals))
    reported = solution.report.estimated_error
    return Run(len(patches), seconds, steps, reported), Run(len(patches), seconds, linear, reported)


def adaptive(scene: radiosity.Scene, truth: Truth, accuracy: float) -> Run:
    """A mesh of the engine's own."""
    begin = time.perf_counter()
    solution = radiosity.solve(scene, accuracy=accuracy, seed=5, time_limit=120)
    seconds = time.perf_counter() - begin
    error = truth.error(solution.irradiance_at(truth.points, truth.normals))
    return Run(len(solution.patches), seconds, error, solution.report.estimated_error)


def at_target(runs: list[Run], of: Callable[[Run], float]) -> float:
    """Interpolated to the target error, log-log; NaN where it is not crossed."""
    ordered = sorted(runs, key=lambda run: -run.error)
    for worse, better in pairwise(ordered):
        if worse.error >= TARGET >= better.error > 0:
            part = np.log(worse.error / TARGET) / np.log(worse.error / better.error)
            return float(np.exp((1 - part) * np.log(of(worse)) + part * np.log(of(better))))
    return float("nan")


def main() -> None:
    """Run, print, draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", nargs="+", default=list(SCENES), choices=list(SCENES))
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()
    print(describe())
    results: dict[str, dict[str, list[Run]]] = {}
    for name in args.scenes:
        scene, truth = cornell() if name == "cornell" else known(name)
        pairs = [even(scene, truth, count) for count in EVEN]
        runs = {
            "even, one value a patch": [steps for steps, _ in pairs],
            "even, linear": [linear for _, linear in pairs],
            "adaptive, linear": [adaptive(scene, truth, accuracy) for accuracy in ACCURACIES],
        }
        results[name] = runs
        print(f"\n{name}\n| mesh | patches | seconds | true error | reported |\n|---|---|---|---|---|")
        for mesh, of in runs.items():
            for run in of:
                print(f"| {mesh} | {run.patches:,} | {run.seconds:.2f} | {run.error:.2%} | {run.reported:.2%} |")
        for mesh, of in runs.items():
            patches, seconds = at_target(of, lambda run: run.patches), at_target(of, lambda run: run.seconds)
            print(f"{TARGET:.0%} by {mesh}: {patches:,.0f} patches, {seconds:.2f} s")
    print(f"\n{describe()}")
    if args.plot:
        draw(results, args.plot)


def draw(results: dict[str, dict[str, list[Run]]], path: Path) -> None:
    """Error against patches, and against time, a row a scene."""
    import matplotlib  # noqa: PLC0415

    matplotlib.use("Agg")
    from matplotlib import pyplot  # noqa: PLC0415

    figure, axes = pyplot.subplots(2, len(results), figsize=(3.6 * len(results), 6.4), squeeze=False, sharey=True)
    for column, (name, runs) in enumerate(results.items()):
        for row, (label, key) in enumerate((("patches", "patches"), ("seconds", "seconds"))):
            axis = axes[row, column]
            for (mesh, of), colour in zip(runs.items(), ("#999999", "#3b6fb5", "#d1495b"), strict=True):
                ordered = sorted(of, key=lambda run: getattr(run, key))
                axis.loglog(
                    [getattr(r, key) for r in ordered], [r.error for r in ordered], "o-", color=colour, label=mesh, ms=4
                )
            axis.axhline(TARGET, color="#cccccc", lw=1, zorder=0)
            axis.set_xlabel(label)
            axis.grid(alpha=0.3, which="both", lw=0.4)
            if row == 0:
                axis.set_title(name)
        axes[0, 0].set_ylabel("true error of the field")
        axes[1, 0].set_ylabel("true error of the field")
    axes[0, -1].legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    main()
