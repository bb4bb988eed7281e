"""A room from arrays, lit by a bulb of 100 candela: candela in, lux out."""

import math
import sys
from pathlib import Path

import numpy as np

import radiosity
from radiosity.picture import render, save_image

OUT = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
OUT.mkdir(parents=True, exist_ok=True)

# Metres, y up. The walls are seen from inside, so their corners run counter-clockwise from there.
X, Y, Z, RHO = 4.0, 2.5, 3.0, 0.6
corners = np.array([[x, y, z] for z in (0, Z) for y in (0, Y) for x in (0, X)])
faces = {
    "floor": [0, 4, 5, 1], "ceiling": [2, 3, 7, 6], "left": [0, 2, 6, 4],
    "right": [1, 5, 7, 3], "window wall": [0, 1, 3, 2], "door wall": [4, 6, 7, 5],
}  # fmt: skip
surfaces = [radiosity.Surface(corners, [face], RHO, name=name) for name, face in faces.items()]
table = [[1.2, 0.75, 1.0], [1.2, 0.75, 2.0], [2.8, 0.75, 2.0], [2.8, 0.75, 1.0]]
surfaces.append(radiosity.Surface(table, [[0, 1, 2, 3]], RHO, name="table", two_sided=True))
bulb = radiosity.PointLight([2.0, 2.0, 1.5], 100.0)
room = radiosity.Scene(surfaces, lights=[bulb])

patches = room.patches(max_edge=0.15)
solution = radiosity.solve(patches, accuracy=0.01)
lux, back_lux = solution.irradiance[:, 0], solution.back_irradiance[:, 0]  # NaN where there is no back
for k, surface in enumerate(surfaces):
    on = patches.surface == k
    print(f"{surface.name:12} {np.average(lux[on], weights=patches.area[on]):6.1f} lux")

# What the bulb sends is absorbed in the end: 4 pi I = (1 - rho) sum A H over all sides, whatever the shapes.
arriving = patches.area @ lux + np.nansum(patches.area * back_lux)
assert math.isclose((1 - RHO) * arriving, 4 * math.pi * 100.0, rel_tol=0.01)

solution.save(OUT / "room.glb")
solution.save(OUT / "room.vtp")
view = radiosity.Camera.look_at([3.8, 1.7, 0.2], [1.6, 0.8, 1.8], vertical_fov=math.radians(70))
save_image(OUT / "room_lux.png", render(solution, view, show="irradiance", mode="patches"), false_colours=True)
