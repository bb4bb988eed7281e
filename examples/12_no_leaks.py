"""Light and shadow leaks, and how patches that end where walls stand do away with them.

A patch on both sides of a wall is lit by one room and lights the other. So faces are cut along the lines where others
touch or cross them. Each scene has a region that no light can reach: whatever is not black there in the picture leaked.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import LogNorm

import radiosity

sys.path.insert(0, str(Path(__file__).parent.parent / "validation"))
from leaks import CORPUS, Leak, most_light_in_the_dark

OUT = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
OUT.mkdir(parents=True, exist_ok=True)

SHOWN: dict[str, tuple[str, ...]] = {
    "thin_sheet": (), "turned_wall": (), "lean_to": (), "crossing_sheets": (),
    "cupboard": ("cupboard",), "corner_column": ("box 0",),
    "stacked_boxes": ("box 1",), "staircase": tuple(f"box {i}" for i in range(6)),
}  # fmt: skip
"""Scenes, and of which surfaces only the edges are drawn, so that the dark beneath and behind them shows."""
COLOURS = LogNorm(2e-3, 6)
DARK = "#15151c"

# From above and in front, so that the walls in between show their backs and are not drawn.
TOWARD_EYE = np.array([0.5, -1.0, 1.05]) / np.linalg.norm([0.5, -1.0, 1.05])
RIGHT = np.cross([0, 0, 1], TOWARD_EYE) / np.linalg.norm(np.cross([0, 0, 1], TOWARD_EYE))
UP = np.cross(TOWARD_EYE, RIGHT)


def draw(axes: Axes, solution: radiosity.Solution, outlined: tuple[str, ...]) -> None:
    """Patches from the farthest to the nearest, with the irradiance of the side that is seen."""
    patches = solution.patches
    surfaces = patches.scene.surfaces
    facing = patches.normal @ TOWARD_EYE
    is_open = np.array([surface.name in outlined for surface in surfaces])[patches.surface]
    seen = np.flatnonzero(~is_open & ((facing > 1e-9) | ((facing < -1e-9) & patches.two_sided)))
    seen = seen[np.argsort(patches.centre[seen] @ TOWARD_EYE, kind="stable")]
    side = np.where(facing > 0, solution.irradiance[:, 0], solution.back_irradiance[:, 0])
    colours = plt.cm.inferno(COLOURS(np.maximum(side[seen], COLOURS.vmin)))
    colours[side[seen] == 0] = plt.matplotlib.colors.to_rgba(DARK)
    outlines = patches.polygons[seen] @ np.stack([RIGHT, UP], axis=1)
    axes.add_collection(PolyCollection(outlines, facecolors=colours, edgecolors="0.55", linewidths=0.35))
    faces = [np.asarray(s.vertices)[np.asarray(s.faces)] for s in surfaces if s.name in outlined]
    if faces:
        edges = np.concatenate(faces) @ np.stack([RIGHT, UP], axis=1)
        axes.add_collection(PolyCollection(edges, facecolors="none", edgecolors="#7fd6ff", linewidths=0.9))
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.axis("off")


def lit(leak: Leak, *, contacts: bool) -> radiosity.Solution:
    patches = leak.scene.patches(max_edge=0.5, contacts=contacts)
    return radiosity.solve(patches, accuracy=0.05, seed=1)


figure, grid = plt.subplots(len(SHOWN) // 2, 4, figsize=(15, 2.75 * len(SHOWN) // 2), layout="constrained")
for name, pair in zip(SHOWN, grid.reshape(-1, 2), strict=True):
    leak = CORPUS[name]()
    for axes, contacts in zip(pair, (False, True), strict=True):
        solution = lit(leak, contacts=contacts)
        leaked = most_light_in_the_dark(leak, solution)
        draw(axes, solution, SHOWN[name])
        told = f"up to {leaked:.2g} W/m² in the dark" if leaked > 0 else "nothing in the dark"
        axes.set_title(f"{leak.name}{'' if contacts else ', contacts=False'}\n{told}", fontsize=9)
        print(f"{leak.name:28} contacts={contacts!s:5} {len(solution.patches):4} patches, {told}")
        # With lines of contact not a single photon strays: no tolerance.
        assert leaked == 0 if contacts else True

# Every patch is on one side of what stands on it, and nothing is lost of any face.
for make in CORPUS.values():
    scene = make().scene
    whole, cut = scene.patches(max_edge=0.5, contacts=False), scene.patches(max_edge=0.5)
    areas = [np.bincount(patches.surface, patches.area) for patches in (whole, cut)]
    assert np.allclose(areas[0], areas[1], rtol=1e-12)

bar = plt.cm.ScalarMappable(COLOURS, "inferno")
figure.colorbar(bar, ax=grid, shrink=0.5, label="irradiance, W/m²; black: exactly none", pad=0.01)
figure.savefig(OUT / "no_leaks.png", dpi=130)
