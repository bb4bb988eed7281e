"""Whether the known answers are true: each beside a second computation, and what must hold of it anyway."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from convex_room import ConvexRoom
from exact_light import from_lamp, mean_over, part_behind, solid_angle
from known_answers import (
    KNOWN,
    Known,
    KnownEverywhere,
    KnownFromFile,
    Means,
    from_point_in_box,
    true_error_of_field,
    true_error_of_means,
)

import radiosity
from radiosity import catalogue

EVERYWHERE = [name for name, known in KNOWN.items() if isinstance(known, KnownEverywhere)]
FROM_FILE = [name for name, known in KNOWN.items() if isinstance(known, KnownFromFile)]
ACCURACY = 0.02


@cache
def truth_of(known: Known) -> tuple[radiosity.Patches, Means]:
    """Few patches, as the truth on each costs the same."""
    patches = known.mesh(200)
    return patches, known.patch_means(patches)


def mean(patches: radiosity.Patches, values: np.ndarray) -> np.ndarray:
    """(bands,) over area."""
    return patches.area @ values / patches.area.sum()


@pytest.mark.parametrize("name", KNOWN)
def test_engine_agrees(name: str) -> None:
    known = KNOWN[name]
    patches, truth = truth_of(known)
    assert not [f for f in known.scene().findings() if f.severity == "error"]
    solution = radiosity.solve(patches, accuracy=ACCURACY, seed=7, transport="sampled")
    counts = known.counts(patches)
    error = true_error_of_means(patches, solution.irradiance, truth, counts)
    # The engine's own estimate, root mean square over some 200 patches, is good to a factor of two at the least; of the
    # error of the truth it says nothing.
    assert error < 2 * solution.report.estimated_error + known.accuracy_of_truth
    # Errors of patches average out; a truth that is off as a whole would stay. Standard errors of patches as if they
    # were one, which is four times too much or so.
    sigma = np.hypot(mean(patches, solution.error), mean(patches, truth.error))
    level = mean(patches, truth.value)
    off = np.abs(mean(patches, (solution.irradiance - truth.value) * counts[:, None]))
    assert np.all(off < 1.5 * sigma + known.accuracy_of_truth * level)


@pytest.mark.parametrize("name", EVERYWHERE)
def test_means_are_means_of_points(name: str) -> None:
    known = KNOWN[name]
    patches, truth = truth_of(known)
    probes = known.probes(2000)
    # Points are spread evenly over equal shares of the area; independent ones would miss the mean by this.
    sigma = probes.value.std(axis=0) / np.sqrt(len(probes.points))
    level = mean(patches, truth.value)
    assert np.all(np.abs(probes.value.mean(axis=0) - level) < 4 * sigma + 1e-4 * level)


@pytest.mark.parametrize("name", FROM_FILE)
def test_stored_points_agree_with_stored_means(name: str) -> None:
    known = KNOWN[name]
    patches, truth = truth_of(known)
    probes = known.probes()
    sigma = probes.value.std(axis=0) / np.sqrt(len(probes.points))
    assert np.all(np.abs(probes.value.mean(axis=0) - mean(patches, truth.value)) < 4 * sigma)
    # The errors are those that the file is good for.
    level = mean(patches, truth.value).mean()
    assert np.sqrt((probes.error**2).mean()) / level < known.accuracy_of_truth
    assert true_error_of_field(known, lambda points, surface: probes.value) == 0


def test_means_of_another_mesh_are_not_made_up() -> None:
    known = KNOWN["keyhole"]
    with pytest.raises(LookupError, match="mesh"):
        known.patch_means(known.scene().patches(count=50))
    with pytest.raises(LookupError, match="means"):
        KNOWN["cornell"].probes()
    with pytest.raises(LookupError, match="any point"):
        known.irradiance_at(np.zeros((1, 3)), np.zeros(1, np.int64))


@pytest.mark.parametrize("name", ["point over floor", "point and screen", "sun and screen"])
def test_closed_means_are_integrals(name: str) -> None:
    known = KNOWN[name]
    patches, truth = truth_of(known)
    by_points = Means(mean_over(patches, known.irradiance_at), np.zeros_like(truth.value))
    # Cells of 1/128 of a patch miss up to their width along an edge of the shadow: 1/128 of the few patches it runs
    # through, with either sign.
    assert true_error_of_means(patches, truth.value, by_points) < (1e-7 if name == "point over floor" else 1e-3)


def test_lamp_behind_a_plate_midway() -> None:
    # Unit squares at gap 1, a centred plate of half the size midway: a smooth four-dimensional integral.
    def flat(a: float, b: float, z: float) -> np.ndarray:
        return np.array([[a, a, z], [b, a, z], [b, b, z], [a, b, z]])

    lamp, plate = flat(0, 1, 1)[::-1], flat(0.25, 0.75, 0.5)
    floor = radiosity.Scene([radiosity.Surface(flat(0, 1, 0), [[0, 1, 2, 3]])]).patches(as_is=True)

    def at(points: np.ndarray, surface: np.ndarray) -> np.ndarray:
        return from_lamp(points, np.tile([0.0, 0, 1], (len(points), 1)), lamp, [[plate]])[:, None]

    assert mean_over(floor, at)[0, 0] == pytest.approx(0.09950629459898, rel=1e-4)


def test_hidden_part_against_rays() -> None:
    rng = np.random.default_rng(2)
    known = KNOWN["window and box"]
    scene = known.scene()
    patches = scene.patches(as_is=True)
    box = [s for s, surface in enumerate(scene.surfaces) if surface.name.startswith("box")]
    window = next(s for s, surface in enumerate(scene.surfaces) if surface.name == "window")
    a, b, _, d = patches.polygons[window]
    floor = next(s for s, surface in enumerate(scene.surfaces) if surface.name == "floor")
    for point in ([2.0, 1.4, 0.0], [1.9, 0.6, 0.0], [2.6, 1.2, 0.0]):
        eye = np.array(point)
        s, t = rng.random((2, 200_000, 1))
        way = a + s * (b - a) + t * (d - a) - eye
        distance = np.linalg.norm(way, axis=1)
        visible = ~np.any([_crosses(eye, way, patches.polygons[k]) for k in box], axis=0)
        area = np.linalg.norm(np.cross(b - a, d - a))
        each = visible * way[:, 2] * -way[:, 0] / distance**4 * area / np.pi  # the window is at x = 0
        expected, sigma = each.mean(), each.std() / np.sqrt(len(each))
        found = known.irradiance_at(eye[None], np.array([floor]))[0, 0] / 5.0
        assert found == pytest.approx(expected, abs=4 * sigma)


def _crosses(eye: np.ndarray, way: np.ndarray, face: np.ndarray) -> np.ndarray:
    a, b, _, d = face
    normal = np.cross(b - a, d - a)
    share = ((a - eye) @ normal / (way @ normal))[:, None]
    at = eye + share * way - a
    s, t = at @ (b - a) / ((b - a) @ (b - a)), at @ (d - a) / ((d - a) @ (d - a))
    return (share[:, 0] > 0) & (share[:, 0] < 1) & (s > 0) & (s < 1) & (t > 0) & (t < 1)


def test_solid_angles_and_parts() -> None:
    # A cube seen from its middle has six equal faces in 4 pi, and each has four equal quarters.
    face = np.array([[[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]]], dtype=float)
    assert solid_angle(face, np.zeros(3))[0] == pytest.approx(4 * np.pi / 6)
    quarter = part_behind(
        face, np.array([[0, 0, 0.5], [0.5, 0, 0.5], [0.5, 0.5, 0.5], [0, 0.5, 0.5]]), eye=np.zeros((1, 3))
    )
    assert solid_angle(quarter, np.zeros(3))[0] == pytest.approx(np.pi / 6)


@pytest.mark.parametrize("name", ["lamp room", "point in box"])
def test_power_is_conserved_in_closed_rooms(name: str) -> None:
    # Of flux Phi in a closed room of surface S and uniform rho the mean irradiance is Phi / ((1 - rho) S).
    known = KNOWN[name]
    patches, truth = truth_of(known)
    reflectance = np.asarray(known.scene().surfaces[0].reflectance)
    flux = 0.04 * np.array([20.0, 10.0]) if name == "lamp room" else np.array([4 * np.pi])
    expected = flux / ((1 - reflectance) * patches.area.sum())
    np.testing.assert_allclose(mean(patches, truth.value), expected, rtol=3e-4)


def test_parallel_squares_by_gauss_points() -> None:
    # The kernel is smooth, so that a product of Gauss rules converges to rounding: an equation at points, no panels.
    x, w = np.polynomial.legendre.leggauss(24)
    x, w = 0.5 * (x + 1), 0.5 * w
    at = np.stack([g.ravel() for g in np.meshgrid(x, x)], axis=1)
    weight, gap = np.outer(w, w).ravel(), 0.5
    square = ((at[:, None] - at[None]) ** 2).sum(axis=2)
    K = gap**2 / (np.pi * (square + gap**2) ** 2) * weight
    # B_lower = 1 + 0.5 H_lower, B_upper = 0.9 H_upper.
    upper = np.linalg.solve(np.eye(len(K)) - 0.45 * K @ K, K @ np.ones(len(K)))
    lower = 0.9 * K @ upper
    known = KNOWN["parallel squares"]
    points = [np.column_stack([at, np.full(len(at), z)]) for z in (0.0, gap)]
    for surface, expected in enumerate((lower, upper)):
        found = known.irradiance_at(points[surface], np.full(len(at), surface))[:, 0]
        np.testing.assert_allclose(found, expected, rtol=known.accuracy_of_truth)


@pytest.mark.parametrize("name", ["perpendicular squares", "point in box"])
def test_larger_panels_change_little(name: str) -> None:
    known = KNOWN[name]
    probes = known.probes(200)
    room = ConvexRoom(known.scene(), from_point_in_box if name == "point in box" else None, panels=10)
    larger = room.irradiance_at(probes.points, probes.surface)
    change = np.sqrt(((larger - probes.value) ** 2).mean()) / probes.value.mean()
    # Of second order at the least: 2.6 times the error of the truth, so the change is 1.6 times that.
    assert change < 1.6 * known.accuracy_of_truth


def test_power_that_a_lamp_sends_to_its_neighbour() -> None:
    # The mean over the wall of what comes from the floor is the form factor of squares with a common edge.
    known = KNOWN["perpendicular squares"]
    patches = known.mesh(200)
    room = ConvexRoom(known.scene())
    direct = mean_over(patches, room.direct_at)[:, 0]
    wall = patches.surface == 1
    factor = catalogue.perpendicular_rectangles_with_common_edge(width_1=1, width_2=1, length=1)
    assert np.average(direct[wall], weights=patches.area[wall]) == pytest.approx(factor, rel=1e-4)
