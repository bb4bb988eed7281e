"""raystrack: quasi-Monte Carlo rays from every patch, cosine distributed, single precision.

    python -m peers.peer_raystrack SCENE OUT.npy [--rays 16384] [--threads 2]

Importing, and the compilation of its Numba kernels on a tiny scene, are not timed.
"""

from __future__ import annotations

import os
from time import perf_counter

import numpy as np

from factor_scenes import Scene, scene
from peers.view_factors import Answer, parser, peak_of, report

DENSITY = 8  # emission cells along a side; rays = DENSITY^2 x rays a cell


def main() -> None:
    """Run raystrack on a scene."""
    options = parser("raystrack on a scene of the comparison")
    options.add_argument("--rays", type=int, default=16384, help="rays a patch")
    args = options.parse_args()
    os.environ["NUMBA_NUM_THREADS"] = str(args.threads)
    report(args, lambda of: factors(of, args.rays), f"{args.rays} rays a patch, {args.threads} threads")


def factors(of: Scene, rays: int) -> Answer:
    """All factors."""
    run(scene("plate"), rays)
    start = perf_counter()
    found = run(of, rays)
    return Answer(found, perf_counter() - start, peak_of())


def run(of: Scene, rays: int) -> np.ndarray:
    """Every patch is a surface of one or two triangles that receives on its front."""
    import raystrack as rt  # noqa: PLC0415 - after the number of threads is set

    triangles = [[0, 1, 2], [0, 2, 3]][: of.faces.shape[1] - 2]
    of_id = {f"s{k}": rt.Mesh(p, np.array(triangles)) for k, p in enumerate(of.polygons)}
    options = rt.SolveOptions(
        sampling=rt.Sampling(density=DENSITY, rays_per_cell=max(1, rays // DENSITY**2)),
        accuracy=rt.Accuracy(max_replicates=1, min_replicates=1),
    )
    with rt.Solver(rt.Scene.from_meshes(of_id), device="cpu") as solver:
        result = solver.solve(rt.Query.matrix(receiver_sides=("front",)), options)
    return dense(result, len(of.faces))


def dense(result: object, n: int) -> np.ndarray:
    """Its sparse table as F."""
    column = np.array([int(c.surface_id[1:]) if c.kind == "surface" else -1 for c in result.channels])
    row = np.array([int(s[1:]) for s in result.sender_ids])
    i, j = row[result.data.row_indices], column[result.data.channel_indices]
    found = np.zeros((n, n))
    np.add.at(found, (i[j >= 0], j[j >= 0]), result.data.estimates[j >= 0])
    return found


if __name__ == "__main__":
    main()
