"""How much work each solver takes, against reflectance and number of patches.

    python benchmarks/solvers.py [--scene cube room] [--counts 500 2000] [--reflectance 0.5 0.8 0.9 0.99]

All patches have one reflectance but the lamps, which keep theirs. The equations are solved on the same form factors to
a residual of 1e-9 (1 - rho). Work is told in products with all form factors: a sweep is one, and as many shots as there
are patches are one. A product runs on all threads and a sweep on one, so times depend on the machine; work does not.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import numpy as np

import radiosity
from ladder import table
from machine import describe
from radiosity.solution import SOLVERS, Solver

WALLS = {
    "floor": [0, 1, 3, 2], "ceiling": [4, 6, 7, 5], "front": [0, 4, 5, 1],
    "back": [2, 3, 7, 6], "left": [0, 2, 6, 4], "right": [1, 5, 7, 3],
}  # fmt: skip


@dataclass(frozen=True)
class Run:
    """One solver on one problem."""

    scene: str
    patches: int
    reflectance: float
    solver: Solver
    iterations: int
    products: float
    seconds: float
    converged: bool


def main() -> None:
    """Solve everything and print the table."""
    args = arguments()
    print(describe(), end="\n\n", flush=True)
    for name in args.scene:
        for count in args.counts:
            print(report(measure(name, count, args.reflectance)), flush=True)


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Work of every solver")
    parser.add_argument("--scene", nargs="+", choices=("cube", "cornell", "room"), default=["cube", "cornell", "room"])
    parser.add_argument("--counts", type=int, nargs="+", default=[500, 2000])
    parser.add_argument("--reflectance", type=float, nargs="+", default=[0.5, 0.8, 0.9, 0.99])
    return parser.parse_args()


def scene(name: str) -> radiosity.Scene:
    """A closed cube with a lamp in its ceiling, the Cornell box, which is open, or the furnished room."""
    if name == "cornell":
        return radiosity.scenes.cornell_box()
    if name == "room":
        return radiosity.scenes.furnished_room(0)
    corners = np.array([[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)])
    walls = [
        radiosity.Surface(corners, [face], 0.5, 1.0 if wall == "ceiling" else 0.0, wall) for wall, face in WALLS.items()
    ]
    return radiosity.Scene(walls, name="cube")


def measure(name: str, count: int, reflectances: list[float]) -> list[Run]:
    """Every solver at every reflectance on one set of form factors."""
    patches = scene(name).patches(count=count)
    factors = radiosity.form_factors(patches, hemicubes=16, resolution=256, method="hemicube")
    # Few hemicubes leave rows that sum to more than 1, and reflectances near 1 then nearly no equilibrium.
    factors = factors.enforce(sums=np.minimum(factors.closure(), 1.0))
    runs = []
    for solver in SOLVERS:
        first = radiosity.solve(patches, transport=factors, solver=solver)
        for rho in reflectances:
            is_lamp = patches.emission.any(axis=1, keepdims=True)
            r = first.relight(reflectance=np.where(is_lamp, patches.reflectance, rho)).report
            runs.append(Run(name, len(patches), rho, solver, r.iterations, r.products, r.seconds, r.converged))
    return runs


def report(runs: list[Run]) -> str:
    """A row for each solver, and of each reflectance iterations, products and milliseconds."""
    reflectances = sorted({run.reflectance for run in runs})
    header = [f"{runs[0].scene}, {runs[0].patches}", *(f"rho {rho:g}" for rho in reflectances)]
    rows = [[solver, *(cell(runs, solver, rho) for rho in reflectances)] for solver in SOLVERS]
    return table(header, rows) + "\n(iterations / products / ms)\n"


def cell(runs: list[Run], solver: Solver, reflectance: float) -> str:
    """What one solver took."""
    run = next(r for r in runs if (r.solver, r.reflectance) == (solver, reflectance))
    missed = "" if run.converged else " NOT converged"
    return f"{run.iterations} / {run.products:.3g} / {1e3 * run.seconds:.3g}{missed}"


if __name__ == "__main__":
    main()
