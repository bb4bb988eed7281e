"""Shooting: limits, determinism, going on, files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import radiosity
from radiosity.shooting import ShootingSolution, load_state


@pytest.fixture(scope="module")
def patches() -> radiosity.Patches:
    return radiosity.scenes.cornell_box().patches(count=400)


def shot(patches: radiosity.Patches, accuracy: float = 0.1, **options: object) -> ShootingSolution:
    solution = radiosity.solve(patches, solver="shooting", accuracy=accuracy, **options)  # type: ignore[arg-type]
    assert isinstance(solution, ShootingSolution)
    return solution


@pytest.fixture(scope="module")
def rough(patches: radiosity.Patches) -> ShootingSolution:
    return shot(patches)


def test_reaches_the_accuracy_and_balances(rough: ShootingSolution) -> None:
    report = rough.report
    assert report.reached
    assert report.estimated_error <= 0.1
    assert abs(report.imbalance) < 1e-12
    emitted = np.array(report.emitted) - report.absorbed - report.escaped - report.lost_on_backs
    assert np.abs(emitted).max() < 1e-9 * max(report.emitted)
    assert "rays" in str(report)


def test_bytes_do_not_depend_on_threads(patches: radiosity.Patches, rough: ShootingSolution) -> None:
    for threads in (1, 3):
        again = shot(patches, threads=threads)
        assert again.irradiance.tobytes() == rough.irradiance.tobytes()
        assert again.report.to_dict(timed=False) == rough.report.to_dict(timed=False)


def test_seeds_differ(patches: radiosity.Patches, rough: ShootingSolution) -> None:
    assert not np.array_equal(shot(patches, seed=1).irradiance, rough.irradiance)


def test_refined_is_as_if_asked_at_once(patches: radiosity.Patches, rough: ShootingSolution) -> None:
    at_once = shot(patches, 0.02)
    refined = rough.refine(accuracy=0.02)
    started = shot(patches, 0.02, start=rough)
    assert refined.report.rounds > rough.report.rounds
    for solution in (refined, started):
        assert solution.irradiance.tobytes() == at_once.irradiance.tobytes()
        assert solution.error.tobytes() == at_once.error.tobytes()
    assert rough.report.estimated_error > 0.02  # and the rough one stays as it is


def test_state_goes_through_a_file(patches: radiosity.Patches, rough: ShootingSolution, tmp_path: Path) -> None:
    path = tmp_path / "state.npz"
    rough.save_state(path)
    loaded = load_state(patches, path)
    assert loaded.irradiance.tobytes() == rough.irradiance.tobytes()
    on = load_state(patches, path, accuracy=0.03)
    assert on.irradiance.tobytes() == rough.refine(accuracy=0.03).irradiance.tobytes()
    assert [p.name for p in tmp_path.iterdir()] == ["state.npz"]


def test_a_state_of_another_scene_is_refused(rough: ShootingSolution, tmp_path: Path) -> None:
    rough.save_state(tmp_path / "state.npz")
    moved = radiosity.scenes.cornell_box()
    for surface in moved.surfaces:  # all of them, so that it is cut into as many patches
        surface.vertices = 1.001 * np.asarray(surface.vertices)
    with pytest.raises(ValueError, match="another scene"):
        load_state(moved.patches(count=400), tmp_path / "state.npz")
    with pytest.raises(ValueError, match="patches"):
        load_state(moved.patches(count=100), tmp_path / "state.npz")


def test_damaged_states_are_refused(patches: radiosity.Patches, rough: ShootingSolution, tmp_path: Path) -> None:
    path = tmp_path / "state.npz"
    path.write_bytes(b"no archive")
    with pytest.raises(ValueError, match=r"state\.npz"):
        load_state(patches, path)
    rough.save_state(path)
    arrays = dict(np.load(path))
    for name, value in {"counts": arrays["counts"] + 1, "sums": arrays["sums"][1:], "format": np.array("x")}.items():
        np.savez(path, **(arrays | {name: value}))
        with pytest.raises(ValueError, match="cannot go on from this file"):
            load_state(patches, path)
    with pytest.raises(ValueError, match=r"\.npz"):
        rough.save_state(tmp_path / "state.txt")


def test_limits_are_told(patches: radiosity.Patches) -> None:
    few = shot(patches, 1e-4, max_rays=512)
    assert few.report.limited_by == "max_rays"
    late = shot(patches, 1e-4, time_limit=0.05)
    assert late.report.limited_by == "time"
    assert not late.report.reached
    with pytest.raises(radiosity.ResourceError):
        shot(patches, memory_limit=10_000)


def test_what_makes_no_sense_is_refused(patches: radiosity.Patches, rough: ShootingSolution) -> None:
    with pytest.raises(ValueError, match="accuracy"):
        shot(patches, -1.0)
    with pytest.raises(ValueError, match="time_limit"):
        shot(patches, time_limit=0.0)
    with pytest.raises(ValueError, match="other patches"):
        shot(radiosity.scenes.cornell_box().patches(count=50), start=rough)
    with pytest.raises(ValueError, match="shooting"):
        radiosity.solve(patches, solver="jacobi", time_limit=1.0)
    with pytest.raises(ValueError, match="start"):
        shot(patches, start=radiosity.solve(patches, accuracy=0.2))


def test_relit_is_shot_afresh(rough: ShootingSolution) -> None:
    dark = rough.relight(reflectance=0.0)
    assert dark.irradiance.sum() < rough.irradiance.sum()
    assert np.array_equal(rough.relight().irradiance, rough.irradiance)
    assert dark.refine(accuracy=0.05).report.reached


def test_progress_is_told_and_may_stop_it(patches: radiosity.Patches) -> None:
    class EnoughError(Exception):
        pass

    def stop(done: int, total: int) -> None:
        raise EnoughError

    with pytest.raises(EnoughError):
        shot(patches, 1e-4, progress=stop)


def test_no_light_is_no_light() -> None:
    plate = radiosity.Surface([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], 0.5)
    lamp = radiosity.PointLight((0, 0, -1), 1.0)  # behind the plate, whose back is black
    solution = shot(radiosity.Scene([plate], lights=[lamp]).patches(as_is=True))
    assert np.all(solution.irradiance == 0)
    assert solution.report.reached


def test_both_sides_of_a_plate_in_the_middle_of_a_lit_box() -> None:
    scene = radiosity.scenes.furnace(0.4, 1.0)
    low, high = np.array([0.4, 0.9, 0.4]), np.array([0.6, 0.9, 0.6])
    corners = [[low[0], 0.9, low[2]], [low[0], 0.9, high[2]], [high[0], 0.9, high[2]], [high[0], 0.9, low[2]]]
    scene.surfaces.append(radiosity.Surface(corners, [[0, 1, 2, 3]], 0.4, 1.0, "plate", two_sided=True))
    solution = shot(scene.patches(count=300), 0.02)
    plate = solution.patches.two_sided
    # In a furnace H = E / (1 - rho) everywhere.
    for irradiance in (solution.irradiance[plate], solution.back_irradiance[plate]):
        assert irradiance.mean() == pytest.approx(1 / 0.6, rel=0.05)
