"""The estimated error against the true one, on scenes with converged answers."""

from __future__ import annotations

import numpy as np
import pytest

import radiosity


def keyhole() -> radiosity.Scene:
    """A bright room lights a dark one through a small hole: a few patches decide everything behind it."""
    from pieces import rectangle  # noqa: PLC0415

    rho = 0.6
    walls = [
        rectangle([0, 0, 0], [2, 0, 0], [0, 1, 0], rho, name="floor", cells=(16, 8)),
        rectangle([0, 0, 1], [0, 1, 0], [2, 0, 0], rho, name="ceiling", cells=(8, 16)),
        rectangle([0, 0, 0], [0, 0, 1], [2, 0, 0], rho, name="front", cells=(8, 16)),
        rectangle([2, 1, 0], [0, 0, 1], [-2, 0, 0], rho, name="back", cells=(8, 16)),
        rectangle([0, 0, 0], [0, 1, 0], [0, 0, 1], rho, name="left", cells=(8, 8)),
        rectangle([2, 1, 0], [0, -1, 0], [0, 0, 1], rho, name="right", cells=(8, 8)),
        rectangle([0.4, 0.4, 0.99], [0, 0.2, 0], [0.2, 0, 0], 0.0, 100.0, name="lamp"),
    ]
    # The partition at x = 1 with a hole of 0.25 x 0.25 in its middle, from four strips.
    strips = [
        ((0, 0), (1, 0.375)),
        ((0, 0.625), (1, 0.375)),
        ((0, 0.375), (0.375, 0.25)),
        ((0.625, 0.375), (0.375, 0.25)),
    ]
    for k, ((y, z), (dy, dz)) in enumerate(strips):
        strip = rectangle([1, y, z], [0, dy, 0], [0, 0, dz], rho, name=f"partition {k}", cells=(4, 3))
        strip.two_sided = True
        walls.append(strip)
    return radiosity.Scene(walls, name="keyhole")


def relative_rms(solution: radiosity.Solution, truth: radiosity.Solution, mask: np.ndarray | None = None) -> float:
    """Area-weighted RMS difference of irradiance over the mean."""
    mask = np.ones(len(solution.patches), bool) if mask is None else mask
    weight = solution.patches.area[mask] / solution.patches.area[mask].sum()
    difference = weight @ (solution.irradiance - truth.irradiance)[mask] ** 2
    return float(np.sqrt(difference.mean()) / (weight @ truth.irradiance[mask]).mean())


@pytest.mark.parametrize("accuracy", [0.05, 0.02])
def test_light_through_a_keyhole(accuracy: float) -> None:
    patches = keyhole().patches(as_is=True)
    truth = radiosity.solve(patches, accuracy=accuracy / 8, seed=100)
    solution = radiosity.solve(patches, accuracy=accuracy, seed=1)
    error = relative_rms(solution, truth)
    assert 0.5 < solution.report.estimated_error / error < 2
    # Behind the hole irradiance is far below the mean; its own error bars must still hold there.
    dark = patches.centre[:, 0] > 1.01
    sigma = np.sqrt(np.average(solution.error[dark] ** 2, weights=patches.area[dark], axis=0)).mean()
    level = np.average(truth.irradiance[dark], weights=patches.area[dark], axis=0).mean()
    assert relative_rms(solution, truth, dark) < 2 * sigma / level


@pytest.mark.slow
@pytest.mark.parametrize("accuracy", [0.1, 0.05, 0.03])
def test_furnished_room(accuracy: float) -> None:
    patches = radiosity.scenes.furnished_room(0).patches(count=2500)
    truth = radiosity.solve(patches, accuracy=0.015, seed=100)
    for seed in (1, 2):
        solution = radiosity.solve(patches, accuracy=accuracy, seed=seed)
        error = relative_rms(solution, truth)
        assert 0.5 < solution.report.estimated_error / error < 2
