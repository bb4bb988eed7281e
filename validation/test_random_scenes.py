"""What must hold of form factors in any scene: closure, shadows that only take, and no dependence on how it is put."""

from __future__ import annotations

import numpy as np
import pytest
from known_pairs import patches_of
from random_rooms import box, cut_in_front, moved, patches_of_surfaces, random_room, random_rotation, walls

import radiosity

few_seeds = pytest.mark.parametrize("seed", range(6))
tolerances = pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4])


def factors(surfaces: list[radiosity.Surface], tolerance: float, **options: object) -> np.ndarray:
    return radiosity.form_factors(patches_of_surfaces(surfaces), tolerance=tolerance, **options).toarray()


def closure_error(surfaces: list[radiosity.Surface], tolerance: float) -> tuple[float, int]:
    """The greatest deviation of a row sum from 1, and whose."""
    off = np.abs(radiosity.form_factors(patches_of_surfaces(surfaces), tolerance=tolerance).closure() - 1)
    return float(off.max()), int(np.argmax(off))


@tolerances
def test_rows_sum_to_one_in_a_closed_room(tolerance: float) -> None:
    for seed in range(12):
        off, patch = closure_error(random_room(seed), tolerance)
        assert off <= tolerance, f"seed {seed}, patch {patch}"


@pytest.mark.slow
@tolerances
def test_rows_sum_to_one_in_many_closed_rooms(tolerance: float) -> None:
    for seed in range(12, 150):
        off, patch = closure_error(random_room(seed), tolerance)
        assert off <= tolerance, f"seed {seed}, patch {patch}"


@pytest.mark.parametrize(
    ("seed", "tolerance"),
    [
        # Patches 26 and 34, on opposite walls: a corner hides 4.4e-5 of what they exchange, between all first points.
        (5, 1e-5),
        (5, 1e-6),
        # The same of patches 14 and 26, by 6.5e-6 and 3.5e-6.
        (3, 1e-6),
        (0, 1e-6),
        # Patch 19, of 0.0064 m2 on a solid, sees 1.101e-3 of the wall that is patch 4 past an edge.
        (827, 1e-3),
    ],
)
def test_rows_sum_to_one_where_little_is_hidden_or_visible(seed: int, tolerance: float) -> None:
    off, patch = closure_error(random_room(seed), tolerance)
    assert off <= tolerance, f"patch {patch} is off by {off / tolerance} tolerances"


@pytest.mark.parametrize(
    ("half", "gap", "tolerance"),
    [
        # What is seen through the gaps are strips narrower than the spacing of any first points.
        ((0.17, 0.165, 0.175), 3.5e-4, 1e-3),
        ((0.27, 0.19, 0.30), 1.3e-3, 1e-4),
        ((0.20, 0.15, 0.25), 1e-3, 1e-5),
        ((0.25, 0.055, 0.255), 1e-6, 1e-4),
    ],
)
def test_rows_sum_to_one_beside_narrow_gaps(half: tuple[float, float, float], gap: float, tolerance: float) -> None:
    # An upright box in the corner of the room, a narrow gap off three walls of nine patches each.
    centre = np.array(half) + gap
    off, patch = closure_error([*walls(3), box(centre, np.array(half), np.eye(3), "box")], tolerance)
    assert off <= tolerance, f"patch {patch} is off by {off / tolerance} tolerances"


@few_seeds
def test_shadows_only_take(seed: int) -> None:
    tolerance = 1e-4
    patches = patches_of_surfaces(random_room(seed))
    F = radiosity.form_factors(patches, tolerance=tolerance).toarray()
    rng = np.random.default_rng(seed)
    for i, j in rng.choice(np.argwhere(F > 0), 40):
        alone = radiosity.form_factors(
            patches_of(*(_corners(patches.polygons[k]) for k in (i, j))), method="analytic", threads=1
        ).row(0)[1]
        assert F[i, j] <= alone + tolerance, (i, j)


def _corners(polygon: np.ndarray) -> np.ndarray:
    return polygon[:3] if np.array_equal(polygon[2], polygon[3]) else polygon


@few_seeds
def test_the_unit_of_length_does_not_matter(seed: int) -> None:
    tolerance, room = 1e-4, random_room(seed)
    F = factors(room, tolerance)
    for scale in (1e-3, 1e3):
        # Each is within the tolerance of the truth.
        np.testing.assert_allclose(factors(moved(room, scale), tolerance), F, rtol=0, atol=2 * tolerance)


@few_seeds
def test_where_the_scene_is_and_how_it_is_turned_does_not_matter(seed: int) -> None:
    tolerance, room = 1e-4, random_room(seed)
    rng = np.random.default_rng(seed)
    turned = moved(room, turn=random_rotation(rng), shift=rng.normal(size=3))
    np.testing.assert_allclose(factors(turned, tolerance), factors(room, tolerance), rtol=0, atol=2 * tolerance)


@few_seeds
def test_the_order_of_patches_does_not_matter(seed: int) -> None:
    tolerance, room = 1e-4, random_room(seed)
    order = np.random.default_rng(seed).permutation(len(room))
    first = np.cumsum([0, *(len(s.faces) for s in room)])
    patch = np.concatenate([np.arange(first[k], first[k + 1]) for k in order])
    F = factors(room, tolerance)[np.ix_(patch, patch)]
    np.testing.assert_allclose(factors([room[k] for k in order], tolerance), F, rtol=0, atol=2 * tolerance)


@pytest.mark.parametrize("method", ["auto", "contour", "analytic"])
def test_what_is_behind_the_other_does_not_count(method: str) -> None:
    rng, tolerance, tried = np.random.default_rng(1), 1e-7, 0
    while tried < 60:
        a, b = rng.normal(size=(2, 3, 3)) + rng.normal(size=(2, 1, 3)) / 2
        a_in_front, b_in_front = cut_in_front(a, b), cut_in_front(b, a)
        is_cut = len(a_in_front) > 3 or len(b_in_front) > 3
        if min(len(a_in_front), len(b_in_front)) < 3 or not is_cut:
            continue
        tried += 1
        options = {"method": method, "threads": 1} | ({} if method == "analytic" else {"tolerance": tolerance})
        whole = radiosity.form_factors(patches_of(a, b), **options)
        parts = radiosity.form_factors(patches_of(a_in_front, b_in_front), method="analytic", threads=1)
        exchange, expected = whole.area[0] * whole.row(0)[1], parts.area[0] * parts.row(0)[1]
        assert exchange == pytest.approx(expected, abs=1.1 * tolerance * whole.area.min())
