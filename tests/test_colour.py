"""From bands to colours."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from radiosity.colour import LUMINANCE, developed, luminance, matching_functions, to_rgb, wavelengths_of
from radiosity.picture import save_image

CIE_1931 = {
    450: (0.3362, 0.0380, 1.7721),
    500: (0.0049, 0.3230, 0.2720),
    550: (0.4334, 0.9950, 0.0087),
    600: (1.0622, 0.6310, 0.0008),
    650: (0.2835, 0.1070, 0.0000),
}
"""Tabulated by the CIE (CIE 15)."""


def test_matching_functions_are_near_the_table() -> None:
    found = matching_functions(list(CIE_1931))
    # Wyman, Sloan and Shirley 2013, figure 3: their fit is within 0.02 of the table in x and y, and 0.03 in z.
    assert np.abs(found - list(CIE_1931.values())).max(axis=0) == pytest.approx(0, abs=0.03)


@pytest.mark.parametrize("count", [5, 31, 76])
def test_equal_energy_has_the_chromaticity_of_e(count: int) -> None:
    edges = np.linspace(390, 730, count + 1)
    rgb = to_rgb(np.full((2, 3, count), 2.0), 0.5 * (edges[1:] + edges[:-1]))
    assert rgb.shape == (2, 3, 3)
    np.testing.assert_allclose(rgb @ LUMINANCE, 2.0, rtol=1e-3)
    # X = Y = Z of the equal-energy spectrum, through the matrix of IEC 61966-2-1.
    np.testing.assert_allclose(rgb[0, 0] / 2, [1.2048, 0.9483, 0.9089], atol=0.05 if count > 5 else 0.2)


def test_hues_of_single_wavelengths() -> None:
    nm = np.arange(400.0, 701.0, 10.0)
    pure = to_rgb(np.eye(len(nm)), nm)
    assert [int(pure[list(nm).index(at)].argmax()) for at in (450, 530, 620)] == [2, 1, 0]


def test_bands_that_are_wavelengths() -> None:
    assert wavelengths_of(["400 nm", "404.5nm"]) == [400.0, 404.5]
    assert wavelengths_of(["R", "G", "B"]) is None
    assert wavelengths_of(["400 nm", "heat"]) is None
    assert wavelengths_of([]) is None


def test_bands_that_are_none_are_as_they_were() -> None:
    image = np.array([[[0.1, 0.2, 0.6]]])
    np.testing.assert_array_equal(developed(image, ["R", "G", "B"]), image)
    np.testing.assert_allclose(developed(image[..., :2], ["a", "b"]), np.full((1, 1, 3), 0.15))
    assert luminance(image, ["R", "G", "B"])[0, 0] == pytest.approx(0.2126 * 0.1 + 0.7152 * 0.2 + 0.0722 * 0.6)


def test_a_picture_of_wavelengths_is_in_colour(tmp_path: Path) -> None:
    bands = [f"{nm} nm" for nm in range(400, 701, 20)]
    image = np.zeros((4, 6, len(bands)), np.float32)
    image[:, :3, bands.index("460 nm")] = image[:, 3:, bands.index("640 nm")] = 1
    save_image(tmp_path / "a.png", image, bands=bands)
    pixels = np.asarray(Image.open(tmp_path / "a.png").convert("RGB")).astype(int)
    assert (pixels[:, :3, 2] > pixels[:, :3, 0] + 50).all()
    assert (pixels[:, 3:, 0] > pixels[:, 3:, 2] + 50).all()


def test_what_is_refused() -> None:
    with pytest.raises(ValueError, match="do not fit"):
        to_rgb(np.ones((2, 3)), [400, 500])
    with pytest.raises(ValueError, match="must rise"):
        to_rgb(np.ones(2), [500, 400])
    with pytest.raises(ValueError, match="visible"):
        to_rgb(np.ones(2), [5000, 6000])
