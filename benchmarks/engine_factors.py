"""The form factors of this repository's engine on a scene of the comparison.

    python -m engine_factors SCENE OUT.npy [--tolerance 1e-4 | --rays 4096] [--threads 2]

Timed is everything from arrays in memory to the operator: scene, patches, form factors. Importing, and one small scene
that loads the library's pages, are not.
"""

from __future__ import annotations

import argparse
from time import perf_counter

import radiosity
from factor_scenes import Scene, scene
from peers.view_factors import Answer, parser, peak_of, report


def main() -> None:
    """Run the engine on a scene."""
    options = parser("This engine on a scene of the comparison")
    options.add_argument("--tolerance", type=float)
    options.add_argument("--rays", type=int)
    args = options.parse_args()
    report(args, lambda of: factors(of, args), settings(args))


def settings(args: argparse.Namespace) -> str:
    """The settings in words."""
    asked = {"tolerance": args.tolerance, "rays": args.rays}
    words = [f"{name} {value:g}" for name, value in asked.items() if value is not None]
    return ", ".join([*words, f"{args.threads} threads"])


def factors(of: Scene, args: argparse.Namespace) -> Answer:
    """All factors."""
    run(scene("plate"), args)
    start = perf_counter()
    operator = run(of, args)
    seconds, peak = perf_counter() - start, peak_of()
    return Answer(operator.toarray(), seconds, peak)


def run(of: Scene, args: argparse.Namespace) -> radiosity.FormFactors:
    """The operator from arrays in memory."""
    enclosure = radiosity.Scene([radiosity.Surface(of.vertices, of.faces, 0.5, 1.0, "x")])
    patches = enclosure.patches(as_is=True)
    if args.rays is not None:
        return radiosity.form_factors(patches, method="monte_carlo", rays=args.rays, threads=args.threads)
    return radiosity.form_factors(patches, method="auto", tolerance=args.tolerance, threads=args.threads)


if __name__ == "__main__":
    main()
