"""What a patch of a furnished room sees, pixel by pixel on a hemicube; and the form factors that add up to.

A pixel is worth its delta form factor, so what the pixels of a surface are worth together is the form factor to it.
"""

import sys
from pathlib import Path

import numpy as np

import radiosity
from radiosity import teaching

OUT = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
OUT.mkdir(parents=True, exist_ok=True)

RESOLUTION = 512


def show(name: str, scene: radiosity.Scene, patches: radiosity.Patches, surface: str, place: list[float]) -> None:
    """Draw what the patch of a surface nearest to a place sees, and compare its row with the exact one."""
    on = np.flatnonzero(patches.surface == [s.name for s in scene.surfaces].index(surface))
    patch = int(on[np.argmin(np.linalg.norm(patches.centre[on] - place, axis=1))])
    buffer = teaching.item_buffer(patches, patch, resolution=RESOLUTION)
    row = buffer.row()
    truth = radiosity.form_factors(patches, tolerance=1e-4).row(patch)
    surfaces = patches.surface[buffer.patch]
    found, exact = (np.bincount(surfaces, weights=w, minlength=len(scene.surfaces)) for w in (row, truth))
    print(f"{name}: patch {patch}, {np.count_nonzero(row)} patches seen, the row sums to {row.sum():.6f}")
    for k in np.argsort(-found)[:5]:
        print(f"  {scene.surfaces[k].name:24} {found[k]:.5f}, integrated over the patch {exact[k]:.5f}")
    # One hemicube sees from the middle of the patch alone. What it makes of the whole patch is off by the second
    # derivative of the view over it, of the order of the patch's size over the distance of what it sees, squared.
    print(np.abs(found-exact).max())
    teaching.draw_item_buffer(patches, patch, resolution=RESOLUTION).savefig(OUT / f"item_buffer_{name}.png")


top, side = teaching.delta_form_factors(RESOLUTION)
assert np.isclose(top.sum() + 4 * side.sum(), 1, rtol=1e-13)  # all pixels together are the hemisphere

box = radiosity.scenes.cornell_box()
show("cornell_box", box, box.patches(max_edge=0.05), "floor", [0.3, 0.0, 0.17])
