"""A cube with a point light in its middle: the mean in closed form, edges and corners by their limits.

All walls reflect rho. So a W that lands somewhere lands rho as often again, and the mean irradiance of the whole is
Phi / (S (1 - rho)), exactly.

Near an edge half of what a point sees, cosine-weighted, is the other wall near the edge, and near a corner three
quarters are the other two walls near the corner. All walls are alike there, so irradiance tends to
H = far + near rho H, where "far" is what the rest of the view brings: the light, and walls farther away. That is a
smooth integral over the directions that lead away from the edge or corner, taken here by thousands of rays.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import qmc

import radiosity

RHO, POWER, SIDE = 0.8, 100.0, 2.0


def cube() -> radiosity.Scene:
    """Corners 0 and 2 of each face are opposite; all look inward."""
    faces = [
        ("floor", [0, 0, 0], [1, 0, 0], [0, 1, 0]),
        ("ceiling", [0, 0, 1], [0, 1, 0], [1, 0, 0]),
        ("left", [0, 0, 0], [0, 1, 0], [0, 0, 1]),
        ("right", [1, 0, 0], [0, 0, 1], [0, 1, 0]),
        ("front", [0, 0, 0], [0, 0, 1], [1, 0, 0]),
        ("back", [0, 1, 0], [1, 0, 0], [0, 0, 1]),
    ]
    surfaces = []
    for name, *shape in faces:
        corner, u, v = SIDE * np.array(shape, dtype=float)
        surfaces.append(
            radiosity.Surface([corner, corner + u, corner + u + v, corner + v], [[0, 1, 2, 3]], RHO, 0, name)
        )
    light = radiosity.PointLight([SIDE / 2] * 3, POWER / (4 * np.pi))
    return radiosity.Scene(surfaces, lights=[light], name="cube")


def direct(point: np.ndarray) -> float:
    """Irradiance of the floor straight from the light."""
    to = np.full(3, SIDE / 2) - point
    return float(POWER / (4 * np.pi) * to[2] / np.linalg.norm(to) ** 3)


def far(solution: radiosity.Solution, point: np.ndarray, away: tuple[bool, bool]) -> float:
    """What arrives at a point of the floor from directions that lead away from the walls x = 0 and y = 0."""
    u, v = qmc.Sobol(2, seed=1).random(2**13).T
    radius, angle = np.sqrt(u), 2 * np.pi * v
    d = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1 - u)])
    leads_away = (~np.array(away[0]) | (d[:, 0] > 0)) & (~np.array(away[1]) | (d[:, 1] > 0))
    d = d[leads_away]
    with np.errstate(divide="ignore"):
        length = np.min(np.where(d > 0, (SIDE - point) / d, np.where(d < 0, -point / d, np.inf)), axis=1)
    hit = point + length[:, None] * d
    # The wall that was hit: the coordinate that is nearest to 0 or to the side.
    distance = np.concatenate([np.abs(hit), np.abs(hit - SIDE)], axis=1)
    wall = np.argmin(distance, axis=1)
    normal = np.where(wall[:, None] % 3 == np.arange(3), np.where(wall < 3, 1.0, -1.0)[:, None], 0.0)
    field = solution.irradiance_at(hit, normal)[:, 0]
    assert np.isfinite(field).mean() > 0.99
    return direct(point) + RHO * float(np.nansum(field)) / len(u)


def at_like_places(solution: radiosity.Solution, middles: int) -> tuple[float, float]:
    """Mean irradiance at all corners of faces, or all middles of edges, which are alike.

    Of the field, and of the patches there.
    """
    patches = solution.patches
    off = np.abs(patches.polygons - SIDE / 2) / (SIDE / 2)
    at = (np.isclose(off, 1).sum(axis=2) == 3 - middles) & (np.isclose(off, 0).sum(axis=2) == middles)
    patch, _ = np.nonzero(at)
    assert len(patch) >= 24
    return float(solution.corner_irradiance[at].mean()), float(solution.irradiance[patch].mean())


def test_the_mean_is_exact_on_a_mesh_of_its_own() -> None:
    exact = POWER / (6 * SIDE**2 * (1 - RHO))
    solution = radiosity.solve(cube(), accuracy=0.01, seed=2)
    mean = np.average(solution.irradiance[:, 0], weights=solution.patches.area)
    # Far below the accuracy asked for: noise of patches averages out, and power is balanced.
    assert mean == pytest.approx(exact, rel=1e-3)
    assert solution.report.reached


def test_edges_and_corners_tend_to_their_limits() -> None:
    errors: dict[int, list[tuple[float, float]]] = {0: [], 1: []}
    solutions = [radiosity.solve(cube().patches(max_edge=SIDE / n), accuracy=0.01, seed=n) for n in (8, 16, 32)]
    limits = {
        1: far(solutions[-1], np.array([0, SIDE / 2, 0]), (True, False)) / (1 - RHO / 2),
        0: far(solutions[-1], np.zeros(3), (True, True)) / (1 - RHO * 3 / 4),
    }
    for solution in solutions:
        for middles, limit in limits.items():
            field, patch = at_like_places(solution, middles)
            errors[middles].append((field / limit - 1, patch / limit - 1))
    for middles, of in errors.items():
        field, patch = np.array(of).T
        # Light rises from a corner like a small power of the distance, so that this takes its time.
        assert np.all(field[1:] < 0.85 * field[:-1]), (middles, field)
        assert np.all(np.abs(field) < 0.8 * patch), (middles, field, patch)
        assert abs(field[-1]) < (0.06, 0.02)[middles], (middles, field)
