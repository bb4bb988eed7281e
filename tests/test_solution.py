"""Solving and relighting."""

from __future__ import annotations

import json
import time

import numpy as np
import pytest
from known import cube, cube_factors, square

import radiosity
from radiosity import Patches, Scene, SceneError, Solution, Surface, form_factors, scenes, solve


def rms(values: np.ndarray, area: np.ndarray) -> float:
    """Root mean square over area and bands."""
    return float(np.sqrt(np.average(np.mean(values**2, axis=1), weights=area)))


def relative(found: np.ndarray, true: np.ndarray, area: np.ndarray) -> float:
    """Root mean square difference relative to the mean of what is true."""
    return rms(found - true, area) / float(np.average(np.mean(true, axis=1), weights=area))


def test_shapes_and_types(cornell: Solution) -> None:
    shape = (len(cornell.patches), 3)
    for values in (cornell.irradiance, cornell.radiosity, cornell.emission, cornell.error, cornell.reflectance):
        assert values.shape == shape
        assert values.dtype == np.float64
        assert np.all(np.isfinite(values))
        assert np.all(values >= 0)
    assert np.all(np.isnan(cornell.back_irradiance))
    assert cornell.back_irradiance.shape == shape


def test_radiosity_is_emission_and_reflection(cornell: Solution) -> None:
    expected = cornell.emission + cornell.reflectance * cornell.irradiance
    assert cornell.radiosity == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(("reflectance", "emission"), [(0.5, 1.0), ([0.1, 0.5, 0.9], [1.0, 2.0, 3.0])])
def test_the_furnace(reflectance: object, emission: object) -> None:
    solution = solve(scenes.furnace(reflectance, emission).patches(count=400), accuracy=0.01)
    everywhere = np.asarray(emission) / (1 - np.asarray(reflectance))
    true = np.broadcast_to(everywhere, solution.radiosity.shape)
    assert solution.report.reached
    assert relative(solution.irradiance, true, solution.patches.area) < 0.02
    assert relative(solution.radiosity, true, solution.patches.area) < 0.02


def test_black_walls_reflect_nothing() -> None:
    patches = cube(0.0, {"ceiling": 1.0}).patches(as_is=True)
    solution = solve(patches, accuracy=0.005)
    assert solution.radiosity.tolist() == solution.emission.tolist()
    assert solution.irradiance[:, 0] == pytest.approx(cube_factors()[:, 1], abs=0.005)


def test_the_accuracy_is_what_is_asked_for() -> None:
    patches = cube(0.6, {"ceiling": 1.0}).patches(count=600)
    fine = solve(patches, accuracy=0.004, seed=99)
    for accuracy in (0.1, 0.02):
        coarse = solve(patches, accuracy=accuracy)
        assert coarse.report.reached
        assert coarse.report.estimated_error <= accuracy
        # Half as much again for the luck of one seed.
        assert relative(coarse.irradiance, fine.irradiance, patches.area) < 1.5 * accuracy


def test_the_limit_that_was_hit_is_named() -> None:
    report = solve(cube(0.6, {"ceiling": 1.0}).patches(count=600), accuracy=1e-3, max_rays=16).report
    assert not report.reached
    assert report.limited_by == "max_rays"
    assert report.estimated_error > report.accuracy == 1e-3


def test_the_same_seed_gives_the_same_bytes_on_any_number_of_threads() -> None:
    scene = scenes.cornell_box()

    def solved(**options: int) -> bytes:
        s = solve(scene.patches(count=300), accuracy=0.1, **options)
        return s.irradiance.tobytes() + s.radiosity.tobytes() + s.error.tobytes()

    assert solved(threads=1) == solved(threads=2) == solved(threads=1)
    assert solved(seed=1) != solved(seed=2)


@pytest.mark.parametrize("solver", ["conjugate_gradient", "jacobi"])
def test_solvers_agree(cornell: Solution, solver: str) -> None:
    other = solve(cornell.patches, accuracy=0.05, solver=solver)
    assert relative(other.irradiance, cornell.irradiance, cornell.patches.area) < 0.01


def test_a_scene_is_cut_when_the_caller_does_not() -> None:
    solution = solve(scenes.two_plates(), accuracy=0.1)
    assert solution.report.of_field and solution.report.meshes > 0
    evenly = solve(scenes.two_plates(), accuracy=0.1, transport="hierarchical")
    assert len(evenly.patches) == pytest.approx(radiosity.solution.DEFAULT_PATCHES, rel=0.2)
    assert not evenly.report.of_field


class TestTransport:
    """Solving on form factors that were measured before."""

    def test_it_solves_the_equation_of_radiosity(self) -> None:
        patches = cube(0.7, {"ceiling": 1.0, "left": 0.5}).patches(count=300)
        f = form_factors(patches, rays=4096)
        direct = np.linalg.solve(np.eye(len(patches)) - 0.7 * f.toarray(), patches.emission)
        assert relative(solve(patches, transport=f).radiosity, direct, patches.area) < 0.01

    def test_it_must_be_of_the_same_patches(self) -> None:
        f = form_factors(cube().patches(as_is=True), rays=64)
        with pytest.raises(ValueError, match="transport was measured on other patches"):
            solve(cube().patches(as_is=True), transport=f)


class TestRelight:
    """Other lamps and paint on the same geometry."""

    def test_the_same_light_gives_the_same_answer(self, cornell: Solution) -> None:
        again = cornell.relight()
        assert again.irradiance == pytest.approx(cornell.irradiance, rel=1e-3)

    def test_twice_the_light_gives_twice_the_answer(self, cornell: Solution) -> None:
        once, twice = cornell.relight(), cornell.relight(emission=2 * cornell.emission)
        assert twice.irradiance == pytest.approx(2 * once.irradiance, rel=1e-9)

    def test_it_equals_a_fresh_solve_within_the_errors(self) -> None:
        patches = scenes.cornell_box().patches(count=600)
        before = solve(patches, accuracy=0.02)
        red = before.relight(reflectance=0.5 * before.reflectance, emission=3 * before.emission)
        scene = scenes.cornell_box()
        for surface in scene.surfaces:
            surface.reflectance = 0.5 * np.asarray(surface.reflectance)
            surface.emission = 3 * np.asarray(surface.emission)
        fresh = solve(scene.patches(count=600), accuracy=0.02, seed=7)
        # Two independent errors of 2 %, half as much again for luck.
        assert relative(red.irradiance, fresh.irradiance, patches.area) < 1.5 * np.hypot(0.02, 0.02)
        error, off = np.hypot(red.error, fresh.error), np.abs(red.irradiance - fresh.irradiance)
        assert np.all(off[error == 0] == 0)
        assert np.sqrt(np.mean((off[error > 0] / error[error > 0]) ** 2)) < 2

    def test_whole_surfaces_can_be_set(self, cornell: Solution) -> None:
        surfaces = len(cornell.patches.scene.surfaces)
        reflectance = np.linspace(0.1, 0.8, surfaces)[:, None] * np.ones(3)
        painted = cornell.relight(reflectance=reflectance)
        assert np.array_equal(painted.reflectance, reflectance[cornell.patches.surface])

    def test_nonsense_is_refused(self, cornell: Solution) -> None:
        with pytest.raises(ValueError, match=r"emission of shape \(7, 2\) does not fit"):
            cornell.relight(emission=np.ones((7, 2)))
        with pytest.raises(ValueError, match="reflectance 1 is outside"):
            cornell.relight(reflectance=1.0)
        with pytest.raises(ValueError, match="emission -1 is not a nonnegative number"):
            cornell.relight(emission=-1.0)


def furnace_with_a_sheet() -> Patches:
    """The furnace of rho = 1/2, E = 1 with a two-sided sheet across its middle."""
    scene = cube()
    sheet = np.add(square(0.8, z=0.5), [0.5, 0.5, 0])
    scene.surfaces.append(Surface(sheet, [[0, 1, 2, 3]], 0.5, 1.0, "sheet", two_sided=True))
    return scene.patches(max_edge=0.25)


def test_both_sides_of_a_sheet_take_part() -> None:
    solution = solve(furnace_with_a_sheet(), accuracy=0.01)
    sheet = solution.patches.surface == 6
    assert np.all(np.isnan(solution.back_irradiance[~sheet]))
    for values in (solution.irradiance[sheet], solution.back_irradiance[sheet], solution.back_radiosity[sheet]):
        assert values == pytest.approx(np.full(values.shape, 2.0), rel=0.1)
    assert np.all(solution.back_error[sheet] >= 0)


class TestReport:
    """What a solve says about itself."""

    def test_energy_is_conserved(self, cornell: Solution) -> None:
        r = cornell.report
        power = cornell.patches.area @ cornell.emission
        assert r.emitted == pytest.approx(power)
        out = np.add(r.absorbed, r.escaped) + r.lost_on_backs
        assert out == pytest.approx(r.emitted, rel=abs(r.imbalance) + 1e-9)
        assert abs(r.imbalance) < 0.05

    def test_absorbed_power_follows_from_irradiance(self, cornell: Solution) -> None:
        absorbed = cornell.patches.area @ ((1 - cornell.reflectance) * cornell.irradiance)
        assert cornell.report.absorbed == pytest.approx(absorbed, rel=1e-6)

    def test_the_error_is_the_mean_of_errors(self, cornell: Solution) -> None:
        area, h = cornell.patches.area, cornell.irradiance
        mean = float(np.average(h.mean(axis=1), weights=area))
        low, high = cornell.report.interval
        assert low < rms(cornell.error, area) / mean < high == cornell.report.estimated_error

    def test_it_prints_as_a_table_and_as_json(self, cornell: Solution) -> None:
        lines = str(cornell.report).splitlines()
        assert lines[0].startswith("estimated error ")
        assert len({line.index(text) for line, (_, text) in zip(lines, cornell.report.rows(), strict=True)}) == 1
        content = json.loads(json.dumps(cornell.report.to_dict()))
        assert content["patches"] == len(cornell.patches)
        assert content["reached"] is cornell.report.reached is True
        assert content["bands"] == ["R", "G", "B"]


class TestRefusals:
    """Arguments out of range."""

    @pytest.mark.parametrize(
        ("options", "message"),
        [
            ({"accuracy": 0}, "accuracy must be a positive number such as 0.01, not 0"),
            ({"accuracy": float("nan")}, "accuracy must be a positive number"),
            ({"solver": "magic"}, "there is no solver 'magic'; choose one of conjugate_gradient"),
            ({"closure": "loose"}, "there is no closure 'loose'"),
            ({"seed": -1}, "seed must be from 0 to"),
            ({"threads": 0}, "threads must be from 1 to"),
            ({"max_rays": 0}, "max_rays must be from 1 to"),
        ],
    )
    def test_options(self, options: dict[str, object], message: str) -> None:
        with pytest.raises(ValueError, match=message):
            solve(cube().patches(as_is=True), **options)

    def test_memory(self) -> None:
        with pytest.raises(radiosity.ResourceError, match="raise the limit or use fewer patches"):
            solve(cube().patches(count=500), memory_limit=1000)

    def test_darkness(self) -> None:
        with pytest.raises(SceneError, match="cube: nothing in the scene emits"):
            solve(cube(emission=0.0))


class TestProgress:
    """Callbacks during long work."""

    def test_it_counts_up_and_an_exception_from_it_ends_the_work(self) -> None:
        calls: list[tuple[int, int]] = []

        def enough(done: int, total: int) -> None:
            calls.append((done, total))
            if len(calls) == 4:
                raise RuntimeError("enough")

        start = time.monotonic()
        with pytest.raises(RuntimeError, match="enough"):
            solve(scenes.cornell_box().patches(count=5000), accuracy=1e-5, progress=enough)
        assert time.monotonic() - start < 10
        done = [d for d, _ in calls]
        assert done == sorted(done)
        assert all(d <= total for d, total in calls)


def test_nothing_is_kept_between_solves() -> None:
    def solved() -> bytes:
        return solve(cube(0.5, {"floor": 1.0}).patches(count=100), accuracy=0.1).irradiance.tobytes()

    before = solved()
    solve(Scene([Surface(square(), [[0, 1, 2, 3]], 0.3, 9.0)]), accuracy=0.5, seed=5)
    assert solved() == before
