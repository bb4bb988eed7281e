"""Images on surfaces: a tiled floor and a painting. The solve sees means over patches, pictures every tile."""

import math
import sys
from pathlib import Path

import numpy as np

import radiosity
from radiosity import Camera, Scene, Surface, Texture
from radiosity.picture import render, save_image

OUT = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
OUT.mkdir(parents=True, exist_ok=True)

UPRIGHT = np.array([[0, 1], [1, 1], [1, 0], [0, 0]])  # of a quad from its lower left corner; v points down
DARK, LIGHT = 0.15, 0.75


def quad(corner, u, v):
    c, u, v = (np.array(x, dtype=float) for x in (corner, u, v))
    return np.array([c, c + u, c + u + v, c + v]), [[0, 1, 2, 3]]


def tiles():
    """Two by two tiles, 32 texels each, which repeat over the floor."""
    return np.kron([[DARK, LIGHT], [LIGHT, DARK]], np.ones((32, 32)))


def painting():
    """Rings of colour, in sRGB as image files have it."""
    y, x = (np.indices((192, 256)) + 0.5) / 256
    rings = np.hypot(x[..., None] - [0.42, 0.5, 0.58], y[..., None] - 0.375)
    return (255 * (0.55 + 0.4 * np.cos(40 * rings))).astype(np.uint8)


# A room of 4 x 2.5 x 5 m, of which the wall on the right is red.
floor = Surface(*quad([0, 0, 5], [4, 0, 0], [0, 0, -5]), 0.999, name="floor",
                texture=Texture(tiles(), UPRIGHT * [4, 5]))  # fmt: skip
canvas = Surface(*quad([1.2, 0.9, 0.02], [1.6, 0, 0], [0, 1.2, 0]), 0.95, name="painting",
                 texture=Texture(painting(), UPRIGHT, "clamp"))  # fmt: skip
walls = [
    Surface(*quad([0, 2.5, 0], [4, 0, 0], [0, 0, 5]), 0.8, name="ceiling"),
    Surface(*quad([0, 0, 0], [4, 0, 0], [0, 2.5, 0]), 0.7, name="back wall"),
    Surface(*quad([4, 0, 5], [-4, 0, 0], [0, 2.5, 0]), 0.7, name="front wall"),
    Surface(*quad([0, 0, 5], [0, 0, -5], [0, 2.5, 0]), 0.7, name="left wall"),
    Surface(*quad([4, 0, 0], [0, 0, 5], [0, 2.5, 0]), [0.6, 0.12, 0.1], name="right wall"),
]
lamp = Surface(*quad([1.4, 2.49, 2], [1.2, 0, 0], [0, 0, 1.2]), 0.0, 15.0, name="lamp")
scene = Scene([floor, canvas, *walls, lamp], name="gallery")
camera = Camera.look_at((2, 1.4, 4.8), (2, 1.0, 0), vertical_fov=math.radians(50))
solution = radiosity.solve(scene, accuracy=0.03)

# Patches are not tiles, but their means, weighted by area, make the mean of all tiles: half of each.
patches, on = solution.patches, solution.patches.surface == 0
mean = np.average(patches.reflectance[on], weights=patches.area[on], axis=0)
print(f"{on.sum()} patches of the floor reflect from {patches.reflectance[on].min():.3f} to "
      f"{patches.reflectance[on].max():.3f}, on average {mean[0]:.6f}")  # fmt: skip
np.testing.assert_allclose(mean, 0.999 * (DARK + LIGHT) / 2, rtol=1e-6)

# Where the same light falls, a light tile is LIGHT / DARK times as bright as a dark one. Straight down, at the floor's
# middle, four tiles meet: by symmetry of the tiles, both kinds get the same light but for the red wall's share.
down = Camera.look_at((2, 1, 2.5), (2, 0, 2.5), up=(0, 0, -1), vertical_fov=math.radians(40))
for mode in ("gather", "path"):
    seen = render(solution, down, width=32, height=32, samples=64, mode=mode)[..., 1]
    corners = [seen[a, b].mean() for a in (slice(14), slice(18, 32)) for b in (slice(14), slice(18, 32))]
    ratio = (corners[0] + corners[3]) / (corners[1] + corners[2])
    ratio = max(ratio, 1 / ratio)
    print(f"{mode}: light tiles are {ratio:.3f} times as bright as dark ones; their paint makes {LIGHT / DARK:.3f}")
    assert abs(ratio / (LIGHT / DARK) - 1) < 0.03

save_image(OUT / "textures.png", render(solution, camera, width=640, height=480, mode="gather"))
