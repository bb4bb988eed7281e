"""What is on the screen are the solution's numbers through the tone curve."""

import numpy as np
from conftest import Open, pixels
from scenes import Seen, cornell, developed, lit

SIZE, EVERY = 512, 8


def test_pixels_are_radiance_through_the_tone_curve(open_lit: Open) -> None:
    solution = cornell()
    page = open_lit(lit(solution), width=SIZE, height=SIZE)
    page.evaluate("radiosity.setSettings({ isExposureAutomatic: false, exposure: 1.5 })")
    seen = Seen(solution, SIZE, EVERY)
    shown = pixels(page)[seen.y, seen.x].astype(float)
    inner = seen.inner(solution, SIZE, EVERY)
    expected = developed(seen.radiance(solution), 1.5)
    assert inner.sum() > 2000
    # Eight bits, and rays that meet the surface at the centre of a pixel to half a thousandth of it.
    difference = np.abs(shown - expected)[inner]
    assert np.quantile(difference, 0.99) <= 2
    assert difference.max() <= 6


def test_automatic_exposure_makes_the_mean_middle_grey(open_lit: Open) -> None:
    solution = cornell()
    page = open_lit(lit(solution), width=SIZE, height=SIZE)
    pixels(page)
    radiance = Seen(solution, SIZE, 4).radiance(solution)
    luminance = radiance @ [0.2126, 0.7152, 0.0722]
    mean = np.exp(np.log(luminance[luminance > 0]).mean())
    # The page measures a few thousand of other pixels: lamps and edges weigh a little differently.
    assert np.isclose(page.evaluate("radiosity.exposure") / np.pi, 0.18 / mean / np.pi / np.pi, rtol=0.05)


def test_quantities_in_plain_numbers(open_lit: Open) -> None:
    solution = cornell()
    page = open_lit(lit(solution), width=SIZE, height=SIZE)
    page.evaluate("radiosity.setSettings({ quantity: 'reflectance', falseColours: false })")
    seen = Seen(solution, SIZE, EVERY)
    inner = seen.inner(solution, SIZE, EVERY)
    rho = solution.reflectance[seen.patch]
    encoded = 255 * np.where(rho <= 0.0031308, 12.92 * rho, 1.055 * rho ** (1 / 2.4) - 0.055)
    assert np.abs(pixels(page)[seen.y, seen.x] - encoded)[inner].max() <= 1
