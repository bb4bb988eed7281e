"""The Cornell box against an independent reference (Mitsuba's ray tracer, good to 0.05 %)."""

from __future__ import annotations

import numpy as np
import pytest

import radiosity


def relative_rms(irradiance: np.ndarray, reference: dict[str, np.ndarray]) -> float:
    """Area-weighted RMS error over three channels over the area-weighted mean; emitting patches are left out."""
    dark = reference["emission"].sum(axis=1) == 0
    weight = reference["area"][dark] / reference["area"][dark].sum()
    squared = (weight[:, None] * (irradiance - reference["E"])[dark] ** 2).sum() / 3
    return float(np.sqrt(squared) / ((weight[:, None] * reference["E"][dark]).sum() / 3))


@pytest.mark.parametrize("accuracy", [0.05, 0.02, 0.01])
def test_error_is_what_was_asked_for_and_known(
    accuracy: float, cornell: dict[str, np.ndarray], cornell_patches: radiosity.Patches
) -> None:
    solution = radiosity.solve(cornell_patches, accuracy=accuracy, seed=5)
    truth = relative_rms(solution.irradiance, cornell)
    assert truth < 1.15 * accuracy  # the estimate itself has a spread of some per cent
    assert solution.report.reached
    assert 0.5 < solution.report.estimated_error / truth < 2


def test_one_per_cent_means_below_one_per_cent(
    cornell: dict[str, np.ndarray], cornell_patches: radiosity.Patches
) -> None:
    errors = [
        relative_rms(radiosity.solve(cornell_patches, accuracy=0.01, seed=seed).irradiance, cornell) for seed in (1, 2)
    ]
    assert max(errors) < 0.01


def test_mean_is_not_biased(cornell: dict[str, np.ndarray], cornell_patches: radiosity.Patches) -> None:
    # Seeing whole patches at constant radiosity would leave the mean 0.44 % low, chiefly because of floor patches
    # half under the blocks.
    solution = radiosity.solve(cornell_patches, accuracy=0.01, seed=9)
    dark = cornell["emission"].sum(axis=1) == 0
    weight = cornell["area"][dark][:, None]
    ratio = (weight * solution.irradiance[dark]).sum() / (weight * cornell["E"][dark]).sum()
    assert ratio == pytest.approx(1, abs=0.002)


def test_per_patch_errors_are_standard_errors(
    cornell: dict[str, np.ndarray], cornell_patches: radiosity.Patches
) -> None:
    solution = radiosity.solve(cornell_patches, accuracy=0.02, seed=4)
    dark = (cornell["emission"].sum(axis=1) == 0) & (cornell["covered"] < 0.999)
    sigma = np.hypot(solution.error, cornell["sem"])[dark].mean(axis=1)
    deviation = (solution.irradiance - cornell["E"])[dark].mean(axis=1)
    # With four replicates the ratio follows Student's t with three degrees of freedom: 4.3 % lie beyond 3.
    beyond = np.mean(np.abs(deviation) > 3 * sigma)
    assert beyond < 0.09
    assert np.mean(np.abs(deviation) > sigma) > 0.15  # and the errors are not inflated


def test_blocks_bury_the_floor_they_stand_on(
    cornell: dict[str, np.ndarray], cornell_patches: radiosity.Patches
) -> None:
    solution = radiosity.solve(cornell_patches, accuracy=0.05)
    assert np.all(solution.irradiance[cornell["covered"] == 1] == 0)
