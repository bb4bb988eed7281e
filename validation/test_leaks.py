"""No light where there can be none, and no dark rims where there is light, on coarse meshes."""

from __future__ import annotations

import leaks
import numpy as np
import pytest

import radiosity

COARSE = 0.5
"""Longest edge, m, in a room of six metres: no wall but those of the room lies on such a grid."""


LEFT = {
    # Two small patches touch in one point of the roof, on either side: of cells at that point, closer to its plane
    # than rounding, the pair engine cannot tell on which side they are.
    ("lean_to", "auto"): 1e-6,
    # Parts of the sheet outside the room share an edge with the wall that hides the room from them.
    ("partition_into_walls", "auto"): 1e-6,
    ("partition_into_walls", "hierarchical"): 1e-4,
}
"""What form factors leave in the dark, W/m2, where a few W/m2 are in the light; nothing elsewhere."""


LEFT_WHERE_TURNED = {"sampled": 0.0, "hierarchical": 3e-4, "auto": 5e-5}
"""The same where all is rounded: between edges that no longer meet exact visibility finds slits of some micrometres."""


def solved(patches: radiosity.Patches, transport: str) -> radiosity.Solution:
    if transport == "sampled":
        return radiosity.solve(patches, accuracy=0.05, seed=1)
    given = radiosity.form_factors(patches, method="auto", tolerance=1e-3) if transport == "auto" else transport
    return radiosity.solve(patches, accuracy=0.05, seed=1, transport=given)


@pytest.mark.parametrize("transport", ["sampled", "hierarchical", "auto"])
@pytest.mark.parametrize("name", leaks.CORPUS)
def test_dark_is_dark(name: str, transport: str) -> None:
    leak = leaks.CORPUS[name]()
    solution = solved(leak.scene.patches(max_edge=COARSE), transport)
    assert leaks.most_light_in_the_dark(leak, solution) <= LEFT.get((name, transport), 0.0)
    assert solution.irradiance.max() > 0.5


@pytest.mark.parametrize("name", ["thin_sheet", "turned_wall", "lean_to", "stacked_boxes", "staircase"])
def test_without_lines_of_contact_light_leaks(name: str) -> None:
    """What the corpus is for: the same meshes without the lines do leak."""
    leak = leaks.CORPUS[name]()
    solution = solved(leak.scene.patches(max_edge=COARSE, contacts=False), "sampled")
    assert leaks.most_light_in_the_dark(leak, solution) > 0.02


def rims(leak: leaks.Leak, coarse: radiosity.Solution, fine: radiosity.Solution) -> np.ndarray:
    """Relative deviations of coarse patches in the light from the mean of the fine ones on them."""
    patches, parts = coarse.patches, fine.patches
    mean = np.average(fine.irradiance[:, 0], weights=parts.area)
    deviations = []
    for i in np.flatnonzero(~leak.dark_sides(patches)[0]):
        on = np.flatnonzero(parts.surface == patches.surface[i])
        corners = patches.polygons[i]
        inward = np.cross(patches.normal[i], np.roll(corners, -1, axis=0) - corners)
        offsets = parts.centre[on, None] - corners
        level = np.abs((parts.centre[on] - corners[0]) @ patches.normal[i]) < 1e-6
        within = on[level & np.all(np.sum(offsets * inward, axis=2) > 0, axis=1)]
        if parts.area[within].sum() > 0.6 * patches.area[i]:
            expected = np.average(fine.irradiance[within, 0], weights=parts.area[within])
            deviations.append((coarse.irradiance[i, 0] - expected) / max(expected, 0.2 * mean))
    return np.array(deviations)


RIM = 0.25
"""What a coarse patch may be off by, at most: fine centres do not cover it evenly, and each is found to a few percent.
A patch that is half in the dark is off by half."""


@pytest.mark.parametrize(
    "name",
    [
        "thin_sheet",
        *(pytest.param(name, marks=pytest.mark.slow) for name in leaks.CORPUS if name not in ("thin_sheet", "poster")),
    ],
)
def test_lit_patches_at_joints_are_as_bright_as_finer_ones(name: str) -> None:
    leak = leaks.CORPUS[name]()
    fine = radiosity.solve(leak.scene.patches(max_edge=0.12), accuracy=0.02, seed=2)
    deviations = rims(leak, solved(leak.scene.patches(max_edge=COARSE), "sampled"), fine)
    assert len(deviations) > 100
    assert np.abs(deviations).max() < RIM
    assert abs(deviations.mean()) < 0.02


@pytest.mark.slow
@pytest.mark.parametrize("transport", ["sampled", "hierarchical", "auto"])
@pytest.mark.parametrize("name", leaks.CORPUS)
def test_turned_and_rounded_dark_is_dark(name: str, transport: str) -> None:
    """Files hold single precision: nothing meets exactly."""
    leak = leaks.CORPUS[name]().turned()
    solution = solved(leak.scene.patches(max_edge=COARSE), transport)
    assert leaks.most_light_in_the_dark(leak, solution) <= LEFT_WHERE_TURNED[transport]


@pytest.mark.slow
@pytest.mark.parametrize("max_edge", [3.0, 0.8, 0.21])
@pytest.mark.parametrize("name", leaks.CORPUS)
def test_dark_is_dark_however_fine(name: str, max_edge: float) -> None:
    leak = leaks.CORPUS[name]()
    solution = solved(leak.scene.patches(max_edge=max_edge), "sampled")
    assert leaks.most_light_in_the_dark(leak, solution) == 0.0
