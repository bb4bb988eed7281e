"""Solvers of given form factors and on demand, and who looks on."""

from __future__ import annotations

import os
import signal
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from known import Runner, cube, cube_factors

import radiosity
from radiosity import FormFactors, PointLight, Snapshot, form_factors, scenes, solve
from radiosity.factors import form_factors as measured
from radiosity.solution import PROGRESSIVE, SOLVERS


@pytest.fixture(scope="module")
def room() -> FormFactors:
    """A closed cube with a lamp, about 600 patches whose rows sum to 1."""
    return measured(cube(0.9, {"ceiling": 1.0}).patches(count=600), method="analytic")


def direct(f: FormFactors, reflectance: np.ndarray, emission: np.ndarray) -> np.ndarray:
    """Radiosity by elimination, band by band."""
    m = f.toarray()
    bands = [np.linalg.solve(np.eye(len(m)) - rho[:, None] * m, e) for rho, e in zip(reflectance.T, emission.T)]  # noqa: B905
    return np.stack(bands, axis=1)


@pytest.mark.parametrize("solver", SOLVERS)
def test_it_agrees_with_elimination(solver: radiosity.solution.Solver, room: FormFactors) -> None:
    solution = solve(room.patches, transport=room, solver=solver)
    expected = direct(room, solution.reflectance, solution.emission)
    # The residual is 1e-9 (1 - rho) of what is emitted, and the error at most that over 1 - rho.
    assert solution.radiosity == pytest.approx(expected, rel=1e-7)
    assert (solution.report.solver, solution.report.stop, solution.report.converged) == (solver, "converged", True)
    assert solution.report.residual <= 1e-10
    assert solution.report.residual_history[-1] == solution.report.residual
    assert len(solution.report.history_iterations) == len(solution.report.residual_history) <= 1024


def test_conjugate_gradient_takes_a_fifth_of_the_products_of_jacobi(room: FormFactors) -> None:
    """At a reflectance of 0.9 Jacobi gains log10(1 / 0.9) = 0.046 digits a product: 220 for ten digits."""
    products = {
        solver: solve(room.patches, transport=room, solver=solver).report.products
        for solver in ("jacobi", "conjugate_gradient", "gauss_seidel", "over_relaxation")
    }
    assert products["jacobi"] == pytest.approx(10 / np.log10(1 / 0.9), rel=0.15)
    assert 5 * products["conjugate_gradient"] < products["jacobi"]
    # Young 1954: Gauss-Seidel gains twice as many digits a sweep.
    assert products["gauss_seidel"] == pytest.approx(0.5 * products["jacobi"], rel=0.2)
    assert products["over_relaxation"] < 0.5 * products["gauss_seidel"]


def test_two_sided_patches_and_lights_without_area_shoot_too() -> None:
    scene = scenes.furnished_room(0)
    patches = radiosity.Scene(scene.surfaces[:8], lights=[PointLight([2.0, 1.5, 2.0], 10.0)]).patches(max_edge=1.0)
    f = form_factors(patches, tolerance=1e-3)
    answers = [solve(patches, transport=f, solver=solver, accuracy=0.1) for solver in SOLVERS]
    for answer in answers[1:]:
        assert answer.irradiance == pytest.approx(answers[0].irradiance, rel=1e-6, abs=1e-9)


class TestNotConverging:
    """A solve that was cut short says so everywhere."""

    def test_the_report_says_so(self, room: FormFactors) -> None:
        for solver in SOLVERS:
            solution = solve(room.patches, transport=room, solver=solver, max_iterations=3)
            report = solution.report
            assert (report.converged, report.reached, report.limited_by) == (False, False, "solver")
            assert (report.stop, report.iterations) == ("max_iterations", 3)
            assert "NOT converged: the iterations are spent" in str(report)
            assert "the solver did not converge" in str(report)
            # What is missing is in the estimated error: no patch has less than the truth by more.
            full = solve(room.patches, transport=room)
            assert np.all(full.irradiance - solution.irradiance <= solution.error * (1 + 1e-6))

    def test_the_command_says_so(self, run: Runner) -> None:
        done = run("solve", "builtin:furnace", "--patches", 100, "--solver", "southwell", "--max-iterations", 2)
        assert done.returncode == 4
        assert "NOT converged" in done.stdout
        assert "did not converge; raise --max-iterations" in done.stderr


class TestShooting:
    """Progressive refinement."""

    def test_the_first_shot_places_all_that_the_lamp_emits(self) -> None:
        patches = cube(0.5, {"ceiling": 2.0}).patches(as_is=True)
        f = form_factors(patches, method="analytic")
        solution = solve(patches, transport=f, solver="southwell", max_iterations=1)
        # One face of 1 m2 emits 2 W/m2, and each face reflects half of what comes to it.
        assert solution.irradiance[:, 0] == pytest.approx(2 * f.row(1) + 0.5 * f @ (f.row(1) * 2), rel=1e-6)
        assert solution.report.unshot_history == pytest.approx([1.0, 0.5], rel=1e-12)
        assert solution.report.products == pytest.approx(1 / 6)

    def test_most_power_is_placed_within_a_handful_of_shots(self, room: FormFactors) -> None:
        """k shots of a lamp of k patches leave rho of what it emits, in a closed room exactly."""
        lamps = int(np.count_nonzero(room.patches.emission[:, 0]))
        report = solve(room.patches, transport=room, solver="southwell", max_iterations=lamps).report
        assert report.unshot_history[0] == 1.0
        assert report.unshot_history[-1] == pytest.approx(0.9, rel=1e-6)

    @pytest.mark.parametrize("solver", PROGRESSIVE)
    def test_it_needs_no_matrix(self, solver: radiosity.solution.Solver) -> None:
        patches = cube(0.5, {"ceiling": 1.0}).patches(as_is=True)
        solution = solve(patches, solver=solver, accuracy=0.01)
        expected = np.linalg.solve(np.eye(6) - 0.5 * cube_factors(), patches.emission)
        assert solution.report.reached
        assert solution.radiosity == pytest.approx(expected, rel=0.02)
        assert solution.report.rows_on_demand == 6
        assert solution.report.rays == 0
        assert abs(solution.report.imbalance) < 0.005

    def test_only_patches_that_shoot_are_looked_at(self) -> None:
        patches = scenes.cornell_box().patches(count=800)
        lamps = int(np.count_nonzero(patches.emission.any(axis=1)))
        report = solve(patches, solver="southwell", accuracy=0.1, max_iterations=lamps).report
        assert report.rows_on_demand == lamps
        assert report.hemicubes == 8 * lamps
        # The next is found together with fifteen more.
        report = solve(patches, solver="southwell", accuracy=0.1, max_iterations=lamps + 1).report
        assert report.rows_on_demand == lamps + 16
        assert not report.converged

    def test_the_error_is_honest(self, cornell: radiosity.Solution) -> None:
        patches = cornell.patches
        truth = solve(patches, transport=form_factors(patches, tolerance=1e-4))
        solution = solve(patches, solver="southwell", accuracy=0.05)
        off = solution.irradiance - truth.irradiance
        weights = np.broadcast_to(patches.area[:, None], off.shape)
        rms = np.sqrt(np.average(off**2, weights=weights)) / np.average(truth.irradiance, weights=weights)
        assert solution.report.reached
        assert rms < 0.05
        # Four sets of hemicubes tell the error to some tens of percent; what is unshot adds to it.
        assert 0.2 < rms / solution.report.estimated_error < 1.25

    def test_the_same_bytes_on_any_number_of_threads(self) -> None:
        patches = scenes.cornell_box().patches(count=200)

        def solved(**options: int) -> bytes:
            s = solve(patches, solver="southwell", accuracy=0.1, **options)
            return s.irradiance.tobytes() + s.error.tobytes()

        assert solved(threads=1) == solved(threads=2)
        # Rows that do not fit are found again.
        assert solved(memory_limit=100_000) == solved()
        assert solved(seed=1) != solved(seed=2)

    def test_another_light_on_the_same_rows(self) -> None:
        patches = cube(0.5, {"ceiling": 1.0}).patches(as_is=True)
        solution = solve(patches, solver="southwell", accuracy=0.05)
        brighter = solution.relight(emission=2 * solution.emission)
        assert brighter.irradiance == pytest.approx(2 * solution.irradiance, rel=1e-9)
        assert brighter.report.rows_on_demand == 0

    def test_a_memory_limit_too_small_for_any_row(self) -> None:
        with pytest.raises(radiosity.ResourceError, match="raise the limit"):
            solve(scenes.cornell_box().patches(count=500), solver="southwell", memory_limit=1000)


class TestOnIterate:
    """Callbacks with solutions on their way."""

    @pytest.mark.parametrize("solver", SOLVERS)
    def test_it_sees_every_iteration(self, solver: radiosity.solution.Solver) -> None:
        patches = cube(0.5, {"ceiling": 1.0}).patches(as_is=True)
        f = form_factors(patches, method="analytic")
        seen: list[Snapshot] = []
        solution = solve(patches, transport=f, solver=solver, on_iterate=seen.append)
        assert [s.iteration for s in seen] == list(range(solution.report.iterations + 1))
        assert [s.residual for s in seen] == solution.report.residual_history
        assert seen[-1].radiosity == pytest.approx(solution.radiosity, rel=1e-12)
        if solver in PROGRESSIVE:
            assert [s.unshot for s in seen] == solution.report.unshot_history

    def test_the_ambient_term_completes_a_closed_room(self, room: FormFactors) -> None:
        """With one reflectance everywhere the mean is E / (1 - rho) from the start, whoever shot."""
        means = []

        def look(s: Snapshot) -> None:
            means.append(np.average(s.with_ambient()[:, 0], weights=s.patches.area))

        solve(room.patches, transport=room, solver="southwell", max_iterations=200, on_iterate=look)
        assert means == pytest.approx([1 / 6 / (1 - 0.9)] * 201, rel=1e-5)

    def test_false_ends_the_solve_and_nothing_else_does(self, room: FormFactors) -> None:
        solution = solve(room.patches, transport=room, solver="jacobi", on_iterate=lambda s: s.iteration < 5)
        assert (solution.report.stop, solution.report.iterations) == ("observer", 5)
        assert "it was told to stop" in str(solution.report)
        solution = solve(room.patches, transport=room, on_iterate=lambda s: None)
        assert solution.report.converged

    @pytest.mark.parametrize("on_demand", [False, True])
    def test_an_exception_from_it_is_raised(self, on_demand: bool) -> None:
        patches = cube(0.5, {"ceiling": 1.0}).patches(as_is=True)
        transport = None if on_demand else form_factors(patches, method="analytic")

        def fail(s: Snapshot) -> None:
            if s.iteration == 2:
                raise LookupError("enough")

        with pytest.raises(LookupError, match="enough"):
            solve(patches, transport=transport, solver="southwell", on_iterate=fail)

    def test_ctrl_c_ends_it(self) -> None:
        patches = cube(0.5, {"ceiling": 1.0}).patches(count=500)
        timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
        start = time.monotonic()
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            solve(patches, solver="southwell", on_iterate=lambda s: time.sleep(0.02), accuracy=0.001)
        timer.join()
        assert time.monotonic() - start < 10

    def test_it_may_solve_within_itself(self) -> None:
        patches = cube(0.5, {"ceiling": 1.0}).patches(as_is=True)
        f = form_factors(patches, method="analytic")
        inner = []
        solve(patches, transport=f, threads=1, max_iterations=2,
              on_iterate=lambda s: inner.append(solve(patches, transport=f, threads=1)))  # fmt: skip
        assert len(inner) == 3

    def test_a_solve_that_samples_has_no_iterations_to_show(self) -> None:
        with pytest.raises(ValueError, match="pass transport, or a solver that shoots"):
            solve(cube().patches(as_is=True), on_iterate=print)


def test_the_command_shoots(run: Runner, tmp_path: Path) -> None:
    arguments = ("--patches", 200, "--accuracy", 0.1, "--solver", "southwell", "-o", "lit.glb")
    done = run("solve", "builtin:cornell-box", *arguments)
    assert done.returncode == 0, done.stderr
    assert "rows on demand" in done.stdout
    assert (tmp_path / "lit.glb").exists()
