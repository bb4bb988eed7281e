"""The classical comparison: ray tracing without and with ambient light, radiosity, and path tracing."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest
from known import cube

import radiosity
from radiosity import ferren as module
from radiosity.comparison import Panel, common_exposure, difference, draw, off_edges, seen
from radiosity.direct import ambient_of, direct_picture
from radiosity.picture import camera_of, render
from radiosity.scenes import ferren, mirror_room

SIZE = {"width": 96, "height": 96}
INSIDE = radiosity.Camera.look_at((0.5, 0.5, 0.9), (0.4, 0.6, 0.1))
FRONTS = [f"board {k} front" for k in range(1, 8)]
Masks = dict[str, npt.NDArray[np.bool_]]


@pytest.fixture(scope="module")
def lit() -> radiosity.Solution:
    """The sculpture on a mesh that light between the patches' values is accurate on, too."""
    return radiosity.solve(ferren(), accuracy=0.02)


def masks(scene: radiosity.Scene) -> Masks:
    """Pixels that show nothing but one front, by name."""
    surface = seen(scene, scene.cameras[0], **SIZE)
    index = {s.name: k for k, s in enumerate(scene.surfaces)}
    found = {name: (surface == index[name]) & off_edges(surface) for name in FRONTS}
    assert all(mask.sum() > 50 for mask in found.values())
    return found


def test_fronts_are_black_by_direct_light() -> None:
    scene = ferren()
    image = render(scene, mode="direct", samples=16, **SIZE)
    assert all(not image[mask].any() for mask in masks(scene).values())
    assert image.max() > 0


def test_fronts_are_white_by_ambient_light(lit: radiosity.Solution) -> None:
    ambient = ambient_of(lit)
    image = render(lit, mode="whitted", samples=16, **SIZE)
    expected = np.array(module.WHITE) * ambient / math.pi
    for mask in masks(lit.patches.scene).values():
        np.testing.assert_allclose(image[mask], np.broadcast_to(expected, (mask.sum(), 3)), rtol=1e-5)
    # White under daylight: the window has this colour.
    np.testing.assert_allclose(ambient / ambient.sum(), np.array(module.DAYLIGHT) / sum(module.DAYLIGHT), rtol=1e-3)
    given = render(lit.patches.scene, mode="whitted", ambient=2.0, samples=16, **SIZE)
    front = masks(lit.patches.scene)[FRONTS[0]]
    np.testing.assert_allclose(given[front], 0.8 * 2 / math.pi, rtol=1e-5)


def test_fronts_have_the_colour_of_the_paint_in_the_radiosity_picture(lit: radiosity.Solution) -> None:
    image = render(lit, mode="gather", samples=64, **SIZE)
    for k, mask in enumerate(masks(lit.patches.scene).values(), start=1):
        colour = image[mask].mean(axis=0)
        paint = np.array(module.PAINTS[k % len(module.PAINTS)])
        assert np.corrcoef(colour, paint)[0, 1] > 0.7


def test_without_paint_the_radiosity_picture_is_neutral() -> None:
    scene = ferren(paints=[module.WHITE], daylight=(300.0, 300.0, 300.0))
    solution = radiosity.solve(scene.patches(count=1500), accuracy=0.1)
    image = render(solution, mode="gather", samples=16, **SIZE)
    for mask in masks(scene).values():
        assert image[mask].mean() > 0.1
        # One band is like another to rounding: rays are the same for all.
        np.testing.assert_allclose(image[mask].mean(axis=0), image[mask].mean(), rtol=1e-5)


def test_radiosity_and_path_tracing_agree_within_their_noise(lit: radiosity.Solution) -> None:
    scene = lit.patches.scene
    # Independent gathers, whose spread is the error of their mean.
    gathers = np.array([render(lit, mode="gather", samples=64, seed=seed, **SIZE) for seed in range(4)])
    traced = radiosity.path_trace(scene, samples=512, seed=9, **SIZE)
    for mask in masks(scene).values():
        each = gathers[:, mask].mean(axis=1)
        of_gather = each.std(axis=0, ddof=1) / math.sqrt(len(each))
        of_paths = np.linalg.norm(traced.standard_error[mask], axis=0) / mask.sum()
        apart = np.abs(each.mean(axis=0) - traced.image[mask].mean(axis=0))
        # And what the solution itself is wrong by: its error of 2 % is of single places, and of all surfaces.
        own = 0.015 * each.mean()
        assert (apart < 4 * np.hypot(of_gather, of_paths) + own).all()


def test_a_furnace_by_direct_and_by_ambient_light() -> None:
    solution = radiosity.solve(cube().patches(count=100), accuracy=0.01)
    # Every wall sees emission 1 all around, so that the direct irradiance is 1, and all of it B = 2.
    np.testing.assert_allclose(ambient_of(solution), 1, rtol=0.02)
    view = {"width": 24, "height": 16, "samples": 64}
    np.testing.assert_allclose(render(solution, INSIDE, mode="direct", **view), 1.5 / math.pi, rtol=1e-5)
    np.testing.assert_allclose(render(cube(), INSIDE, mode="whitted", ambient=1, **view), 2 / math.pi, rtol=1e-5)
    shown = render(cube(), INSIDE, mode="direct", show="irradiance", **view)
    np.testing.assert_allclose(shown, 1, rtol=1e-5)


def test_ambient_light_is_worth_all_interreflection(cornell: radiosity.Solution) -> None:
    p = cornell.patches
    black = [radiosity.Surface(s.vertices, s.faces, 0.0, s.emission, s.name) for s in p.scene.surfaces]
    direct = radiosity.path_irradiance(radiosity.Scene(black).patches(count=800), samples=256).irradiance
    weight = p.area[:, None] * p.reflectance
    even = (weight * (direct + ambient_of(cornell))).sum()
    # Each side knows its light to better than half a percent: the solution to 5 % a patch, on 800 of them.
    assert even == pytest.approx((weight * cornell.irradiance).sum(), rel=0.01)


def test_mirrors_are_followed() -> None:
    scene = mirror_room()
    camera = scene.cameras[0]
    surface = seen(scene, camera, 48, 48)
    mirror = surface == [s.name for s in scene.surfaces].index("mirror")
    image, traced = (render(scene, camera, mode=m, width=48, height=48, samples=64) for m in ("direct", "path"))
    assert mirror.sum() > 20
    # The mirror itself is black: what it shows are lamps and what they light.
    assert (image[mirror].max(axis=1) > 0).any()
    assert (image[mirror] <= traced[mirror] + 0.2 * traced[mirror].mean()).mean() > 0.9


def test_direct_pictures_are_the_same_on_any_number_of_threads() -> None:
    one, two = (direct_picture(ferren(), samples=4, threads=threads, **SIZE) for threads in (1, 2))
    assert one.tobytes() == two.tobytes()


def test_noise_explains_the_difference_of_panels(cornell: radiosity.Solution) -> None:
    view = {"width": 32, "height": 32, "samples": 32}
    gathered, traced = (draw(mode, cornell, **view) for mode in ("gather", "path"))
    where = off_edges(seen(cornell.patches.scene, cornell.patches.scene.cameras[0], 32, 32))
    found = difference(gathered, traced, where)
    # Two numbers tell the variance of the gather in a pixel, and few pixels are much noisier than others.
    assert found.rms == pytest.approx(found.noise, rel=0.2)
    assert math.isnan(difference(draw("direct", cornell, **view), traced, where).noise)
    assert math.isnan(difference(gathered, traced, np.zeros_like(where)).rms)


def test_the_exposure_is_that_of_the_radiosity_picture() -> None:
    def panel(mode: str, value: float) -> Panel:
        return Panel(mode, np.full((2, 2, 3), value, np.float32))  # type: ignore[arg-type]

    panels = [panel("direct", 8.0), panel("path", 4.0), panel("gather", 0.18)]
    assert common_exposure(panels, ["R", "G", "B"]) == pytest.approx(0, abs=1e-6)
    assert common_exposure(panels[:2], ["R", "G", "B"]) == pytest.approx(math.log2(0.18 / 4))
    assert common_exposure([panel("direct", 0.0)], ["R", "G", "B"]) == 0


def test_what_is_refused() -> None:
    with pytest.raises(ValueError, match="mode 'whitted' draws a solution"):
        render(cube(), INSIDE, mode="whitted")
    with pytest.raises(ValueError, match="ambient is for mode 'whitted'"):
        render(cube(), INSIDE, mode="direct", ambient=1)
    with pytest.raises(ValueError, match="cannot show 'irradiance'"):
        render(cube(), INSIDE, mode="whitted", ambient=1, show="irradiance")


def test_what_is_seen() -> None:
    scene = cube()
    assert set(np.unique(seen(scene, INSIDE, 20, 20))) <= set(range(6))
    outside = camera_of([], scene.patches(as_is=True).polygons)
    looked = seen(scene, outside, 20, 20)
    # Through the backs of the nearest walls, and past the cube.
    assert (looked >= 0).any()
    assert (looked < 0).any()
