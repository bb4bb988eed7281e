"""Nusselt's analog in pictures: what a point sees, projected onto a hemisphere and down, is its form factor.

The area that is covered on the base, over pi, equals the closed form.
"""

import math
import sys
from pathlib import Path

import numpy as np

from radiosity import catalogue, teaching

OUT = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
OUT.mkdir(parents=True, exist_ok=True)

POINT, UP = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def covered(polygon: list[tuple[float, float, float]]) -> float:
    """The share of the base under a polygon: the shoelace formula on the outline, straight down."""
    x, y, _ = teaching.nusselt_outline(POINT, UP, polygon, steps=20_000).T
    return abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2 / math.pi


# A ceiling lamp: from below its corner the closed form is Howell's B-3.
square = [(0.0, 0.0, 1.0), (1.0, 0.0, 1.0), (1.0, 1.0, 1.0), (0.0, 1.0, 1.0)]
exact = catalogue.point_to_parallel_rectangle(width=1.0, length=1.0, distance=1.0)
# What the shoelace formula leaves out between 20,000 chords an edge and their arcs is of second order: 1e-9.
assert math.isclose(covered(square), exact, rel_tol=1e-8)
assert math.isclose(teaching.nusselt_form_factor(POINT, UP, square), exact, rel_tol=1e-13)
print(f"a unit square above: covered share {covered(square):.10f}, closed form {exact:.10f}")
teaching.draw_nusselt(POINT, UP, square).savefig(OUT / "nusselt_square.png")

# A wall that goes on below the horizon: what is below does not count, and what is left is Howell's B-8.
wall = [(1.0, 0.0, -0.5), (1.0, 1.0, -0.5), (1.0, 1.0, 1.0), (1.0, 0.0, 1.0)]
exact = catalogue.point_to_perpendicular_rectangle(height=1.0, length=1.0, distance=1.0)
assert math.isclose(covered(wall), exact, rel_tol=1e-8)
print(f"a wall beside:       covered share {covered(wall):.10f}, closed form {exact:.10f}")
teaching.draw_nusselt(POINT, UP, wall).savefig(OUT / "nusselt_wall.png")

# Whatever covers the same of the hemisphere has the same form factor: the square twice as far and twice as wide.
far = [tuple(2 * c for c in corner) for corner in square]
assert math.isclose(teaching.nusselt_form_factor(POINT, UP, far), teaching.nusselt_form_factor(POINT, UP, square))
