"""Form factors by every method, against closed forms: the cube, and two squares with a plate between them."""

import math
import time

import numpy as np

import radiosity
from radiosity import catalogue

# The unit cube seen from inside: every face sees the one opposite and four beside it, and all of them are 1.
corners = np.array([[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)])
faces = {
    "floor": [0, 1, 3, 2], "ceiling": [4, 6, 7, 5], "front": [0, 4, 5, 1],
    "back": [2, 3, 7, 6], "left": [0, 2, 6, 4], "right": [1, 5, 7, 3],
}  # fmt: skip
cube = radiosity.Scene([radiosity.Surface(corners, [face], name=name) for name, face in faces.items()])
opposite = catalogue.equal_parallel_rectangles(width=1, length=1, gap=1)
beside = catalogue.perpendicular_rectangles_with_common_edge(width_1=1, width_2=1, length=1)
assert math.isclose(opposite + 4 * beside, 1, rel_tol=1e-14)

# Two unit squares at gap 1, and midway a plate of half their size that hides half of what each sees of the other.
up = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
down = [[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]]
plate = [[0.25, 0.25, 0.5], [0.75, 0.25, 0.5], [0.75, 0.75, 0.5], [0.25, 0.75, 0.5]]
squares = [radiosity.Surface(square, [[0, 1, 2, 3]], two_sided=square is plate) for square in (up, down, plate)]
pair = radiosity.Scene(squares)
visible = 0.09950629459898  # a smooth integral over both squares and over what passes the plate, by Gauss-Legendre

# Each with the error that is to be expected of it at worst.
METHODS = {
    "auto": ({"tolerance": 1e-6}, 1e-6),
    "analytic": ({}, 1e-6),  # to 1e-12 in full view; what is hidden, to the tolerance
    "contour": ({"tolerance": 1e-6}, 1e-6),
    "nusselt": ({"points": 16}, 1e-3),  # rows of points along the shadow of an edge are 1/16 apart
    "hemicube": ({"resolution": 512, "hemicubes": 64}, 5e-3),  # points in sequence: about 0.2/64
    "monte_carlo": ({"rays": 1 << 16}, 4 * math.sqrt(0.2 * 0.8 / (2 << 16))),  # four standard deviations, at random
}


def compare(title: str, scene: radiosity.Scene, i: int, j: int, exact: float) -> None:
    """Print what every method finds for one pair, and how far off it is."""
    print(f"{title}: {exact:.12f}\n  {'method':12} {'form factor':>14} {'error':>9} {'time':>9}")
    patches = scene.patches(as_is=True)
    radiosity.form_factors(patches, rays=1)  # so that nobody's time includes what is made once for all
    for method, (options, allowed) in METHODS.items():
        start = time.perf_counter()
        found = radiosity.form_factors(patches, method=method, **options).row(i)[j]
        seconds = time.perf_counter() - start
        print(f"  {method:12} {found:14.12f} {found - exact:9.1e} {1e3 * seconds:6.1f} ms")
        assert abs(found - exact) <= allowed


compare("opposite faces of a cube", cube, 0, 1, opposite)
compare("faces with a common edge", cube, 0, 2, beside)
compare("a plate between", pair, 0, 1, visible)

# Where all edges are parallel or perpendicular "analytic" is exact to rounding, and the rows close.
F = radiosity.form_factors(cube.patches(as_is=True), method="analytic")
assert np.allclose(F.closure(), 1, rtol=0, atol=1e-14)
print(F.report)
