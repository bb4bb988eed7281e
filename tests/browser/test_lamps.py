"""Lamps are mixed in the page, with no server: light is linear."""

import numpy as np
from browsing import Open, pixels
from scenes import Seen, developed, two_lamps

from radiosity.files import LitModel
from radiosity.viewer import layers
from radiosity.viewer.lit import Lit


def test_a_slider_that_is_moved_shows_the_right_sum(open_lit: Open) -> None:
    solution = two_lamps()
    model, lamps = LitModel.of(solution), layers.lamps(solution.patches)
    assert [lamp.name for lamp in lamps] == ["warm lamp", "cold lamp"]
    page = open_lit(Lit(model, layers.layers(solution, lamps, model), lamps), width=1100, height=600)
    page.evaluate("radiosity.setSettings({ isExposureAutomatic: false, exposure: -1 })")

    # With keys, as somebody without a mouse would; the slider is a square, so that it is fine near zero.
    slider = page.get_by_label("warm lamp: dimmer")
    slider.focus()
    slider.press("Home")
    for _ in range(60):
        slider.press("ArrowRight")
    page.get_by_label("cold lamp: factor").fill("2")
    page.get_by_label("cold lamp: factor").press("Enter")
    page.get_by_label("cold lamp: filter").fill("#ff8000")
    warm, cold = page.evaluate("radiosity.lamps.map(({ dimmer }) => dimmer)")
    assert np.isclose(warm, 4 * 0.3**2, atol=0.005) and cold == 2

    orange = 2 * np.array([1.0, ((128 / 255 + 0.055) / 1.055) ** 2.4, 0.0])
    emission = solution.emission.copy()
    names = np.array([s.name for s in solution.patches.scene.surfaces])[solution.patches.surface]
    emission[names == "warm lamp"] *= warm
    emission[names == "cold lamp"] *= orange
    expected = solution.relight(emission=emission)
    picture = pixels(page)
    seen = Seen(solution, picture.shape, every=7)
    inner = seen.inner(solution)
    assert inner.sum() > 1000
    difference = np.abs(picture[seen.y, seen.x] - developed(seen.radiance(expected), -1))[inner]
    assert np.quantile(difference, 0.99) <= 2
    assert picture[..., 0].mean() > 2 * picture[..., 2].mean()

    page.get_by_label("warm lamp", exact=True).uncheck()
    page.get_by_label("cold lamp", exact=True).uncheck()
    assert pixels(page)[seen.y, seen.x][inner].max() == 0


def test_without_layers_and_session_lamps_say_why_they_are_fixed(open_lit: Open) -> None:
    solution = two_lamps()
    page = open_lit(Lit(LitModel.of(solution), (), layers.lamps(solution.patches)), width=1100, height=600)
    assert page.get_by_label("warm lamp: dimmer").is_disabled()
    assert "layers" in page.locator(".lamps .reason").inner_text()
