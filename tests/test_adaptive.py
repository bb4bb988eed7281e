"""Solving on a mesh of the engine's own, and what is said of its error."""

from __future__ import annotations

import json
import time
from pathlib import Path

import numpy as np
import pytest

import radiosity
from radiosity import Scene, Solution, Surface


def rectangle(
    corner: list[float], a: list[float], b: list[float], rho: float, name: str, exitance: float = 0.0
) -> Surface:
    o, u, v = np.array(corner), np.array(a), np.array(b)
    return Surface([o, o + u, o + u + v, o + v], [[0, 1, 2, 3]], rho, exitance, name)


@pytest.fixture(scope="module")
def scene() -> Scene:
    """A floor and a desk's top under a lamp: a shadow, and nothing else."""
    return Scene([
        rectangle([0, 0, 0], [4, 0, 0], [0, 4, 0], 0.5, "floor"),
        rectangle([1.5, 1.5, 0.8], [1, 0, 0], [0, 1, 0], 0.3, "desk"),
        rectangle([1.8, 1.8, 2.5], [0, 0.4, 0], [0.4, 0, 0], 0.0, "lamp", 500.0),
    ])  # fmt: skip


@pytest.fixture(scope="module")
def solution(scene: Scene) -> Solution:
    return radiosity.solve(scene, accuracy=0.05, seed=1)


def test_the_engine_chooses_the_mesh_and_meets_the_accuracy(solution: Solution) -> None:
    report = solution.report
    assert report.reached and report.of_field and report.accuracy == 0.05
    assert report.estimated_error <= 0.05
    assert 0 < report.mesh_error <= report.estimated_error
    low, high = report.interval
    assert low < high == report.estimated_error
    assert report.meshes == len(solution.refinement) > 1
    counts = [step.patches for step in solution.refinement]
    assert counts == sorted(counts) and counts[-1] == len(solution.patches)


def test_patches_are_small_at_the_shadow_and_large_elsewhere(solution: Solution) -> None:
    patches = solution.patches
    floor = patches.surface == 0
    x = np.abs(patches.centre[:, :2] - 2.0).max(axis=1)
    # The lamp is .4 wide and 1.7 above the desk: the penumbra of its edges lies about .73 off the middle.
    shadow, far = floor & (x > 0.55) & (x < 0.95), floor & (x > 1.6)
    assert np.sqrt(patches.area[shadow].mean()) < 0.7 * np.sqrt(patches.area[far].mean())
    assert patches.area[floor].sum() == pytest.approx(16)


def test_the_field_is_right_where_light_has_a_closed_form(scene: Scene, solution: Solution) -> None:
    rng = np.random.default_rng(0)
    points = np.column_stack([rng.uniform(1.5, 2.5, (300, 2)), np.full(300, 0.8)])
    field = solution.irradiance_at(points, [0, 0, 1])[:, 0]
    # Over the desk there is nothing in the way, and the floor below it does not reach its top.
    middles = np.linspace(1.8, 2.2, 81)[:-1] + 0.0025
    lamp = np.stack(np.meshgrid(middles, middles), axis=-1).reshape(-1, 2)
    d = np.concatenate([lamp[None] - points[:, None, :2], np.full((300, len(lamp), 1), 1.7)], axis=2)
    r2 = (d**2).sum(axis=2)
    direct = 500 / np.pi * (1.7**2 / r2**2).sum(axis=1) * 0.005**2
    assert np.sqrt(np.mean((field - direct) ** 2)) < 0.05 * direct.mean()


def test_fields_are_continuous_and_not_everywhere(solution: Solution) -> None:
    corners = solution.corner_irradiance
    assert corners.shape == (len(solution.patches), 4, 1)
    inside = solution.patches.centre + 0.0
    field = solution.irradiance_at(inside, solution.patches.normal)
    assert np.all(np.isfinite(field))
    assert np.isnan(solution.irradiance_at([[2, 2, 1.5]], [[0, 0, 1]])).all()
    assert np.isnan(solution.irradiance_at([[1, 1, 0]], [[0, 0, -1]])).all(), "backs are not looked for"
    # Corners of two patches on one floor at one place have one value.
    floor = np.flatnonzero(solution.patches.surface == 0)
    place: dict[tuple[float, ...], float] = {}
    for i in floor:
        for k in range(4):
            key = tuple(solution.patches.polygons[i, k])
            assert place.setdefault(key, corners[i, k, 0]) == corners[i, k, 0]


def test_error_is_the_sum_of_its_causes(solution: Solution) -> None:
    certificate = solution.certificate
    assert set(certificate.by_cause) == {"sampling", "interreflection", "transport", "balance", "mesh"}
    together = sum(error**2 for error in certificate.by_cause.values())
    assert np.allclose(np.sqrt(together), certificate.error)
    assert certificate.error is solution.error
    likely = np.sqrt(sum(error**2 for error in certificate.whole.values()))
    low, high = certificate.interval
    assert low <= likely <= high
    assert certificate.whole[certificate.largest] == max(certificate.whole.values()) and certificate.advice
    assert "nine times in ten" in str(certificate)


def test_given_patches_answer_for_their_means_alone(scene: Scene) -> None:
    solution = radiosity.solve(scene.patches(count=200), accuracy=0.05)
    report = solution.report
    assert report.reached and not report.of_field and report.meshes == 0
    assert report.mesh_error > 0.05, "two hundred patches do not draw a shadow"
    assert report.causes["mesh"] > report.causes["sampling"]
    assert solution.certificate.largest != "mesh"


def test_most_patches_are_heeded_and_told(scene: Scene) -> None:
    solution = radiosity.solve(scene, accuracy=0.005, max_patches=700)
    assert len(solution.patches) <= 700
    assert solution.report.limited_by == "max_patches" and not solution.report.reached
    assert solution.report.estimated_error > 0.005
    with pytest.raises(radiosity.ResourceError, match="max_patches"):
        radiosity.solve(scene, accuracy=0.1, max_patches=2)


def test_the_memory_is_heeded(scene: Scene) -> None:
    solution = radiosity.solve(scene, accuracy=1e-3, memory_limit=4_000_000)
    assert solution.report.limited_by == "memory" and not solution.report.reached
    assert solution.report.memory_bytes < 12_000_000, "samples, and what they are taken on"


def test_the_time_is_heeded(scene: Scene) -> None:
    begin = time.monotonic()
    solution = radiosity.solve(scene, accuracy=1e-4, time_limit=1.0)
    assert time.monotonic() - begin < 20
    assert solution.report.limited_by == "time" and not solution.report.reached
    assert np.all(np.isfinite(solution.irradiance))


def test_focus_serves_the_surface_that_matters(scene: Scene, solution: Solution) -> None:
    focused = radiosity.solve(scene, accuracy=0.05, focus="desk", seed=1)
    assert focused.report.reached

    def share(of: Solution) -> float:
        return float(np.mean(of.patches.surface == 1))

    assert share(focused) > share(solution)
    with pytest.raises(ValueError, match="desk"):
        radiosity.solve(scene, focus="dask")
    with pytest.raises(ValueError, match="pass a scene"):
        radiosity.solve(scene.patches(count=10), focus="desk")


def test_relit_fields_are_fields(solution: Solution) -> None:
    relit = solution.relight(emission=2 * solution.emission)
    assert relit.report.of_field and relit.report.accuracy == 0.05
    assert np.allclose(relit.irradiance, 2 * solution.irradiance)
    assert relit.report.estimated_error == pytest.approx(solution.report.estimated_error)


def test_same_bytes_on_any_number_of_threads(scene: Scene) -> None:
    one, two = (radiosity.solve(scene, accuracy=0.08, threads=threads, seed=3) for threads in (1, 2))
    assert np.array_equal(one.patches.polygons, two.patches.polygons)
    assert np.array_equal(one.irradiance, two.irradiance) and np.array_equal(one.error, two.error)


def test_files_keep_the_certificate(solution: Solution, tmp_path: Path) -> None:
    path = tmp_path / "lit.npz"
    solution.save(path)
    with np.load(path) as arrays:
        assert list(arrays["error_causes"]) == list(solution.certificate.by_cause)
        assert np.allclose((arrays["error_by_cause"] ** 2).sum(axis=0), arrays["error"] ** 2)
        assert np.array_equal(arrays["corner_irradiance"], solution.corner_irradiance)
        report = json.loads(str(arrays["report"]))
    assert report["causes"]["mesh"] == solution.report.causes["mesh"]
    assert report["interval"][1] == report["estimated_error"]


def test_each_mesh_is_handed_over(scene: Scene) -> None:
    seen: list[Solution] = []
    last = radiosity.solve(scene, accuracy=0.1, on_refine=seen.append)
    assert [len(s.patches) for s in seen] == [step.patches for step in last.refinement]
    assert seen[-1] is last
    assert last.report.reached


def test_who_has_seen_enough_ends_the_refinement(scene: Scene) -> None:
    solution = radiosity.solve(scene, accuracy=0.02, on_refine=lambda s: len(s.patches) < 500)
    assert (solution.report.limited_by, solution.report.reached) == ("observer", False)
    assert "it was told to stop" in str(solution.report)
    assert solution.report.meshes == len(solution.refinement)
    assert solution.refinement[-2].patches < 500 <= solution.refinement[-1].patches == len(solution.patches)


def test_what_on_refine_raises_ends_the_solve(scene: Scene) -> None:
    def fail(_: Solution) -> None:
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        radiosity.solve(scene, accuracy=0.1, on_refine=fail)


def test_no_mesh_is_handed_over_where_it_is_given(scene: Scene) -> None:
    seen: list[Solution] = []
    radiosity.solve(scene.patches(count=50), accuracy=0.2, on_refine=seen.append)
    assert seen == []
