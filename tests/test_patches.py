"""Cutting scenes into patches."""

from __future__ import annotations

import numpy as np
import pytest
from known import cube, square

from radiosity import Scene, SceneError, Surface


def mixed() -> Scene:
    """Two triangles and a quad, then a tall quad."""
    triangles = Surface([*square(), [1.5, 0, 0]], [[0, 1, 2], [0, 2, 3]], name="triangles")
    quads = Surface(square(2.0, z=1.0), [[3, 2, 1, 0], [0, 1, 2, 3]], name="quads", two_sided=True)
    return Scene([triangles, quads])


def test_as_is_keeps_surfaces_faces_and_corners_in_order() -> None:
    patches = mixed().patches(as_is=True)
    assert patches.surface.tolist() == [0, 0, 1, 1]
    assert patches.face.tolist() == [0, 1, 0, 1]
    assert patches.two_sided.tolist() == [False, False, True, True]
    flat, tall = np.array(square()), np.array(square(2.0, z=1.0))
    # A triangle repeats its last corner.
    expected = [flat[[0, 1, 2, 2]], flat[[0, 2, 3, 3]], tall[[3, 2, 1, 0]], tall]
    assert np.array_equal(patches.polygons, expected)


def test_area_centre_and_normal_follow_from_the_corners() -> None:
    patches = mixed().patches(as_is=True)
    assert patches.area == pytest.approx([0.5, 0.5, 4.0, 4.0])
    assert patches.normal == pytest.approx(np.array([[0, 0, 1], [0, 0, 1], [0, 0, -1], [0, 0, 1]]))
    third = 0.5 / 3
    assert patches.centre == pytest.approx(np.array([[third, -third, 0], [-third, third, 0], [0, 0, 1], [0, 0, 1]]))


def test_shapes_and_types() -> None:
    patches = cube().patches(count=100)
    n = len(patches)
    assert patches.polygons.shape == (n, 4, 3)
    assert patches.centre.shape == patches.normal.shape == (n, 3)
    assert patches.area.shape == patches.surface.shape == patches.face.shape == patches.two_sided.shape == (n,)
    assert patches.polygons.dtype == patches.area.dtype == patches.centre.dtype == patches.normal.dtype == np.float64
    assert np.issubdtype(patches.surface.dtype, np.integer)
    assert patches.two_sided.dtype == np.bool_
    assert patches.reflectance.shape == patches.emission.shape == (n, 1)


@pytest.mark.parametrize("cut", [{"count": 500}, {"max_edge": 0.11}])
def test_patches_cover_the_surfaces_exactly(cut: dict[str, float]) -> None:
    patches = cube().patches(**cut)
    assert np.bincount(patches.surface, patches.area) == pytest.approx(np.ones(6))
    # The normals of the inside of a cube point to its middle.
    assert np.all(np.sum(patches.normal * (0.5 - patches.centre), axis=1) > 0)


def test_no_edge_is_longer_than_allowed() -> None:
    polygons = cube().patches(max_edge=0.11).polygons
    edges = np.linalg.norm(polygons - np.roll(polygons, -1, axis=1), axis=-1)
    assert edges.max() <= 0.11 * (1 + 1e-12)
    assert edges.max() > 0.11 / 2


def test_a_count_is_met_about() -> None:
    assert len(cube().patches(count=1000)) == pytest.approx(1000, rel=0.2)


def test_cutting_is_deterministic() -> None:
    first, second = (mixed().patches(count=300).polygons.tobytes() for _ in range(2))
    assert first == second


def test_exactly_one_way_of_cutting() -> None:
    for wrong in ({}, {"count": 5, "as_is": True}, {"max_edge": 0.1, "count": 5}):
        with pytest.raises(ValueError, match="exactly one of max_edge, count and as_is"):
            cube().patches(**wrong)


@pytest.mark.parametrize("cut", [{"max_edge": 0}, {"max_edge": -1}, {"max_edge": float("nan")}, {"count": 0}])
def test_impossible_sizes_are_refused(cut: dict[str, float]) -> None:
    with pytest.raises(SceneError, match="cube: meshing: "):
        cube().patches(**cut)
