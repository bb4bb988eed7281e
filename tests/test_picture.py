"""Pictures of solutions."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from known import cube
from PIL import Image

from radiosity import Camera, Solution, solve
from radiosity.picture import render, save_image

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
