"""The city and the crater: what their docstrings promise."""

from __future__ import annotations

import numpy as np
import pytest

import radiosity
from radiosity import scenes


def test_the_same_seed_gives_the_same_city() -> None:
    once, again, other = (scenes.city(2, seed=s).patches(as_is=True).polygons for s in (4, 4, 5))
    assert np.array_equal(once, again)
    assert not np.array_equal(once, other)


def test_a_city_covers_its_ground_once() -> None:
    patches = scenes.city(3).patches(as_is=True)
    size = 3 * (2 * 28 + 18) + 18
    upward = patches.normal[:, 1] > 0.5
    assert patches.area[upward].sum() == pytest.approx(size**2)  # streets, pavements and roofs
    assert np.all(patches.polygons[..., 1] >= 0)


def test_walls_face_out() -> None:
    scene = scenes.city(1)
    patches = scene.patches(as_is=True)
    wall = np.abs(patches.normal[:, 1]) < 0.5
    # The mean of height times normal over closed boxes without floors: nothing sideways.
    sideways = (patches.area[:, None] * patches.normal)[wall].sum(axis=0)
    assert np.abs(sideways).max() < 1e-9 * patches.area.sum()
    # By the divergence theorem, out of volumes: the sum of centre . normal times area is positive.
    volume = np.einsum("i,ij,ij->", patches.area[wall], patches.centre[wall], patches.normal[wall]) / 2
    roofs = patches.area[~wall] * patches.centre[~wall, 1]
    assert volume == pytest.approx(roofs.sum())


def test_an_even_sky_brings_level_ground_what_it_says() -> None:
    scene = scenes.city(1, sky=50)
    vertical = sum(
        np.asarray(light.irradiance) * -light.direction[1]
        for light in scene.lights[1:]
        if isinstance(light, radiosity.DirectionalLight)
    )
    assert vertical == pytest.approx([90, 130, 200])


def test_a_crater_has_the_facets_asked_for_and_faces_up() -> None:
    scene = scenes.crater(5000, craters=5, seed=2)
    patches = scene.patches(as_is=True)
    assert len(patches) == 5000
    assert np.all(patches.normal[:, 1] > 0)
    # What is above a square of 600 m.
    assert (patches.area * patches.normal[:, 1]).sum() == pytest.approx(600**2)


def test_the_first_crater_is_a_fifth_as_deep_as_wide() -> None:
    scene = scenes.crater(80_000, craters=1, roughness=0.0)
    height = np.asarray(scene.surfaces[0].vertices)[:, 1]
    assert -height.min() / 300 == pytest.approx(0.2, rel=0.02)  # a quarter of 600 m is its radius
    assert height.max() / 300 == pytest.approx(0.04, rel=0.05)


@pytest.mark.parametrize(
    ("make", "options"),
    [(scenes.city, {"blocks": 0}), (scenes.city, {"elevation": 0.0}), (scenes.city, {"tallest": 1.0}),
     (scenes.city, {"sky": -1}), (scenes.crater, {"facets": 1}), (scenes.crater, {"elevation": 91.0}),
     (scenes.crater, {"size": 0.0})],
)  # fmt: skip
def test_numbers_out_of_range_are_refused(make: object, options: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="must"):
        make(**options)  # type: ignore[operator]
