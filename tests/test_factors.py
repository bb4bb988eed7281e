"""Form factors."""

from __future__ import annotations

import numpy as np
import pytest
from known import cube, cube_factors
from scipy.sparse.linalg import LinearOperator

from radiosity import FormFactors, Patches, Scene, Surface, form_factors, scenes

RAYS = 1 << 14


@pytest.fixture(scope="module")
def faces() -> FormFactors:
    return form_factors(cube().patches(as_is=True), rays=RAYS)


@pytest.fixture(scope="module")
def many() -> FormFactors:
    return form_factors(scenes.cornell_box().patches(count=300), rays=1024)


def test_the_faces_of_a_cube(faces: FormFactors) -> None:
    # Independent rays would have a standard error of sqrt(0.2 * 0.8 / RAYS) = 0.003; spread evenly they do better.
    assert faces.toarray() == pytest.approx(cube_factors(), abs=0.01)


def test_more_rays_are_nearer_to_the_truth() -> None:
    patches = cube().patches(as_is=True)

    def error(rays: int) -> float:
        found = [form_factors(patches, rays=rays, seed=seed).toarray() for seed in range(8)]
        return float(np.sqrt(np.mean([(f - cube_factors()) ** 2 for f in found])))

    # 64 times the rays: 8 times better at least, twice that allowed for the luck of eight seeds.
    assert error(16384) < error(256) / 4


def test_reciprocity(many: FormFactors) -> None:
    exchange = many.patches.area[:, None] * many.toarray()
    np.testing.assert_allclose(exchange, exchange.T, rtol=1e-12)
    assert np.count_nonzero(exchange) > len(many.patches) * 50


def test_closure_of_an_enclosure() -> None:
    f = form_factors(cube().patches(count=300), rays=256)
    # No ray escapes, so that the exchange adds up to the area but for rounding to single precision.
    assert np.average(f.closure(), weights=f.patches.area) == pytest.approx(1, abs=1e-5)
    assert f.closure() == pytest.approx(f.toarray().sum(axis=1))


def test_closure_of_what_is_open(many: FormFactors) -> None:
    # The Cornell box lacks its front wall.
    assert np.average(many.closure(), weights=many.patches.area) < 0.95


def test_it_is_an_operator(many: FormFactors) -> None:
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
    assert np.array_equal(many.to_scipy_sparse().toarray(), dense)
    assert np.all(dense >= 0)


def test_a_row_that_is_not_there(faces: FormFactors) -> None:
    for i in (6, -7):
        with pytest.raises(IndexError, match=f"row {i} of 6 patches"):
            faces.row(i)


def test_the_same_seed_gives_the_same_bytes_on_any_number_of_threads() -> None:
    patches = scenes.cornell_box().patches(count=200)

    def measured(**options: int) -> bytes:
        return form_factors(patches, rays=512, **options).toarray().tobytes()

    assert measured(threads=1) == measured(threads=2) == measured(threads=1)
    assert measured(seed=1) != measured(seed=2)


def both_sides() -> Patches:
    return Scene([Surface(np.eye(3), [[0, 1, 2]], two_sided=True)]).patches(as_is=True)


def test_what_cannot_be_measured_is_refused() -> None:
    with pytest.raises(ValueError, match="set two_sided=False"):
        form_factors(both_sides(), rays=16)
    patches = cube().patches(as_is=True)
    with pytest.raises(ValueError, match="no method 'guess'; choose auto or monte_carlo"):
        form_factors(patches, method="guess")
    for tolerance in (0.0, -1.0, 1e-6, float("nan")):
        with pytest.raises(ValueError, match=f"a tolerance of {tolerance} is out of reach"):
            form_factors(patches, tolerance=tolerance)
    with pytest.raises(ValueError, match="rays must be from 1 to"):
        form_factors(patches, rays=0)


def test_a_tolerance_is_kept() -> None:
    found = [form_factors(cube().patches(as_is=True), tolerance=0.02, seed=seed).toarray() for seed in range(16)]
    assert np.sqrt(np.mean((np.array(found) - cube_factors()) ** 2)) <= 0.02
