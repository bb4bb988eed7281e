"""What is on the screen are the solution's numbers through the tone curve."""

import numpy as np
from browsing import Open, pixels
from scenes import Seen, cornell, developed, encoded, lit


def test_pixels_are_radiance_through_the_tone_curve(open_lit: Open) -> None:
    solution = cornell()
    page = open_lit(lit(solution))
    page.evaluate("radiosity.setSettings({ isExposureAutomatic: false, exposure: 1.5 })")
    picture = pixels(page)
    seen = Seen(solution, picture.shape, every=6)
    shown = picture[seen.y, seen.x].astype(float)
    inner = seen.inner(solution)
    expected = developed(seen.radiance(solution), 1.5)
    assert inner.sum() > 1000
    # Eight bits, and rays that meet the surface at the centre of a pixel to half a thousandth of it.
    difference = np.abs(shown - expected)[inner]
    assert np.quantile(difference, 0.99) <= 2
    assert difference.max() <= 6


def test_automatic_exposure_makes_the_mean_middle_grey(open_lit: Open) -> None:
    solution = cornell()
    page = open_lit(lit(solution))
    picture = pixels(page)
    radiosity = np.pi * Seen(solution, picture.shape, every=4).radiance(solution)
    luminance = radiosity @ [0.2126, 0.7152, 0.0722]
    mean = np.exp(np.log(luminance[luminance > 0]).mean())
    # The page measures a few thousand other pixels: lamps and edges weigh a little differently.
    assert np.isclose(page.evaluate("radiosity.exposure"), 0.18 / mean, rtol=0.05)


def test_reflectance_is_shown_as_it_is(open_lit: Open) -> None:
    solution = cornell()
    page = open_lit(lit(solution))
    page.evaluate("radiosity.setSettings({ quantity: 'reflectance', falseColours: false })")
    picture = pixels(page)
    seen = Seen(solution, picture.shape, every=6)
    shown = picture[seen.y, seen.x]
    difference = np.abs(shown - 255 * encoded(solution.reflectance[seen.patch]))
    assert difference[seen.inner(solution)].max() <= 1
