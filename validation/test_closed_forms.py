"""Light and form factors with closed-form answers."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pieces import mean_irradiance, rectangle

import radiosity

# Howell, catalogue of configuration factors: C-11, C-14.
OPPOSITE_SQUARES = 0.19982489569838746
PERPENDICULAR_SQUARES = 0.20004377607540316


def two_rectangles(kind: str) -> tuple[radiosity.Scene, float]:
    """A black emitter and a black receiver with a known form factor from the receiver."""
    floor = rectangle([0, 0, 0], [1, 0, 0], [0, 1, 0], name="receiver", cells=(4, 4))
    if kind == "opposite":
        lamp = rectangle([0, 0, 1], [0, 1, 0], [1, 0, 0], emission=1.0, name="lamp")
        return radiosity.Scene([floor, lamp]), OPPOSITE_SQUARES
    if kind == "touching":
        lamp = rectangle([0, 0, 0], [0, 1, 0], [0, 0, 1], emission=1.0, name="lamp")
        return radiosity.Scene([floor, lamp]), PERPENDICULAR_SQUARES
    # The centred plate of half the size, midway: a smooth four-dimensional integral by Gauss-Legendre.
    lamp = rectangle([0, 0, 1], [0, 1, 0], [1, 0, 0], emission=1.0, name="lamp")
    plate = rectangle([0.25, 0.25, 0.5], [0.5, 0, 0], [0, 0.5, 0], name="plate")
    plate.two_sided = True
    return radiosity.Scene([floor, lamp, plate]), 0.09950629459898


@pytest.mark.parametrize("kind", ["opposite", "touching", "occluded"])
def test_irradiance_from_a_square_lamp(kind: str) -> None:
    scene, factor = two_rectangles(kind)
    solution = radiosity.solve(scene.patches(as_is=True), accuracy=0.002, seed=2)
    irradiance, error = mean_irradiance(solution, "receiver")
    assert error[0] < 0.01 * factor
    assert irradiance[0] == pytest.approx(factor, abs=4 * error[0] + 1e-9)


@pytest.mark.parametrize(("kind", "i", "j"), [("opposite", 0, 1), ("touching", 0, 1)])
def test_form_factors_by_rays(kind: str, i: int, j: int) -> None:
    scene, factor = two_rectangles(kind)
    scene.surfaces[0] = rectangle([0, 0, 0], [1, 0, 0], [0, 1, 0], name="receiver")
    rays = 1 << 16
    F = radiosity.form_factors(scene.patches(as_is=True), rays=rays, seed=1).toarray()
    sigma = math.sqrt(factor * (1 - factor) / (2 * rays))  # plain Monte Carlo from both ends; these points do better
    assert F[i, j] == pytest.approx(factor, abs=4 * sigma)
    assert F[i, j] == pytest.approx(F[j, i], rel=1e-12)  # equal areas


def test_ray_error_falls_faster_than_monte_carlo() -> None:
    scene, factor = two_rectangles("opposite")
    scene.surfaces[0] = rectangle([0, 0, 0], [1, 0, 0], [0, 1, 0], name="receiver")
    patches = scene.patches(as_is=True)

    def rms(rays: int) -> float:
        errors = [
            radiosity.form_factors(patches, rays=rays, seed=seed, threads=1).toarray()[0, 1] - factor
            for seed in range(40)
        ]
        return float(np.sqrt(np.mean(np.square(errors))))

    few, many = 64, 4096
    slope = math.log(rms(few) / rms(many)) / math.log(many / few)
    assert slope > 0.6  # Monte Carlo: 0.5; a discontinuity in four dimensions: 5/8


def test_point_light_over_a_plane() -> None:
    # E = I cos / r^2 at each point; the mean over a square centred below is I times its solid angle over its area.
    h, a = 0.7, 1.0
    light = radiosity.PointLight([0.5, 0.5, h], 3.0)
    floor = rectangle([0, 0, 0], [a, 0, 0], [0, a, 0], name="floor", cells=(8, 8))
    solution = radiosity.solve(radiosity.Scene([floor], [light]).patches(as_is=True), accuracy=0.002)
    irradiance, error = mean_irradiance(solution, "floor")
    solid_angle = 4 * math.asin((a / 2) ** 2 / ((a / 2) ** 2 + h**2))
    assert irradiance[0] == pytest.approx(3.0 * solid_angle / a**2, abs=4 * error[0])
    assert error[0] < 0.01 * irradiance[0]


def test_spot_light_sends_what_its_falloff_says() -> None:
    # Intensity I ((c - co) / (ci - co))^2 between the cosines of the cone; all of it lands on a wide floor.
    inner, outer = 0.3, 0.8
    ci, co = math.cos(inner), math.cos(outer)
    spot = radiosity.SpotLight([0, 0, 1], [0, 0, -1], 5.0, inner, outer)
    floor = rectangle([-2, -2, 0], [4, 0, 0], [0, 4, 0], name="floor", cells=(40, 40))
    solution = radiosity.solve(radiosity.Scene([floor], [spot]).patches(as_is=True), accuracy=0.005)
    flux = 5.0 * 2 * math.pi * ((1 - ci) + (ci - co) / 3)
    received = float(solution.patches.area @ solution.irradiance[:, 0])
    assert received == pytest.approx(flux, rel=0.005)


def test_sun_on_a_tilted_plane_with_a_shadow() -> None:
    down = np.array([1.0, 0.0, -1.0]) / math.sqrt(2)
    sun = radiosity.DirectionalLight(list(down), 10.0)
    floor = rectangle([0, 0, 0], [4, 0, 0], [0, 1, 0], name="floor", cells=(8, 2))
    # A wall of height 1 at x = 1 that faces the sun shades one metre of the floor behind it, to x = 2.
    wall = rectangle([1, 0, 0], [0, 0, 1], [0, 1, 0], name="wall")
    assert np.dot(np.cross([0, 0, 1], [0, 1, 0]), down) < 0
    solution = radiosity.solve(radiosity.Scene([floor, wall], [sun]).patches(as_is=True), accuracy=0.002)
    x = solution.patches.centre[:, 0]
    on_floor = solution.patches.surface == 0
    expected = np.where((x > 1) & (x < 2), 0.0, 10 / math.sqrt(2))[on_floor]
    np.testing.assert_allclose(solution.irradiance[on_floor, 0], expected, atol=1e-6)
    assert solution.irradiance[~on_floor, 0] == pytest.approx(10 / math.sqrt(2))


def test_mean_indirect_irradiance_in_a_closed_room() -> None:
    # With a source of flux Phi and one reflectance in a closed room of surface S: rho Phi / ((1 - rho) S), exactly.
    rho, side = 0.7, 0.2
    faces = [
        ([0, 0, 0], [1, 0, 0], [0, 1, 0]), ([0, 0, 0], [0, 1, 0], [0, 0, 1]), ([0, 0, 0], [0, 0, 1], [1, 0, 0]),
        ([1, 1, 0], [0, 0, 1], [-1, 0, 0]), ([1, 1, 0], [0, -1, 0], [0, 0, 1]), ([0, 0, 1], [0, 1, 0], [1, 0, 0]),
    ]  # fmt: skip
    room = [rectangle(*f, reflectance=rho, name=f"face {k}", cells=(5, 5)) for k, f in enumerate(faces)]
    # The lamp is the middle cell of the ceiling, as reflective as the rest.
    ceiling = room.pop()
    lamp = radiosity.Surface(ceiling.vertices, ceiling.faces[12:13], rho, 100.0, "lamp")
    rest = radiosity.Surface(ceiling.vertices, np.delete(ceiling.faces, 12, axis=0), rho, 0.0, "ceiling")
    scene = radiosity.Scene([*room, rest, lamp])
    solution = radiosity.solve(scene.patches(as_is=True), accuracy=0.005, seed=1)
    flux, surface = 100.0 * side**2, 6.0
    total = float(solution.patches.area @ solution.irradiance[:, 0]) / surface
    # All irradiance: what arrives first, Phi / S, and the indirect part.
    assert total - flux / surface == pytest.approx(rho * flux / ((1 - rho) * surface), rel=0.005)
    assert solution.report.escape_share == 0
    assert abs(solution.report.imbalance) < 0.003


def test_a_box_of_light_in_the_middle_of_a_black_room_sends_all_its_power() -> None:
    # Coordinates are finest in the middle, where the lamp is, and coarsest at the walls, where rays to it start.
    from itertools import product  # noqa: PLC0415

    surfaces = []
    for half, inward, emission, cells in ((2.0, True, 0.0, 6), (0.3, False, 250.0, 2)):
        for axis, sign in product(range(3), (-1.0, 1.0)):
            n = np.zeros(3)
            n[axis] = -sign if inward else sign
            u = np.roll([1.0, 0.0, 0.0], axis + 1) * 2 * half
            v = np.cross(n, u)
            origin = sign * half * np.roll([1.0, 0.0, 0.0], axis) - 0.5 * (u + v)
            surfaces.append(rectangle(origin, u, v, 0.0, emission, f"{half} {axis} {sign}", (cells, cells)))
    solution = radiosity.solve(radiosity.Scene(surfaces).patches(as_is=True), accuracy=0.01, seed=1)
    walls = np.arange(len(surfaces))[solution.patches.surface] < 6
    received = float(solution.patches.area[walls] @ solution.irradiance[walls, 0])
    assert received == pytest.approx(250.0 * 6 * 0.6**2, rel=0.003)


def test_the_answer_does_not_depend_on_the_unit_of_length() -> None:
    results = []
    for scale in (1e-3, 1.0, 1e4):
        scene, _ = two_rectangles("touching")
        for s in scene.surfaces:
            s.vertices = scale * np.asarray(s.vertices) + 7 * scale
        results.append(radiosity.solve(scene.patches(as_is=True), accuracy=0.01, seed=3).irradiance)
    np.testing.assert_allclose(results[0], results[1], rtol=0.02, atol=1e-3)
    np.testing.assert_allclose(results[2], results[1], rtol=0.02, atol=1e-3)
