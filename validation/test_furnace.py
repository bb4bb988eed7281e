"""Where everything glows alike nothing can be seen: B = E / (1 - rho), whatever the shapes."""

from __future__ import annotations

import numpy as np
import pytest

import radiosity


@pytest.mark.parametrize("rho", [0.5, 0.9, 0.99])
def test_furnace_with_rows_scaled_to_closure(rho: float) -> None:
    scene = radiosity.scenes.furnace(rho, 1.0)
    solution = radiosity.solve(scene.patches(count=1200), accuracy=0.05, closure="exact", seed=3)
    np.testing.assert_allclose(solution.radiosity * (1 - rho), 1.0, rtol=1e-6)
    report = solution.report
    # Raw row sums are reported as measured: near 1 but not at it, and not scaled.
    assert 0.5 < report.closure_min < 0.999
    assert 1.001 < report.closure_max < 1.5
    assert report.closure_mean == pytest.approx(1, abs=0.01)
    assert report.closure_residual < 1e-8


def test_each_band_is_a_furnace_of_its_own() -> None:
    rho, emission = np.array([0.2, 0.5, 0.8, 0.9, 0.95]), np.array([1.0, 2.0, 0.5, 0.0, 3.0])
    solution = radiosity.solve(
        radiosity.scenes.furnace(rho, emission).patches(count=400), closure="exact", accuracy=0.1
    )
    expected = np.broadcast_to(emission / (1 - rho), solution.radiosity.shape)
    np.testing.assert_allclose(solution.radiosity, expected, rtol=1e-6)


def test_no_ray_escapes_a_closed_furnace() -> None:
    solution = radiosity.solve(radiosity.scenes.furnace(0.5, 1.0).patches(count=2000), accuracy=0.02, seed=1)
    assert solution.report.rays > 100_000
    assert solution.report.escape_share == 0
    assert abs(solution.report.imbalance) < 1e-3


@pytest.mark.parametrize("rho", [0.9, 0.99])
def test_rows_balanced_to_the_accuracy_keep_it_at_high_reflectance(rho: float) -> None:
    # What rows lack is lost at every bounce, so a deviation d of the row sums costs d / (1 - rho).
    for accuracy in (0.05, 0.01):
        solution = radiosity.solve(radiosity.scenes.furnace(rho, 1.0).patches(count=600), accuracy=accuracy, seed=3)
        error = np.abs(solution.radiosity * (1 - rho) - 1).max()
        assert error < accuracy
        assert solution.report.estimated_error < accuracy
