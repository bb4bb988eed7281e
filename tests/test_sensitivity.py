"""Derivatives of irradiance by everything that shines and reflects."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from known import CUBE, INWARD, cube, cube_factors

import radiosity
from radiosity import Patches, Scene, Solution, Surface, form_factors, scenes, solve
from radiosity.sensitivity import named, names

TWO_BANDS = {
    "floor": [0.2, 0.3], "ceiling": [0.8, 0.7], "left": [0.6, 0.1], "right": [0.5, 0.5], "back": [0.4, 0.6],
}  # fmt: skip


def rectangle(low: list[float], high: list[float], axis: int, *, flip: bool = False) -> list[list[float]]:
    """Corners of a rectangle across an axis."""
    u, v = [k for k in range(3) if k != axis]
    corners = []
    for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
        corner = list(low)
        corner[u], corner[v] = (low, high)[a][u], (low, high)[b][v]
        corners.append(corner)
    return corners[::-1] if flip else corners


def room() -> Patches:
    """Two bands, two-sided things of which one shines, a lamp, three kinds of lights, a crate, an open front."""
    box = [s for s in cube().surfaces if s.name != "front"]
    size = np.array([3.0, 2.0, 2.5])
    surfaces = [Surface(np.asarray(s.vertices) * size, s.faces, TWO_BANDS[s.name], name=s.name) for s in box]
    table = rectangle([0.8, 0.6, 0.75], [2.0, 1.4, 0.75], 2)
    screen = rectangle([2.2, 0.3, 1.0], [2.2, 1.2, 2.0], 0)
    lamp = rectangle([0.6, 0.8, 2.4], [1.8, 1.2, 2.4], 2, flip=True)
    # What stands under it is no part of the floor: patches are buried by half.
    crate = CUBE * [0.5, 0.5, 0.4] + [0.3, 1.2, 0.0]
    sides = [face[::-1] for name, face in INWARD.items() if name != "floor"]
    surfaces += [
        Surface(table, [[0, 1, 2, 3]], [0.5, 0.7], name="table", two_sided=True),
        Surface(screen, [[0, 1, 2, 3]], [0.3, 0.3], [2.0, 5.0], name="screen", two_sided=True),
        Surface(crate, sides, [0.5, 0.4], name="crate"),
        Surface(lamp, [[0, 1, 2, 3]], [0.1, 0.2], [200.0, 100.0], name="lamp"),
    ]
    lights = [
        radiosity.PointLight([0.4, 0.5, 1.8], [10.0, 20.0], name="bulb"),
        radiosity.SpotLight([2.0, 1.0, 2.2], [-0.3, 0, -1], [30.0, 10.0], 0.2, 0.9, name="spot"),
        radiosity.DirectionalLight([0.1, 1.0, -0.4], [3.0, 4.0], name="sun"),
    ]
    return Scene(surfaces, lights=lights).patches(max_edge=0.5)


def solved(way: str) -> Solution:
    """Solved so that what solvers leave is far below 1e-4 of what a step changes."""
    patches = room()
    if way == "given":
        return solve(patches, transport=form_factors(patches, tolerance=1e-3))
    if way == "rays":
        return solve(patches, transport=form_factors(patches, method="monte_carlo", rays=256))
    if way == "sampled":
        return solve(patches, accuracy=0.02, transport="sampled", closure="exact")
    # The tolerance of the solver follows the accuracy: blocks for the one, relit to the other.
    solution = solve(patches, accuracy=0.02, transport="hierarchical")
    solution._options["accuracy"] = 1e-7
    return solution.relight()


@pytest.fixture(scope="module", params=["given", "rays", "sampled", "hierarchical"])
def solution(request: pytest.FixtureRequest) -> Solution:
    return solved(request.param)


def differences(solution: Solution, weights: np.ndarray, what: str, step: np.ndarray) -> np.ndarray:
    """(n_bands,) how much a weighted sum changes with a step, by central differences."""
    now = getattr(solution, what)
    up, down = (solution.relight(**{what: now + sign * step}).irradiance for sign in (1, -1))
    return np.asarray((weights * (up - down)).sum(axis=0) / 2)


def steps(solution: Solution, what: str) -> list[tuple[str, np.ndarray]]:
    """A step of each surface or light, small against what curves and large against what solvers leave."""
    if what == "lights":
        lit = np.eye(len(solution.lights))[:, :, None] * solution.lights
        return [(light.name, 0.1 * step) for light, step in zip(solution.patches.scene.lights, lit, strict=True)]
    now = getattr(solution, what)
    size = 0.1 * now if what == "emission" else np.full_like(now, 2e-3)
    found = [(name, np.where(named(solution.patches, name)[:, None], size, 0.0)) for name in names(solution.patches)]
    return [(name, step) for name, step in found if np.any(step)]


@pytest.mark.parametrize("what", ["emission", "reflectance", "lights"])
@pytest.mark.parametrize("target", ["table", "weights"])
def test_derivatives_are_what_differences_are(solution: Solution, what: str, target: str) -> None:
    shape = solution.irradiance.shape
    weighed: Any = target if target == "table" else np.random.default_rng(7).normal(size=shape)
    found = solution.sensitivity(weighed)
    assert found.value == pytest.approx((found.weights * solution.irradiance).sum(axis=0), rel=1e-12)
    for name, step in steps(solution, what):
        expected = differences(solution, found.weights, what, step)
        # Sums of either sign may cancel: each is compared by what it consists of.
        terms = getattr(found, what) * step
        size = np.abs(terms).sum(axis=0)
        assert np.all(np.abs(terms.sum(axis=0) - expected) < 1e-4 * size), name


@pytest.mark.parametrize("name", ["lamp", "screen"])
def test_one_patch_of_a_lamp(solution: Solution, name: str) -> None:
    # Lamps that were tested as one shine no more alike: their tests are the same.
    patch = np.flatnonzero(named(solution.patches, name))[1]
    step = np.zeros_like(solution.emission)
    step[patch] = 0.1 * solution.emission[patch]
    found = solution.sensitivity("table")
    expected = differences(solution, found.weights, "emission", step)
    assert (found.emission * step).sum(axis=0) == pytest.approx(expected, rel=1e-4)


def test_dark_surfaces_have_derivatives_too(solution: Solution) -> None:
    found = solution.sensitivity("floor")
    for name in ("table", "floor", "left"):
        # One step up only, as none shines less than not at all; irradiance is linear in emission.
        step = np.where(named(solution.patches, name)[:, None], 0.01, 0.0)
        up, now = (solution.relight(emission=e).irradiance for e in (solution.emission + step, solution.emission))
        expected = (found.weights * (up - now)).sum(axis=0)
        assert (found.emission * step).sum(axis=0) == pytest.approx(expected, rel=1e-4)


def test_a_looser_solve_has_derivatives_to_its_tolerance() -> None:
    solution = solve(room(), accuracy=0.02)
    exact = solve(room(), accuracy=0.02, closure="exact")
    for what in ("emission", "reflectance"):
        loose, tight = (getattr(s.sensitivity("table"), what) for s in (solution, exact))
        assert loose == pytest.approx(tight, rel=0.01, abs=1e-3 * np.abs(tight).max())


def test_the_furnace_in_closed_form() -> None:
    # H = E / (1 - rho) on all of a closed room: dH/dE = 1 / (1 - rho), dH/drho = E / (1 - rho)^2.
    patches = cube([0.2, 0.7], [3.0, 5.0]).patches(as_is=True)
    exact = solve(patches, transport=form_factors(patches, tolerance=1e-9))
    found = exact.sensitivity(patches.area / patches.area.sum())
    assert found.value == pytest.approx([3.0 / 0.8, 5.0 / 0.3], rel=1e-6)
    assert found.emission.sum(axis=0) == pytest.approx([1 / 0.8, 1 / 0.3], rel=1e-6)
    assert found.reflectance.sum(axis=0) == pytest.approx([3 / 0.8**2, 5 / 0.3**2], rel=1e-6)


def test_the_furnace_by_samples() -> None:
    # Row sums of 1 make the furnace exact, so that this knows no noise but the balancing's.
    patches = scenes.furnace([0.2, 0.7], [3.0, 5.0]).patches(count=300)
    found = solve(patches, accuracy=0.01, closure="exact").sensitivity(patches.area / patches.area.sum())
    assert found.emission.sum(axis=0) == pytest.approx([1 / 0.8, 1 / 0.3], rel=1e-6)
    assert found.reflectance.sum(axis=0) == pytest.approx([3 / 0.8**2, 5 / 0.3**2], rel=1e-6)


def test_the_cube_against_its_inverse() -> None:
    # T = w . F (1 - rho F)^-1 E with exact factors: dT/dE is a row of a 6 x 6 inverse.
    scene = cube(0.0, 1.0)
    rho = np.array([0.1, 0.3, 0.5, 0.7, 0.2, 0.6])
    for surface, r in zip(scene.surfaces, rho, strict=True):
        surface.reflectance = float(r)
    patches = scene.patches(as_is=True)
    F = cube_factors()
    found = solve(patches, transport=form_factors(patches, tolerance=1e-9)).sensitivity("back")
    through = F @ np.linalg.inv(np.eye(6) - rho[:, None] * F)
    assert found.emission[:, 0] == pytest.approx(through[3], rel=1e-6)
    assert found.reflectance[:, 0] == pytest.approx(through[3] * (through @ np.ones(6)), rel=1e-6)


def test_reciprocity(solution: Solution) -> None:
    # A_a dH_a/dE_b = A_b dH_b/dE_a: of fronts alone, so of one-sided surfaces.
    if solution.report.transport == "sampled":
        pytest.skip("a gather through samples of one end alone is not symmetric")
    pairs = [("left", "ceiling"), ("left", "crate")]
    area = {name: solution.patches.area[named(solution.patches, name)].sum() for name in names(solution.patches)}
    for a, b in pairs:
        there, back = (solution.sensitivity(x).by_surface()[y].emission for x, y in ((a, b), (b, a)))
        assert area[a] * there == pytest.approx(area[b] * back, rel=1e-8)


def test_importance_does_not_depend_on_the_size_of_patches() -> None:
    coarse, fine = (cube(0.5).patches(max_edge=edge) for edge in (0.5, 0.25))
    found = [solve(p, transport=form_factors(p, tolerance=1e-6)).sensitivity("floor") for p in (coarse, fine)]
    means = [np.average(f.importance[named(f.patches, "left")], axis=0) for f in found]
    # The mean over the coarse patches is that over the fine ones, to the error of the coarse mesh.
    assert means[0] == pytest.approx(means[1], rel=0.01)
    assert found[0].importance * coarse.area[:, None] == pytest.approx(found[0].emission)


def test_bytes_do_not_depend_on_threads() -> None:
    def found(threads: int) -> bytes:
        s = solve(room(), accuracy=0.02, threads=threads, transport="sampled").sensitivity("table")
        return s.emission.tobytes() + s.reflectance.tobytes() + s.lights.tobytes()

    assert found(1) == found(2) == found(5)


def test_surfaces_and_lights_by_name(solution: Solution) -> None:
    found = solution.sensitivity("table")
    by_surface = found.by_surface()
    assert list(by_surface) == names(solution.patches)
    assert sum(s.emission for s in by_surface.values()) == pytest.approx(found.emission.sum(axis=0))
    assert list(found.by_light()) == ["bulb", "spot", "sun"]
    text = str(found)
    assert all(name in text for name in ("table", "screen", "spot", "W/m2"))


def test_a_light_can_be_dimmed(solution: Solution) -> None:
    off = solution.relight(lights=0.0)
    assert off.lights.tolist() == [[0.0, 0.0]] * 3
    assert sum(off.report.from_lights) == pytest.approx(0.0, abs=1e-9)
    # What is relit again stays dimmed unless told otherwise; light adds up.
    dark = solution.relight(emission=0.0)
    both = off.irradiance + dark.irradiance
    assert both == pytest.approx(solution.irradiance, rel=1e-3, abs=1e-3 * solution.irradiance.mean())
    assert off.relight(emission=0.0).irradiance.max() == pytest.approx(0.0, abs=1e-9)
    with pytest.raises(ValueError, match=r"lights of shape \(5,\) do not fit"):
        solution.relight(lights=[1, 2, 3, 4, 5])


def test_solutions_without_an_exchange_say_so() -> None:
    patches = cube(0.5).patches(max_edge=0.5)
    with pytest.raises(ValueError, match=r"shooting keeps no exchange .* transport='sampled'"):
        solve(patches, solver="shooting", accuracy=0.1).sensitivity("floor")
    with pytest.raises(ValueError, match=r"southwell drew rows .* transport='sampled'"):
        solve(patches, solver="southwell", accuracy=0.1).sensitivity("floor")


@pytest.mark.parametrize(
    ("target", "message"),
    [
        ("flor", "no surface 'flor'; there is 'floor'"),
        (np.ones(7), r"weights of shape \(24,\) or \(24, 1\), not \(7,\)"),
        (np.full(24, np.nan), "weight of patch 0 is not finite"),
    ],
)
def test_targets_that_are_none(target: Any, message: str) -> None:
    patches = cube(0.5).patches(max_edge=0.5)
    exact = solve(patches, transport=form_factors(patches))
    with pytest.raises(ValueError, match=message):
        exact.sensitivity(target)
