"""Shooting: whether it is true, its error honest, and its rate as it should be."""

from __future__ import annotations

import numpy as np
import pytest
from pieces import rectangle
from test_cornell import relative_rms

import radiosity


def shot(patches: radiosity.Patches, accuracy: float, **options: object) -> radiosity.Solution:
    return radiosity.solve(patches, solver="shooting", accuracy=accuracy, **options)  # type: ignore[arg-type]


def rms_difference(a: radiosity.Solution, b: radiosity.Solution) -> float:
    """Root mean square over area and bands, relative to the mean."""
    weight = a.patches.area / a.patches.area.sum()
    square = weight @ ((a.irradiance - b.irradiance) ** 2).mean(axis=1)
    return float(np.sqrt(square) / (weight @ b.irradiance.mean(axis=1)))


@pytest.mark.parametrize("rho", [0.5, 0.9, 0.99])
def test_furnace(rho: float) -> None:
    patches = radiosity.scenes.furnace(rho, 1.0).patches(count=150)
    solution = shot(patches, 0.02)
    truth = 1 / (1 - rho)
    weight = patches.area / patches.area.sum()
    error = np.sqrt(weight @ (solution.irradiance[:, 0] / truth - 1) ** 2)
    assert solution.report.reached
    # Of about 150 patches with three degrees of freedom each, the estimate is good to some 10 %.
    assert error < 1.5 * solution.report.estimated_error
    # Nothing leaves a closed box, so the mean is exact up to what is not shot any more: 1e-4 of the power.
    assert weight @ solution.irradiance[:, 0] == pytest.approx(truth, rel=3e-4)


@pytest.mark.parametrize("accuracy", [0.05, 0.02, 0.01])
def test_error_is_what_was_asked_for_and_known(
    accuracy: float, cornell: dict[str, np.ndarray], cornell_patches: radiosity.Patches
) -> None:
    for seed in (1, 2):
        solution = shot(cornell_patches, accuracy, seed=seed)
        truth = relative_rms(solution.irradiance, cornell)
        assert solution.report.reached
        assert truth < 1.1 * accuracy
        assert 0.7 < truth / solution.report.estimated_error < 1.3


@pytest.mark.slow
def test_error_is_known_where_cells_decide_it(
    cornell: dict[str, np.ndarray], cornell_patches: radiosity.Patches
) -> None:
    for seed in range(4):
        solution = shot(cornell_patches, 0.005, seed=seed)
        truth = relative_rms(solution.irradiance, cornell)
        assert truth / solution.report.estimated_error < 1.3
        assert solution.report.discretisation_error > 0


def test_error_falls_with_rays(cornell: dict[str, np.ndarray], cornell_patches: radiosity.Patches) -> None:
    # Of Monte Carlo the error falls as rays^-0.5; even points do better until cells, which are 0.15 %, show.
    rough, fine = shot(cornell_patches, 0.1, seed=3), shot(cornell_patches, 0.008, seed=3)
    errors = [relative_rms(s.irradiance, cornell) for s in (rough, fine)]
    rays = [s.report.rays + s.report.shadow_rays for s in (rough, fine)]
    slope = np.log(errors[1] / errors[0]) / np.log(rays[1] / rays[0])
    assert slope < -0.5
    assert rays[1] > 3 * rays[0]


def test_per_patch_errors_are_standard_errors(
    cornell: dict[str, np.ndarray], cornell_patches: radiosity.Patches
) -> None:
    solution = shot(cornell_patches, 0.02, seed=4)
    dark = (cornell["emission"].sum(axis=1) == 0) & (cornell["covered"] < 0.999)
    sigma = np.hypot(solution.error, cornell["sem"])[dark].mean(axis=1)
    deviation = (solution.irradiance - cornell["E"])[dark].mean(axis=1)
    # As of other solvers: the ratio follows Student's t with three degrees of freedom.
    assert np.mean(np.abs(deviation) > 3 * sigma) < 0.09
    assert np.mean(np.abs(deviation) > sigma) > 0.15


def test_a_city_as_by_conjugate_gradient() -> None:
    patches = radiosity.scenes.city(1, sky=3).patches(count=1500)
    by_shooting, by_factors = shot(patches, 0.02), radiosity.solve(patches, accuracy=0.02)
    assert by_shooting.report.reached
    expected = np.hypot(by_shooting.report.estimated_error, by_factors.report.estimated_error)
    assert rms_difference(by_shooting, by_factors) < 1.3 * expected


def lamps_and_a_screen() -> radiosity.Patches:
    """Half a room with a point and a spot, a two-sided screen and an obstruction."""
    surfaces = [
        rectangle([0, 0, 0], [2, 0, 0], [0, 2, 0], [0.7, 0.2], name="floor", cells=(12, 12)),
        rectangle([0, 0, 0], [0, 2, 0], [0, 0, 1], [0.3, 0.8], name="left", cells=(12, 6)),
        rectangle([0, 0, 0], [0, 0, 1], [2, 0, 0], 0.6, name="front", cells=(6, 12)),
    ]
    screen = rectangle([0.7, 0.4, 0.2], [0, 1, 0], [0, 0, 0.6], [0.5, 0.9], name="screen", cells=(8, 5))
    screen.two_sided = True
    block = rectangle([1.2, 1.0, 0.3], [0.5, 0, 0], [0, 0.5, 0], name="block")
    lights: list[radiosity.scene.Light] = [
        radiosity.PointLight((0.3, 1.0, 0.8), [2.0, 1.0]),
        radiosity.SpotLight((1.5, 1.2, 0.9), (0, 0, -1), [1.0, 3.0], 0.2, 0.6),
    ]
    return radiosity.Scene([*surfaces, screen], lights=lights, obstructions=[block]).patches(as_is=True)


def test_lamps_backs_and_obstructions_as_by_conjugate_gradient() -> None:
    patches = lamps_and_a_screen()
    by_shooting, by_factors = shot(patches, 0.01), radiosity.solve(patches, accuracy=0.01)
    expected = np.hypot(by_shooting.report.estimated_error, by_factors.report.estimated_error)
    assert rms_difference(by_shooting, by_factors) < 1.3 * expected
    assert abs(by_shooting.report.imbalance) < 1e-12
    for mine, other in zip(by_shooting.report.escaped, by_factors.report.escaped, strict=True):
        assert mine == pytest.approx(other, rel=0.01)


def test_a_faint_band_is_not_starved() -> None:
    room = [
        rectangle([0, 0, 0], [1, 0, 0], [0, 1, 0], 0.5, name="floor", cells=(8, 8)),
        rectangle([0, 0, 1], [0, 1, 0], [1, 0, 0], 0.5, [10.0, 0.0], name="strong", cells=(8, 8)),
        rectangle([0, 0, 0], [0, 1, 0], [0, 0, 1], 0.5, [0.0, 1e-4], name="faint", cells=(8, 8)),
    ]
    solution = shot(radiosity.Scene(room).patches(as_is=True), 0.02)
    weight = solution.patches.area / solution.patches.area.sum()
    faint = np.sqrt(weight @ solution.error[:, 1] ** 2) / (weight @ solution.irradiance[:, 1])
    assert faint < 0.05


@pytest.mark.slow
def test_a_rough_answer_on_many_patches_is_honest() -> None:
    patches = radiosity.scenes.city(4).patches(count=200_000)
    rough, fine = shot(patches, 0.03, seed=1), shot(patches, 0.01, seed=2)
    # By patches as constant both are wrong alike.
    expected = np.hypot(rough.report.sampling_error, fine.report.sampling_error)
    assert rms_difference(rough, fine) == pytest.approx(expected, rel=0.1)
