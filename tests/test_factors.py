"""Form factors: one suite for all methods, then what each is for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse
from known import OPPOSITE, cube, cube_factors, one_surface, square, tiles
from scipy.sparse.linalg import LinearOperator

from radiosity import FormFactors, Patches, ResourceError, Scene, Surface, form_factors, scenes, solve
from radiosity.factors import METHODS, Method

RAYS = 1 << 14

# What each method is asked, and how far its factors may be from the truth on the faces of a cube. Independent rays
# have a standard error of sqrt(0.2 * 0.8 / RAYS) = 0.003. From its centre alone a face does not see what it sees on
# the whole: a differential area in the middle of a unit square has F = 0.2395 to the opposite one (Howell, B-3), and
# 64 places leave an eighth of that difference if they were random. Constants of known.py have eight digits.
ASKED: dict[Method, tuple[dict[str, Any], float]] = {
    "auto": ({}, 1e-8),
    "analytic": ({}, 1e-8),
    "contour": ({}, 1e-8),
    "nusselt": ({"points": 4}, 1e-5),
    "hemicube": ({"hemicubes": 64, "resolution": 256}, 5e-3),
    "monte_carlo": ({"rays": RAYS}, 0.01),
    "hierarchical": ({"tolerance": 1e-3}, 5e-3),
}

EXACT: tuple[Method, ...] = ("auto", "analytic", "contour")


def measured(patches: Patches, method: Method, **options: Any) -> FormFactors:
    return form_factors(patches, method=method, **(ASKED[method][0] | options))


def plate(scale: float = 1.0) -> Patches:
    """Unit squares face to face at distance 1, with a square of half the size midway that only blocks."""

    def surface(size: float, z: float, corners: list[int], name: str) -> Surface:
        return Surface(scale * np.array(square(size, z)), [corners], name=name)

    lower, upper = surface(1, 0, [0, 1, 2, 3], "lower"), surface(1, 1, [3, 2, 1, 0], "upper")
    return Scene([lower, upper], obstructions=[surface(0.5, 0.5, [0, 1, 2, 3], "plate")]).patches(as_is=True)


PLATE = 0.09950629459898
"""The smooth four-dimensional integral by Gauss and Legendre's rule."""


@pytest.fixture(scope="module", params=METHODS)
def many(request: pytest.FixtureRequest) -> FormFactors:
    options = {"monte_carlo": {"rays": 1024}, "hemicube": {"hemicubes": 4}, "auto": {"tolerance": 1e-3},
               "analytic": {"tolerance": 1e-2}, "contour": {"tolerance": 1e-2}}  # fmt: skip
    return measured(scenes.cornell_box().patches(count=150), request.param, **options.get(request.param, {}))


@pytest.mark.parametrize("method", METHODS)
def test_the_faces_of_a_cube(method: Method) -> None:
    F = measured(cube().patches(as_is=True), method)
    np.testing.assert_allclose(F.toarray(), cube_factors(), rtol=0, atol=ASKED[method][1])


@pytest.mark.parametrize("method", METHODS)
def test_what_stands_between(method: Method) -> None:
    F = measured(plate(), method, **({"tolerance": 1e-7} if method in EXACT else {}))
    tolerance = (
        1e-7
        if method in EXACT
        else {"nusselt": 0.02, "hemicube": 0.01, "monte_carlo": 0.005, "hierarchical": 0.005}[method]
    )
    assert F.toarray()[0, 1] == pytest.approx(PLATE, abs=tolerance)


@pytest.mark.parametrize("method", METHODS)
def test_both_sides_of_a_plate(method: Method) -> None:
    # A two-sided square midway between two others sees each of them from one side only.
    surfaces = [Surface(square(), [[0, 1, 2, 3]]), Surface(square(z=2), [[3, 2, 1, 0]]),
                Surface(square(z=1), [[0, 1, 2, 3]], two_sided=True)]  # fmt: skip
    F = measured(Scene(surfaces).patches(as_is=True), method)
    assert F.shape == (4, 4)
    assert F.patch.tolist() == [0, 1, 2, 2]
    exact = np.zeros((4, 4))
    exact[[1, 2], [2, 1]] = exact[[0, 3], [3, 0]] = OPPOSITE  # its front, row 2, looks up; its back, row 3, down
    np.testing.assert_allclose(F.toarray(), exact, rtol=0, atol=ASKED[method][1])


@pytest.mark.parametrize("method", METHODS)
def test_what_is_behind_does_not_count(method: Method) -> None:
    # A wall through the floor: of its four metres above and below, the one above is seen.
    def wall(low: float) -> Surface:
        return Surface([[0, 0, low], [0, 1, low], [0, 1, 1], [0, 0, 1]], [[0, 1, 2, 3]], name="wall")

    floor = Surface([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]], name="floor")
    F = measured(Scene([floor, wall(-3)]).patches(as_is=True), method)
    above = cube_factors()[0, 2]
    assert F.toarray()[0, 1] == pytest.approx(above, abs=4 * ASKED[method][1])
    assert F.toarray()[1, 0] == pytest.approx(above / 4, abs=ASKED[method][1])


def test_it_is_a_reciprocal_operator(many: FormFactors) -> None:
    assert isinstance(many, LinearOperator)
    n = len(many.patches)
    dense, rng = many.toarray(), np.random.default_rng(1)
    x, block = rng.random(n), rng.random((n, 3))
    assert many.shape == dense.shape == (n, n)
    np.testing.assert_allclose(many @ x, dense @ x)
    np.testing.assert_allclose(many @ block, dense @ block)
    np.testing.assert_allclose(many.T @ x, dense.T @ x)
    np.testing.assert_allclose([many.row(i) for i in range(n)], dense, rtol=1e-12)
    np.testing.assert_allclose(many.row(-1), dense[-1], rtol=1e-12)
    np.testing.assert_allclose(many.to_scipy_sparse().toarray(), dense, rtol=1e-15)
    np.testing.assert_allclose(many.closure(), dense.sum(axis=1))
    exchange = many.area[:, None] * dense
    np.testing.assert_allclose(exchange, exchange.T, rtol=1e-12)
    assert many.reciprocity_error() < 1e-15
    assert np.all(dense >= 0)
    assert np.count_nonzero(dense) > n * 30
    # The Cornell box lacks its front wall.
    assert np.average(many.closure(), weights=many.area) < 0.95


def test_it_survives_a_file(many: FormFactors, tmp_path: Path) -> None:
    many.save(tmp_path / "F.npz")
    again = FormFactors.load(tmp_path / "F.npz")
    np.testing.assert_allclose(again.toarray(), many.toarray(), rtol=1e-14)
    np.testing.assert_array_equal(again.patches.polygons, many.patches.polygons)
    assert again.report.method == many.report.method
    assert FormFactors.load(tmp_path / "F.npz", many.patches).patches is many.patches
    with pytest.raises(ValueError, match=r"F.npz: these form factors are between other patches"):
        FormFactors.load(tmp_path / "F.npz", cube().patches(as_is=True))
    assert scipy.sparse.load_npz(tmp_path / "F.npz").shape == many.shape


def test_obstructions_and_sides_survive_a_file(tmp_path: Path) -> None:
    F = form_factors(plate())
    F.save(tmp_path / "F.npz")
    again = FormFactors.load(tmp_path / "F.npz").patches
    np.testing.assert_array_equal(again.obstructions, F.patches.obstructions)
    assert form_factors(again).toarray()[0, 1] == pytest.approx(PLATE, abs=1e-6)


def test_damaged_files_are_refused(tmp_path: Path) -> None:
    (tmp_path / "F.npz").write_bytes(b"PK\x03\x04 nothing")
    with pytest.raises(ValueError, match=r"F.npz: this is no file of form factors"):
        FormFactors.load(tmp_path / "F.npz")
    np.savez(tmp_path / "other.npz", x=np.zeros(3))
    with pytest.raises(ValueError, match=r"other.npz: this is no file of form factors"):
        FormFactors.load(tmp_path / "other.npz")
    with pytest.raises(ValueError, match=r"cannot write '\.txt'"):
        form_factors(plate()).save(tmp_path / "F.txt")


def test_tables(tmp_path: Path) -> None:
    form_factors(plate(), tolerance=1e-7).save(tmp_path / "F.csv")
    header, first, second = (tmp_path / "F.csv").read_text().splitlines()
    assert header == "from,to,factor,from_surface,to_surface"
    assert (first.split(",")[0], *first.split(",")[3:]) == ("0", "lower", "upper")
    assert float(second.split(",")[2]) == pytest.approx(PLATE, abs=1e-7)


@pytest.mark.parametrize("method", METHODS)
def test_the_same_bytes_on_any_number_of_threads(method: Method) -> None:
    patches = scenes.cornell_box().patches(count=100)
    options = {"monte_carlo": {"rays": 512}, "hemicube": {"hemicubes": 2}, "nusselt": {"points": 2}}.get(
        method, {"tolerance": 1e-2}
    )

    def found(**more: int) -> bytes:
        return form_factors(patches, method=method, **options, **more).toarray().tobytes()

    assert found(threads=1) == found(threads=2) == found(threads=1)
    if method in ("monte_carlo", "hemicube"):
        assert found(seed=1) != found(seed=2)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-6, 1e-8])
def test_rows_of_a_closed_room_sum_to_one(tolerance: float) -> None:
    F = form_factors(Scene([one_surface(tiles(4))]).patches(as_is=True), tolerance=tolerance)
    assert np.max(np.abs(F.closure() - 1)) < tolerance


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4])
def test_rows_of_a_room_with_a_box_sum_to_one(tolerance: float) -> None:
    room, box = tiles(3), [0.3 * t[::-1] + [0.2, 0.4, 0.3] for t in tiles(2)]
    F = form_factors(Scene([one_surface(room), one_surface(box, "box")]).patches(as_is=True), tolerance=tolerance)
    assert np.max(np.abs(F.closure() - 1)) < tolerance
    assert F.report.unresolved == 0


@pytest.mark.parametrize("scale", [1e-3, 1e4])
def test_the_unit_of_length_does_not_matter(scale: float) -> None:
    patches = plate()
    other = plate(scale)
    assert form_factors(other).toarray()[0, 1] == pytest.approx(form_factors(patches).toarray()[0, 1], rel=1e-9)


def test_the_order_of_patches_does_not_matter() -> None:
    polygons = tiles(3)
    order = np.random.default_rng(2).permutation(len(polygons))
    F = form_factors(Scene([one_surface(polygons)]).patches(as_is=True)).toarray()
    G = form_factors(Scene([one_surface([polygons[k] for k in order])]).patches(as_is=True)).toarray()
    np.testing.assert_allclose(G, F[np.ix_(order, order)], rtol=0, atol=1e-6)


def test_an_obstruction_never_adds() -> None:
    polygons = tiles(3)
    lid = Surface(square(0.4, 0.3) + np.array([0.5, 0.5, 0]), [[0, 1, 2, 3]])
    free = form_factors(Scene([one_surface(polygons)]).patches(as_is=True))
    blocked = form_factors(Scene([one_surface(polygons)], obstructions=[lid]).patches(as_is=True), tolerance=1e-5)
    assert np.all(blocked.toarray() <= free.toarray() + 1e-6)
    assert blocked.toarray().sum() < free.toarray().sum() - 1


def test_more_rays_are_nearer_to_the_truth() -> None:
    patches = cube().patches(as_is=True)

    def error(rays: int) -> float:
        found = [form_factors(patches, rays=rays, seed=seed).toarray() for seed in range(8)]
        return float(np.sqrt(np.mean([(f - cube_factors()) ** 2 for f in found])))

    # 64 times the rays: 8 times better at least, twice that allowed for the luck of eight seeds.
    assert error(16384) < error(256) / 4


def test_rays_have_a_standard_error() -> None:
    patches = cube().patches(as_is=True)
    F = form_factors(patches, method="monte_carlo", rays=RAYS)
    error = F.standard_error()
    # 2 RAYS rays of both ends, of which a fifth hit: at least that of independent rays, sqrt(F (1 - F) / (2 RAYS)).
    assert error.toarray()[0, 1] == pytest.approx(np.sqrt(0.2 * 0.8 / (2 * RAYS)), rel=0.05)
    assert np.max(np.abs(F.toarray() - cube_factors()) / np.where(cube_factors() > 0, error.toarray(), 1)) < 4
    with pytest.raises(ValueError, match="auto has no standard errors"):
        form_factors(patches).standard_error()


def test_closure_is_enforced_at_least_cost() -> None:
    noisy = form_factors(Scene([one_surface(tiles(2))]).patches(as_is=True), rays=1024)
    before = noisy.closure()
    fitted = noisy.enforce("closure")
    np.testing.assert_array_equal(noisy.closure(), before)
    assert np.max(np.abs(before - 1)) > 1e-3
    np.testing.assert_allclose(fitted.closure(), 1, rtol=0, atol=1e-9)
    assert fitted.reciprocity_error() < 1e-15
    # Nothing is moved further than what was missing calls for.
    change = np.abs(fitted.toarray() - noisy.toarray())
    assert np.max(change) < 2 * np.max(np.abs(before - 1))
    exact = form_factors(noisy.patches).toarray()
    assert np.linalg.norm(fitted.toarray() - exact) < np.linalg.norm(noisy.toarray() - exact)


def test_what_cannot_be_enforced_is_refused() -> None:
    F = form_factors(plate())
    with pytest.raises(ValueError, match="nothing to enforce by the name 'symmetry'"):
        F.enforce("symmetry")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="within 0 and 1"):
        F.enforce("closure", 1.5)
    alone = form_factors(Scene([Surface(square(), [[0, 1, 2, 3]])]).patches(as_is=True))
    with pytest.raises(ValueError, match="patch 0 sees nothing"):
        alone.enforce("closure")
    uneven = Scene([Surface(square(), [[0, 1, 2, 3]]), Surface(square(2.0, 1.0), [[3, 2, 1, 0]])])
    with pytest.raises(ValueError, match="no reciprocal form factors have these row sums"):
        form_factors(uneven.patches(as_is=True)).enforce("closure")


def test_a_tolerance_is_kept_by_rays() -> None:
    patches = cube().patches(as_is=True)
    found = [form_factors(patches, method="monte_carlo", tolerance=0.02, seed=s).toarray() for s in range(16)]
    assert np.sqrt(np.mean((np.array(found) - cube_factors()) ** 2)) <= 0.02


@pytest.mark.parametrize(("method", "tolerance"), [("nusselt", 1e-4), ("hemicube", 3e-3)])
def test_points_and_hemicubes_are_added_until_they_agree(method: Method, tolerance: float) -> None:
    F = form_factors(cube().patches(as_is=True), method=method, tolerance=tolerance)
    assert F.report.estimated_error <= tolerance
    assert np.max(np.abs(F.toarray() - cube_factors())) < 2 * tolerance
    coarse = form_factors(cube().patches(as_is=True), method=method, tolerance=0.1)
    assert coarse.report.samples < F.report.samples


def test_it_is_solved_on_as_it_is() -> None:
    # B = E + rho F B with one unknown by symmetry: 1 / (1 - rho) for E = 1, as every row sums to 1.
    for method in EXACT:
        patches = cube(reflectance=0.5).patches(as_is=True)
        solution = solve(patches, transport=form_factors(patches, method=method))
        np.testing.assert_allclose(solution.radiosity, 2.0, rtol=1e-6)
        assert solution.report.estimated_error < 1e-5
        dark = solution.relight(reflectance=0.0)
        np.testing.assert_allclose(dark.radiosity, 1.0, rtol=1e-9)


def test_a_row_that_is_not_there() -> None:
    F = form_factors(cube().patches(as_is=True))
    for i in (6, -7):
        with pytest.raises(IndexError, match=f"row {i} of 6 patches"):
            F.row(i)


def test_what_cannot_be_measured_is_refused() -> None:
    patches = cube().patches(as_is=True)
    with pytest.raises(ValueError, match="no method 'guess'; choose auto, analytic, "):
        form_factors(patches, method="guess")  # type: ignore[arg-type]
    for tolerance in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="tolerance must be a positive number"):
            form_factors(patches, tolerance=tolerance)
    with pytest.raises(ValueError, match="a tolerance of 1e-06 is out of reach of rays"):
        form_factors(patches, method="monte_carlo", tolerance=1e-6)
    with pytest.raises(ValueError, match="the method contour takes no rays"):
        form_factors(patches, method="contour", rays=5)
    with pytest.raises(ValueError, match="rays must be from 1 to"):
        form_factors(patches, rays=0)
    with pytest.raises(ValueError, match="resolution must be even"):
        form_factors(patches, method="hemicube", resolution=33)
    with pytest.raises(ResourceError, match=r"6 sides may take .* and the limit is 0.1 kB"):
        form_factors(patches, memory_limit=100)


def test_nothing_and_next_to_nothing() -> None:
    flat = Scene([Surface([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]])])
    assert form_factors(flat.patches(as_is=True)).toarray().tolist() == [[0.0]]
    one = form_factors(Scene([Surface(square(), [[0, 1, 2, 3]])]).patches(as_is=True))
    assert one.toarray().tolist() == [[0.0]]
    assert one.closure().tolist() == [0.0]
