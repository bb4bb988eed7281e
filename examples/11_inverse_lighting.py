"""Inverse lighting: how bright must 24 lamps be, and how dark the wall, so that every place has the light it needs?

The irradiance that is wanted goes in, lamps and paint come out. Derivatives of irradiance by everything that shines and
reflects, which the search runs on, take one more solve each; as a picture they show what light is worth where.
"""

import sys
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import radiosity
from radiosity import Emission, Reflectance, Surface, Target
from radiosity.files import LitModel
from radiosity.picture import render

OUT = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
OUT.mkdir(parents=True, exist_ok=True)

# A meeting room of 8 x 6 x 2.8 m, y up, in lumen and lux, with walls seen from inside.
X, Y, Z = 8.0, 2.8, 6.0
WARM, OAK, WHITE, BLUE = [1.15, 1.0, 0.85], [0.42, 0.3, 0.2], [0.8, 0.78, 0.74], [0.3, 0.42, 0.55]
QUAD = [[0, 1, 2, 3]]
corners = np.array([[x, y, z] for z in (0, Z) for y in (0, Y) for x in (0, X)])
shell = {
    "floor": ([0, 4, 5, 1], [0.3, 0.27, 0.24]), "ceiling": ([2, 3, 7, 6], WHITE), "end wall": ([0, 2, 6, 4], BLUE),
    "near wall": ([1, 5, 7, 3], WHITE), "left wall": ([0, 1, 3, 2], WHITE), "right wall": ([4, 6, 7, 5], WHITE),
}  # fmt: skip
surfaces = [Surface(corners[face], QUAD, rho, name=name) for name, (face, rho) in shell.items()]


def level(name: str, x: tuple, z: tuple, y: float, rho: list, *, down: bool = False, **more: object) -> Surface:
    """A horizontal rectangle."""
    flat = np.array([[x[0], y, z[0]], [x[0], y, z[1]], [x[1], y, z[1]], [x[1], y, z[0]]])
    return Surface(flat[::-1] if down else flat, QUAD, rho, name=name, **more)


def block(name: str, x: tuple, y: tuple, z: tuple, rho: list) -> Surface:
    """A box that stands on something."""
    points = np.array([[i, j, k] for k in z for j in y for i in x])
    return Surface(points, [[0, 2, 3, 1], [4, 5, 7, 6], [0, 4, 6, 2], [1, 3, 7, 5], [2, 6, 7, 3]], rho, name=name)


surfaces.append(level("table", (2.4, 5.6), (2.2, 3.8), 0.74, OAK, two_sided=True))
surfaces.append(level("desk", (0.3, 1.0), (4.0, 5.7), 0.74, WHITE, two_sided=True))
surfaces += [block(f"foot {k}", (x, x + 0.12), (0, 0.74), (2.6, 3.4), OAK) for k, x in enumerate((2.8, 5.1))]
surfaces += [block("cupboard", (0.3, 2.3), (0, 0.9), (0.02, 0.45), OAK), block("stool", (1.3, 1.7), (0, 0.45), (4.6, 5), BLUE)]
picture_rho = [0.75, 0.55, 0.3]
surfaces.append(Surface([[0.02, 1.0, 3.8], [0.02, 1.0, 2.2], [0.02, 2.0, 2.2], [0.02, 2.0, 3.8]], QUAD, picture_rho, name="painting"))
places = [(x, z) for x in np.linspace(0.8, 7.2, 6) for z in np.linspace(0.9, 5.1, 4)]
lamps = [f"lamp {k}" for k in range(len(places))]
for lamp, (x, z) in zip(lamps, places, strict=True):
    surfaces.append(level(lamp, (x - 0.15, x + 0.15), (z - 0.15, z + 0.15), Y - 0.02, [0.6] * 3, down=True))
room = radiosity.Scene(surfaces, name="meeting room")

# What is wanted, in lux; the most a lamp of these can, in lumen for a square metre; walls may be painted.
wanted = [Target("table", 500), Target("desk", 750), Target("painting", 200), Target("right wall", 100), Target("floor", 150, 0.3)]
variables = [Emission(lamp, (0, 30_000), tint=WARM) for lamp in lamps]
variables.append(Reflectance("left wall", (0.2, 0.85)))
patches = room.patches(max_edge=0.4)
found = radiosity.design(patches, wanted, variables, economy=0.02, accuracy=0.02)
print(found)
#ASSERT

# What 24 equal lamps take that give the desk, which is the hardest, as much.
solution = found.solution
even = radiosity.design(solution, {"desk": 750}, {}) if False else None
