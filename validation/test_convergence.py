"""Errors of form factors against closed forms: whether tolerances are met, and how errors fall with effort.

The slow ones leave plots in validation/out/.
"""

from __future__ import annotations

import numpy as np
import pytest
from known_pairs import KNOWN_PAIRS, PLATE, SEPARATED, TOUCHING, KnownPair, flat, hinged, patches_of, plate
from plots import Guide, plot_errors, rate

import radiosity
from radiosity import catalogue, teaching

TOLERANCES = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10]

each_pair = pytest.mark.parametrize("pair", KNOWN_PAIRS.values(), ids=KNOWN_PAIRS)


@each_pair
def test_analytic(pair: KnownPair) -> None:
    # Closed forms, or contour integrals to 1e-12 a patch.
    assert pair.found(method="analytic") == pytest.approx(pair.factor, abs=2e-12)


@pytest.mark.parametrize("method", ["contour", "auto"])
@each_pair
def test_tolerances_are_met(pair: KnownPair, method: str) -> None:
    for tolerance in TOLERANCES:
        assert pair.found(method=method, tolerance=tolerance) == pytest.approx(pair.factor, abs=tolerance), tolerance


@pytest.mark.parametrize("method", ["contour", "auto"])
def test_tolerances_are_met_behind_a_plate(method: str) -> None:
    patches = plate()
    for tolerance in [1e-3, 1e-4, 1e-5, 1e-6, 1e-7]:
        found = radiosity.form_factors(patches, method=method, tolerance=tolerance, threads=1).row(0)[1]
        assert found == pytest.approx(PLATE, abs=tolerance), tolerance


def test_long_rectangles_approach_strips() -> None:
    # What the ends take falls as 1/length, so that twice the factor of twice the length less that of the length is
    # better by an order.
    strip = catalogue.equal_parallel_strips(width=1, gap=1)
    edge = catalogue.strips_with_common_edge(width_1=1, width_2=1, angle=np.pi / 2)

    def facing(length: float) -> float:
        return KnownPair(flat((0, 1), (0, length), 0), flat((0, 1), (0, length), 1, down=True), 0).found()

    def standing(length: float) -> float:
        return KnownPair(flat((0, 1), (0, length), 0), hinged(1, length, np.pi / 2), 0).found()

    for factor, expected in ((facing, strip), (standing, edge)):
        short, long = factor(500), factor(1000)
        assert expected - 2e-3 < short < long < expected
        assert 2 * long - short == pytest.approx(expected, abs=2e-6)


@pytest.mark.parametrize(("radius_1", "radius_2"), [(1.0, 1.0), (0.5, 1.0)])
def test_disks_lie_between_polygons_in_and_around_them(radius_1: float, radius_2: float) -> None:
    # The exchange is an integral of what is not negative: it grows with either area.
    exact = np.pi * radius_1**2 * catalogue.coaxial_disks(radius_1=radius_1, radius_2=radius_2, gap=1)
    n = 48
    inner, outer = (_exchange_of_polygons(n, radius_1 * f, radius_2 * f) for f in (1, 1 / np.cos(np.pi / n)))
    assert inner < exact < outer
    assert outer - inner < 0.02 * exact  # areas differ by (pi / n)^2, and there are two of them


def _exchange_of_polygons(n: int, radius_1: float, radius_2: float) -> float:
    """A1 F12, m2, of two regular polygons at gap 1, face to face, each a fan of triangles."""
    angle = 2 * np.pi * np.arange(n) / n
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)

    def fan(radius: float, z: float, turn: int) -> list[np.ndarray]:
        rim = np.column_stack([radius * ring, np.full(n, z)])
        return [np.array([[0, 0, z], rim[k], rim[(k + 1) % n]])[::turn] for k in range(n)]

    F = radiosity.form_factors(patches_of(*fan(radius_1, 0, 1), *fan(radius_2, 1, -1)), tolerance=1e-8)
    return float(F.area[:n] @ F.toarray()[:n, n:].sum(axis=1))


# --- how errors fall ---------------------------------------------------------------------------------------------


def rms(pair: KnownPair, seeds: int, **options: object) -> float:
    """Root mean square error over seeds."""
    patches = patches_of(pair.first, pair.second)
    found = [radiosity.form_factors(patches, seed=s, threads=1, **options).row(0)[1] for s in range(seeds)]
    return float(np.sqrt(np.mean((np.array(found) - pair.factor) ** 2)))


SOURCE = flat((-5e-4, 5e-4), (-5e-4, 5e-4), 0)
"""A square of 1 mm: what is half a metre away is seen from it as from a point, to 1e-6."""


def rectangles_above(count: int, *, along_pixels: bool) -> list[KnownPair]:
    """The small source and random rectangles above it; with their edges along the pixels of the hemicube, or not."""
    rng, pairs = np.random.default_rng(3), []
    for seed in range(count):
        x, y = np.sort(rng.uniform(-0.8, 0.8, (2, 2)), axis=1)
        target = flat(tuple(x), tuple(y), 0.5, down=True)
        if along_pixels:
            axes = teaching.item_buffer(patches_of(SOURCE), 0, resolution=8, seed=seed).axes
            target = target @ axes
        pairs.append(KnownPair(SOURCE, target, teaching.nusselt_form_factor((0, 0, 0), (0, 0, 1), target)))
    return pairs


def test_the_small_square_is_as_good_as_a_point() -> None:
    for pair in rectangles_above(8, along_pixels=False):
        assert pair.found(method="analytic") == pytest.approx(pair.factor, abs=2e-6)


def hemicube_error(pairs: list[KnownPair], resolution: int) -> float:
    """RMS error of one hemicube a patch, each pair with a turn of its own."""
    found = [pair.found(resolution=resolution, hemicubes=1, seed=seed) for seed, pair in enumerate(pairs)]
    return float(np.sqrt(np.mean([(f - pair.factor) ** 2 for f, pair in zip(found, pairs, strict=True)])))


@pytest.mark.slow
def test_hemicube_from_a_point_by_resolution() -> None:
    resolutions, slopes, series = [32, 64, 128, 256, 512, 1024], {}, {}
    for label, along_pixels in (("edges along the pixels", True), ("edges at any angle to them", False)):
        pairs = rectangles_above(64, along_pixels=along_pixels)
        error = [hemicube_error(pairs, r) for r in resolutions]
        slopes[along_pixels] = rate(resolutions, error)
        series[f"{label}, slope {slopes[along_pixels]:.2f}"] = resolutions, error
    aligned, turned = (error for _, error in series.values())
    plot_errors(
        "hemicube_resolution", "A hemicube at a point: counting pixels", "pixels along an edge", series,
        [Guide(-1, "1 / resolution", (32, aligned[0])), Guide(-1.5, "1 / resolution$^{1.5}$", (32, turned[0]))],
        "RMS error of F over 64 rectangles",
    )  # fmt: skip
    # An edge along a row of pixels takes or leaves the whole row: 1 / resolution. One at an angle rounds pixel by
    # pixel, up as often as down: nearly 1 / resolution^2, but where the angle is below 1 / resolution, which over all
    # angles makes 1 / resolution^1.5, root mean square.
    assert slopes[True] == pytest.approx(-1, abs=0.2)
    assert -2.1 < slopes[False] < -1.3


@pytest.mark.slow
@pytest.mark.parametrize(("name", "pair"), [("separated", SEPARATED), ("touching", TOUCHING)])
def test_hemicubes_by_number(name: str, pair: KnownPair) -> None:
    counts = [1, 2, 4, 8, 16, 32, 64, 128, 256]
    series = {}
    for resolution in (64, 256, 1024):
        error = [rms(pair, 8, resolution=resolution, hemicubes=n) for n in counts]
        series[f"{resolution} pixels an edge, slope {rate(counts[1:], error[1:]):.2f}"] = counts, error
    first = error[1]
    plot_errors(
        f"hemicubes_{name}", f"Hemicubes spread over {name} unit squares", "hemicubes per patch", series,
        [Guide(-0.5, "independent points", (2, first)), Guide(-1, "1 / hemicubes", (2, first))],
        "RMS error of F over 8 seeds",
    )  # fmt: skip
    # Points in sequence do better than independent ones.
    assert rate(counts[1:], error[1:]) < -0.75


@pytest.mark.slow
def test_hemicubes_by_resolution() -> None:
    resolutions = [32, 64, 128, 256, 512, 1024]
    series = {}
    for name, pair in (("separated", SEPARATED), ("touching", TOUCHING)):
        for count in (1, 64):
            error = [rms(pair, 8, resolution=r, hemicubes=count) for r in resolutions]
            series[f"{name}, {count} per patch"] = resolutions, error
    plot_errors(
        "hemicubes_resolution", "Hemicubes on unit squares: pixels do not help where positions are few",
        "pixels along an edge", series, [Guide(-1, "1 / resolution", (32, series["separated, 64 per patch"][1][0]))],
        "RMS error of F over 8 seeds",
    )  # fmt: skip
    # From the centre alone the view's change over the patch is missed, whatever the resolution.
    for name in ("separated", "touching"):
        error = series[f"{name}, 1 per patch"][1]
        assert error[-1] > 0.5 * error[2]


POINTS = [1, 2, 3, 4, 6, 8, 11, 16, 23, 32, 45, 64]


def nusselt_pairs() -> dict[str, KnownPair]:
    """How patches may lie for Nusselt's analog.

    Unit squares with a common edge would be too kind: near a corner the view depends on the ratio of two coordinates
    alone, and exchanging them, which leaves the square and its points as they are, cancels the error.
    """
    square, part = flat((0, 1), (0, 1), 0), hinged(1, 0.3, np.pi / 2)
    return {
        "apart": SEPARATED,
        "a whole edge in common": KNOWN_PAIRS["touching, h/w 0.5"],
        "an edge ends within the other's": KnownPair(
            square, part, KnownPair(square, part, 0).found(method="analytic")
        ),
    }  # fmt: skip


def nusselt_errors(pair: KnownPair, points: list[int]) -> list[float]:
    return [abs(pair.found(points=n) - pair.factor) for n in points]


@pytest.mark.slow
def test_nusselt_by_points() -> None:
    series = {name: (POINTS, nusselt_errors(pair, POINTS)) for name, pair in nusselt_pairs().items()}
    whole, within = (series[name][1] for name in list(series)[1:])
    plot_errors(
        "nusselt_points", "Nusselt's analog averaged over Gauss points", "points along each direction", series,
        [Guide(-4, "1 / points$^4$", (POINTS[-1], whole[-1])), Guide(-2, "1 / points$^2$", (POINTS[-1], within[-1]))],
    )  # fmt: skip


def test_nusselt_converges() -> None:
    pairs = nusselt_pairs()
    few, more = nusselt_errors(pairs["apart"], [4, 8])
    assert more < few / 20**4 * 2  # geometrically
    # Points of Gauss's rule are 1 / n^2 off an edge at the ends, in both directions, and the view varies as much there
    # as anywhere: 1 / n^4.
    points = [8, 16, 32, 64]
    assert rate(points, nusselt_errors(pairs["a whole edge in common"], points)) == pytest.approx(-4, abs=0.25)
    # Rows of points within 1 / n of the edge, of which the k-th weighs k / n^2, see a step and miss it by up to 1 / n.
    # There are sqrt(n): 1 / n^2 if their errors have one sign, 1 / n^2.25 if not.
    every = list(range(10, 65))
    slope = rate(every, nusselt_errors(pairs["an edge ends within the other's"], every))
    assert slope == pytest.approx(-2, abs=0.5)


RAYS = [1 << k for k in range(6, 17)]


def plain_monte_carlo(rays: int, seeds: int) -> float:
    """RMS error of independent rays between unit squares at gap 1, so many from either."""
    rng = np.random.default_rng(rays)
    found = []
    for _ in range(seeds):
        start, u, angle = rng.random((2 * rays, 2)), rng.random(2 * rays), 2 * np.pi * rng.random(2 * rays)
        # Cosine-distributed: the sine is sqrt(u) (Malley 1988). At gap 1 a ray moves aside by its tangent.
        tangent = np.sqrt(u / (1 - u))
        end = start + tangent[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        found.append(np.mean(np.all((end > 0) & (end < 1), axis=1)))
    return float(np.sqrt(np.mean((np.array(found) - SEPARATED.factor) ** 2)))


@pytest.mark.slow
def test_rays_in_sequence_beat_independent_ones() -> None:
    seeds = 64
    plain = [plain_monte_carlo(n, seeds) for n in RAYS]
    series = {f"independent rays, slope {rate(RAYS, plain):.2f}": (RAYS, plain)}
    for name, pair in (("separated", SEPARATED), ("touching", TOUCHING)):
        error = [rms(pair, seeds, rays=n) for n in RAYS]
        series[f"{name} squares, slope {rate(RAYS, error):.2f}"] = RAYS, error
        assert rate(RAYS, error) < -0.6  # a discontinuity in four dimensions, stratified: -1/2 - 1/8
    sigma = np.sqrt(SEPARATED.factor * (1 - SEPARATED.factor) / 2)
    plot_errors(
        "monte_carlo_rays", "Rays between unit squares", "rays per patch", series,
        [Guide(-0.5, "binomial: 1 / $\\sqrt{\\mathrm{rays}}$", (1, sigma)),
         Guide(-0.625, "1 / rays$^{5/8}$", (1, list(series.values())[1][1][3] * RAYS[3] ** 0.625))],
        f"RMS error of F over {seeds} seeds",
    )  # fmt: skip
    # The standard deviation over 64 seeds is itself known to 9 %.
    np.testing.assert_allclose(plain, sigma / np.sqrt(RAYS), rtol=0.35)
    assert rate(RAYS, plain) == pytest.approx(-0.5, abs=0.06)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["contour", "auto"])
def test_plot_of_tolerances(method: str) -> None:
    series = {
        name: (TOLERANCES, [abs(pair.found(method=method, tolerance=t) - pair.factor) for t in TOLERANCES])
        for name, pair in KNOWN_PAIRS.items()
        if name not in ("touching, h/w 0.5", "touching, h/w 2")
    }
    patches, wanted = plate(), TOLERANCES[:6]
    found = [radiosity.form_factors(patches, method=method, tolerance=t, threads=1).row(0)[1] for t in wanted]
    series["behind a plate"] = wanted, [abs(f - PLATE) for f in found]
    plot_errors(
        f"tolerance_{method}", f"The method '{method}': errors stay below what was asked", "tolerance", series,
        [Guide(1, "error = tolerance", (1e-3, 1e-3))], whole_guides=True,
    )  # fmt: skip
    for _, (tolerances, error) in series.items():
        assert np.all(np.array(error) <= tolerances)
