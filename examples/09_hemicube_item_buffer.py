"""What a patch sees, pixel by pixel on a hemicube; and the form factors that add up to.

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


def nearest(patches: radiosity.Patches, surface: str, place: list[float]) -> int:
    """The patch of a surface whose middle is nearest to a place."""
    names = [s.name for s in patches.scene.surfaces]
    distance = np.linalg.norm(patches.centre - place, axis=1)
    return int(np.argmin(np.where(patches.surface == names.index(surface), distance, np.inf)))


def by_surface(patches: radiosity.Patches, row: np.ndarray, sides: np.ndarray) -> np.ndarray:
    return np.bincount(patches.surface[sides], weights=row, minlength=len(patches.scene.surfaces))


top, side = teaching.delta_form_factors(RESOLUTION)
assert np.isclose(top.sum() + 4 * side.sum(), 1, rtol=1e-13)  # all pixels together are the hemisphere

# The Cornell box, from the floor between the blocks and the open front.
box = radiosity.scenes.cornell_box()
patches = box.patches(max_edge=0.05)
patch = nearest(patches, "floor", [0.30, 0.0, 0.17])
buffer = teaching.item_buffer(patches, patch, resolution=RESOLUTION)
row = buffer.row()
assert np.isclose(row.sum() + buffer.to_nothing() + buffer.to_backs(), 1, rtol=1e-13)

# From a point the factor to what is in full view, such as the light, is a closed form. Pixels that its outline crosses
# are taken whole or not at all. Some of them are as many too many as others are too few: one part in a hundred is left.
light = next(s for s in box.surfaces if s.name == "light")
exact = teaching.nusselt_form_factor(buffer.position, buffer.axes[2], light.vertices[light.faces[0]])
found = by_surface(patches, row, buffer.patch)[box.surfaces.index(light)]
print(
    f"the light from the middle of patch {patch}: {found:.6f} by {RESOLUTION} pixels an edge, closed form {exact:.6f}"
)
assert np.isclose(found, exact, rtol=0.01)

# For the patch one hemicube on its middle is an approximation. It is off by the curvature of the view over the patch:
# of the order of the square of the patch's size, 0.05 m, over the distance of what is near, 0.3 m: some 0.03 of it.
truth = by_surface(patches, radiosity.form_factors(patches, tolerance=1e-3).row(patch), buffer.patch)
pixels = by_surface(patches, row, buffer.patch)
print("from the middle by pixels, and from the whole patch to 0.001:")
for k in np.argsort(-pixels)[:6]:
    print(f"  {box.surfaces[k].name:12} {pixels[k]:.4f} {truth[k]:.4f}")
assert np.allclose(pixels, truth, rtol=0.05, atol=0.003)
teaching.draw_item_buffer(patches, patch, resolution=RESOLUTION).savefig(OUT / "item_buffer_cornell_box.png")

# The furnished room, from the floor beside the dining table.
room = radiosity.scenes.furnished_room(0)
patches = room.patches(max_edge=0.5)
patch = nearest(patches, "floor", [2.75, 0.0, 1.25])
figure = teaching.draw_item_buffer(patches, patch, resolution=RESOLUTION, names=14)
figure.savefig(OUT / "item_buffer_room.png")
