"""The empty cube of 1984, and the box with measured spectra."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from known import Call
from PIL import Image

import radiosity
from radiosity import cornell_spectra, goral
from radiosity.colour import to_rgb
from radiosity.picture import render
from radiosity.scenes import cornell_box, cornell_box_spectral, goral_box


def names_of(patches: radiosity.Patches) -> np.ndarray:
    return np.array([s.name for s in patches.scene.surfaces])[patches.surface]


def test_the_cube_has_49_patches_a_side() -> None:
    patches = goral_box().patches(as_is=True)
    names = names_of(patches)
    assert len(patches) == 294
    assert all((names == side).sum() == 49 for side in ("floor", "left wall", "front"))
    np.testing.assert_allclose(patches.area, 1 / 49)
    # All look into the cube.
    inward = np.array([0.5, 0.5, 0.5]) - patches.centre
    assert (np.einsum("nk,nk->n", inward, patches.normal) > 0).all()
    with pytest.raises(ValueError, match="at least 1"):
        goral_box(0)


def test_the_cube_is_closed_and_its_light_is_where_it_should_be() -> None:
    patches = goral_box().patches(as_is=True)
    factors = radiosity.form_factors(patches, tolerance=1e-6)
    np.testing.assert_allclose(factors.closure(), 1, atol=1e-5)
    solution = radiosity.solve(patches, transport=factors, accuracy=1e-3)
    # What is emitted is absorbed, to the residual of the solver and the closure.
    absorbed = patches.area @ ((1 - patches.reflectance) * solution.irradiance)
    np.testing.assert_allclose(absorbed, np.array(goral.DAYLIGHT), rtol=1e-3)
    names = names_of(patches)
    floor, ceiling = (solution.irradiance[names == side].mean(axis=0) for side in ("floor", "ceiling"))
    np.testing.assert_allclose(floor, ceiling, rtol=1e-3)
    # Red on the left, where x is 1, and blue on the right, and white between them has it from both.
    left = solution.irradiance[(names == "floor") & (patches.centre[:, 0] > 0.9)].mean(axis=0)
    right = solution.irradiance[(names == "floor") & (patches.centre[:, 0] < 0.1)].mean(axis=0)
    assert left[0] / left[2] > 1.05
    assert right[2] / right[0] > 1.05


def test_the_cube_is_seen_through_its_front() -> None:
    solution = radiosity.solve(goral_box().patches(as_is=True), accuracy=0.05)
    image = render(solution, width=40, height=40, samples=4)
    red, blue = image[15:25, 2:6].mean(axis=(0, 1)), image[15:25, -6:-2].mean(axis=(0, 1))
    assert red[0] > 3 * red[2]
    assert blue[2] > 3 * blue[0]


def test_measured_spectra_reduce_to_known_colours() -> None:
    # By pbrt-v3, RGBSpectrum::FromSampled with the tables of the CIE, of the same data.
    known = {"white": (0.8869, 0.6969, 0.6668), "green": (0.1053, 0.3775, 0.0765), "red": (0.5713, 0.0424, 0.0445)}
    for name, rgb in known.items():
        found = to_rgb(cornell_spectra.REFLECTANCE[name], cornell_spectra.WAVELENGTHS)
        # The fit of the matching functions is that far from the tables.
        np.testing.assert_allclose(found, rgb, rtol=0.01, atol=0.003)
    lamp = to_rgb(cornell_spectra.RADIANCE, cornell_spectra.WAVELENGTHS)
    np.testing.assert_allclose(lamp, (20.747, 10.823, 2.765), rtol=0.01)


def test_the_spectral_box_is_the_measured_one() -> None:
    scene, original = cornell_box_spectral(), cornell_box("original")
    assert len(scene.bands) == 76
    assert (scene.bands[0], scene.bands[-1]) == ("400 nm", "700 nm")
    for ours, theirs in zip(scene.surfaces, original.surfaces, strict=True):
        np.testing.assert_array_equal(ours.vertices, theirs.vertices)
    by_name = {s.name: s for s in scene.surfaces}
    assert by_name["left_wall"].reflectance[50] == 0.287
    assert by_name["right_wall"].reflectance[25] == 0.285
    assert by_name["tall_block"].reflectance[0] == 0.343
    np.testing.assert_allclose(by_name["light"].emission[[0, 25, 50, 75]], np.pi * np.array([0, 8, 15.6, 18.4]))


def test_wider_bands_hold_the_means() -> None:
    scene = cornell_box_spectral(19)
    assert scene.bands[:2] == ["406 nm", "422 nm"]
    floor = next(s for s in scene.surfaces if s.name == "floor")
    assert floor.reflectance[0] == pytest.approx((0.343 + 0.445 + 0.551 + 0.624) / 4)
    for bad in (0, 3, 77):
        with pytest.raises(ValueError, match="must divide the 76"):
            cornell_box_spectral(bad)


def test_a_band_is_what_it_would_be_alone() -> None:
    together = radiosity.solve(cornell_box_spectral(2).patches(count=400), accuracy=0.05)
    assert together.irradiance.shape[1] == 2
    # Longer wavelengths have more of the lamp.
    assert together.irradiance[:, 1].mean() > 2 * together.irradiance[:, 0].mean()
    same = radiosity.solve(cornell_box_spectral(4).patches(count=400), accuracy=0.05)
    # The mean of two narrow bands is the wide one, but for what paint and lamp do together within it.
    halves = same.irradiance.reshape(-1, 2, 2).mean(axis=2).mean(axis=0)
    np.testing.assert_allclose(halves, together.irradiance.mean(axis=0), rtol=0.05)


def test_spectra_are_developed_and_kept(call: Call, tmp_path: Path) -> None:
    quick = ["--width", 40, "--height", 40, "--samples", 4, "--patches", 300, "--accuracy", 0.1]
    call("render", "builtin:cornell-box-spectral", "-o", "a.png", "-o", "a.exr", *quick)
    pixels = np.asarray(Image.open(tmp_path / "a.png").convert("RGB")).astype(int)
    left, right = pixels[15:25, 2:6].mean(axis=(0, 1)), pixels[15:25, -6:-2].mean(axis=(0, 1))
    assert left[0] > 2 * left[1]
    assert right[1] > right[0] > right[2]
    header = (tmp_path / "a.exr").read_bytes()[:4000]
    assert all(name in header for name in (b"400 nm", b"552 nm", b"700 nm"))
