"""pyviewfactor: a semi-analytic contour integral per pair; a pair is hidden if the ray between the centroids is.

    python -m peers.peer_pyviewfactor SCENE OUT.npy [--threads 2]

Importing, and the compilation of its Numba kernels on a tiny scene, are not timed.
"""

from __future__ import annotations

import os
from time import perf_counter

import numpy as np

from factor_scenes import Scene, scene
from peers.view_factors import Answer, parser, peak_of, report


def main() -> None:
    """Run pyviewfactor on a scene."""
    args = parser("pyviewfactor on a scene of the comparison").parse_args()
    os.environ["NUMBA_NUM_THREADS"] = str(args.threads)
    report(args, factors, f"default, {args.threads} threads")


def factors(of: Scene) -> Answer:
    """All factors."""
    run(scene("plate"))
    start = perf_counter()
    found = run(of)
    return Answer(found, perf_counter() - start, peak_of())


def run(of: Scene) -> np.ndarray:
    """Its matrix is F[i, j] from j to i. A scene where nothing is hidden spares it the search for obstacles."""
    import pyviewfactor  # noqa: PLC0415 - after the number of threads is set
    import pyvista  # noqa: PLC0415

    corners = of.faces.shape[1]
    mesh = pyvista.PolyData(of.vertices, np.insert(of.faces, 0, corners, axis=1).ravel())
    found = pyviewfactor.compute_viewfactor_matrix(mesh, obstacles=mesh, skip_obstruction=not of.occluded)
    return np.ascontiguousarray(found.T)


if __name__ == "__main__":
    main()
