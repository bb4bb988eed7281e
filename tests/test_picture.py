"""Pictures of solutions."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from known import cube
from PIL import Image

from radiosity import Camera, PointLight, Solution, path_irradiance, path_trace, solve
from radiosity.files import load_lit
from radiosity.picture import legend_of, render, save_image

SMALL = {"width": 24, "height": 16, "samples": 2}


@pytest.fixture(scope="module")
def furnace() -> Solution:
    """B = 1 / (1 - 1/2) = 2 everywhere in a cube."""
    return solve(cube().patches(count=100), accuracy=0.01)


INSIDE = Camera.look_at((0.5, 0.5, 0.9), (0.4, 0.6, 0.1))


@pytest.mark.parametrize("mode", ["smooth", "patches"])
def test_the_inside_of_a_furnace_is_uniform(furnace: Solution, mode: str) -> None:
    image = render(furnace, INSIDE, mode=mode, **SMALL)
    assert image.shape == (16, 24, 1)
    # Radiosity is shown as radiance, B / pi; the solve is good to 1 % on average, a patch to a few.
    np.testing.assert_allclose(image, 2 / math.pi, rtol=0.05)


def test_quantities_have_their_own_scale(furnace: Solution) -> None:
    np.testing.assert_allclose(render(furnace, INSIDE, show="irradiance", **SMALL), 2, rtol=0.1)
    np.testing.assert_allclose(render(furnace, INSIDE, show="emission", **SMALL), 1, rtol=1e-6)


def test_the_same_picture_on_any_number_of_threads(cornell: Solution) -> None:
    one, two = (render(cornell, threads=threads, **SMALL) for threads in (1, 2))
    assert one.tobytes() == two.tobytes()
    assert one.shape == (16, 24, 3)


def test_left_is_left_and_up_is_up(cornell: Solution) -> None:
    image = render(cornell, width=60, height=60, samples=4)
    red, green = image[:, :15].sum(axis=(0, 1)), image[:, -15:].sum(axis=(0, 1))
    assert red[0] > 2 * red[1]
    assert green[1] > green[0]
    lamp = np.unravel_index(np.argmax(image.sum(axis=2)), (60, 60))
    assert lamp[0] < 20


def test_png_and_exr(cornell: Solution, tmp_path: Path) -> None:
    image = render(cornell, **SMALL)
    for exposure in ("auto", 0.0, -20.0):
        save_image(tmp_path / "a.png", image, exposure=exposure)
        pixels = np.asarray(Image.open(tmp_path / "a.png").convert("RGB"))
        assert pixels.shape == (16, 24, 3)
        assert (pixels.max() > 100) == (exposure != -20.0)
    save_image(tmp_path / "a.exr", image)
    assert (tmp_path / "a.exr").read_bytes()[:4] == b"\x76\x2f\x31\x01"
    with pytest.raises(ValueError, match=r"cannot write '\.bmp' pictures; use \.png or \.exr"):
        save_image(tmp_path / "a.bmp", image)


def test_false_colours_tell_their_scale(tmp_path: Path) -> None:
    image = np.linspace(0, 5, 24 * 16, dtype=np.float32).reshape(16, 24, 1)
    scale = save_image(tmp_path / "a.png", image, false_colours=True)
    assert scale is not None
    assert 0 <= scale[0] < scale[1] <= 5
    assert len(np.unique(np.asarray(Image.open(tmp_path / "a.png").convert("RGB")).reshape(-1, 3), axis=0)) > 100


def test_a_legend_makes_the_picture_wider_and_leaves_it_as_it_is(tmp_path: Path) -> None:
    image = np.linspace(0, 5, 24 * 160, dtype=np.float32).reshape(160, 24, 1)
    save_image(tmp_path / "a.png", image, false_colours=True)
    save_image(tmp_path / "b.png", image, false_colours=True, legend=legend_of("irradiance"))
    bare, told = (np.asarray(Image.open(tmp_path / f"{k}.png").convert("RGB")) for k in "ab")
    assert told.shape[0] == 160
    assert told.shape[1] > 24 + 80
    np.testing.assert_array_equal(told[:, :24], bare)
    assert np.any(told[:, 24:] == 0)


@pytest.mark.parametrize("mode", ["gather", "path"])
def test_the_inside_of_a_furnace_is_uniform_by_paths_too(furnace: Solution, mode: str) -> None:
    size = {"width": 24, "height": 16, "samples": 64, "mode": mode}
    image = render(furnace, INSIDE, **size)
    assert image.shape == (16, 24, 1)
    np.testing.assert_allclose(image, 2 / math.pi, rtol=0.25)
    assert image.mean() == pytest.approx(2 / math.pi, rel=0.01)
    assert render(furnace, INSIDE, show="irradiance", **size).mean() == pytest.approx(2, rel=0.01)


@pytest.mark.parametrize("mode", ["gather", "path"])
def test_traced_pictures_are_the_same_on_any_number_of_threads(cornell: Solution, mode: str) -> None:
    one, two, other = (
        render(cornell, mode=mode, width=33, height=20, samples=8, threads=threads, seed=seed)
        for threads, seed in [(1, 0), (2, 0), (2, 1)]
    )
    assert one.tobytes() == two.tobytes()
    assert one.tobytes() != other.tobytes()


def test_scenes_are_path_traced_without_a_solution() -> None:
    scene = cube()
    traced = path_trace(scene, INSIDE, width=24, height=16, samples=64)
    sigma = float(np.linalg.norm(traced.standard_error)) / traced.image.size
    assert traced.image.mean() == pytest.approx(2 / math.pi, abs=4 * sigma)
    assert 0 < traced.effort.relative_error < 0.1
    assert traced.effort.rays > 24 * 16 * 64
    np.testing.assert_array_equal(render(scene, INSIDE, mode="path", width=24, height=16, samples=64), traced.image)
    shown = render(scene, INSIDE, mode="path", show="error", width=24, height=16, samples=64)
    np.testing.assert_array_equal(shown, traced.standard_error)


def test_what_modes_cannot_do_they_say(furnace: Solution) -> None:
    with pytest.raises(ValueError, match="mode 'gather' cannot show 'error'; it shows radiosity, irradiance"):
        render(furnace, mode="gather", show="error")
    with pytest.raises(ValueError, match="mode 'smooth' draws a solution: solve the scene first, or use mode 'path'"):
        render(cube())
    with pytest.raises(ValueError, match="accuracy is for mode 'path'"):
        render(furnace, accuracy=0.1)
    with pytest.raises(ValueError, match="there is no mode 'rough'"):
        render(furnace, mode="rough")
    with pytest.raises(ValueError, match="samples must be from 1"):
        render(furnace, mode="path", samples=0)
    with pytest.raises(ValueError, match="accuracy must be a positive number"):
        render(furnace, mode="path", accuracy=-1, **SMALL)


def test_an_exception_from_progress_stops_the_tracing(cornell: Solution) -> None:
    def stop(done: int, total: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        path_trace(cornell, samples=1 << 16, progress=stop)
    with pytest.raises(KeyboardInterrupt):
        path_irradiance(cornell, samples=1 << 20, progress=stop)


def test_lights_without_area_are_in_lit_models(tmp_path: Path) -> None:
    scene = cube(0.5, emission=0.0)
    scene.lights = [PointLight((0.5, 0.5, 0.5), 2.0, "bulb")]
    solution = solve(scene.patches(count=100), accuracy=0.05).relight(lights=3.0)
    solution.save(tmp_path / "lit.glb")
    lit = load_lit(tmp_path / "lit.glb")
    assert lit is not None
    assert lit.lights == [("point", "bulb", [0.5, 0.5, 0.5], [0, 0, 0], 0, 0, [3.0])]
    size = {"width": 24, "height": 16, "samples": 64, "mode": "gather"}
    one, two = render(solution, INSIDE, **size), render(lit, INSIDE, **size)
    assert one.mean() == pytest.approx(two.mean(), rel=1e-3)
    # Without it, its direct light would be missing, which is half of all with a reflectance of a half.
    without = render(replace(lit, lights=[]), INSIDE, **size)
    assert without.mean() < 0.7 * one.mean()


def test_irradiance_at_points_and_of_patches() -> None:
    patches = cube().patches(as_is=True)
    found = path_irradiance(patches, accuracy=0.01, seed=3)
    assert found.effort.reached
    assert found.irradiance.shape == found.error.shape == (6, 1)
    assert np.all(np.abs(found.irradiance - 2) < 5 * found.error)
    assert found.back_irradiance is not None
    assert np.all(np.isnan(found.back_irradiance))
    middle = path_irradiance(patches, [0.5, 0.5, 0.5], [0, 0, 3], samples=256)
    assert middle.irradiance[0, 0] == pytest.approx(2, abs=5 * middle.error[0, 0])
    with pytest.raises(ValueError, match="points and normals go together"):
        path_irradiance(patches, [[0.5, 0.5, 0.5]])
    with pytest.raises(ValueError, match="normals not zero"):
        path_irradiance(patches, [[0.5, 0.5, 0.5]], [0, 0, 0])
