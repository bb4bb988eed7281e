"""Diffuse transmission in the transport of light, against the furnace, closed forms and path tracing."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import radiosity
from radiosity import PointLight, Scene, Surface
from radiosity.picture import render

Floats = npt.NDArray[np.float64]

QUAD = np.array([[0, 1, 2, 3]])


def quad(corner: Any, u: Any, v: Any, **optics: Any) -> Surface:
    """A parallelogram that looks along u x v."""
    c, u, v = (np.asarray(x, dtype=float) for x in (corner, u, v))
    return Surface(np.array([c, c + u, c + u + v, c + v]), QUAD, **{"reflectance": 0.0, **optics})


def box(size: tuple[float, float, float], corner: Any = (0, 0, 0), **walls: dict[str, Any]) -> list[Surface]:
    """The inside of a box from a corner; of walls named x0, x1, y0 ... the optics."""
    x, y, z = np.diag(np.asarray(size, dtype=float))
    o = np.asarray(corner, dtype=float)
    faces = {
        "x0": (o, y, z), "x1": (o + x, z, y), "y0": (o, z, x), "y1": (o + y, x, z), "z0": (o, x, y),
        "z1": (o + z, y, x),
    }  # fmt: skip
    return [quad(*faces[name], name=name, **optics) for name, optics in walls.items()]


def all_walls(**optics: Any) -> dict[str, dict[str, Any]]:
    return dict.fromkeys(("x0", "x1", "y0", "y1", "z0", "z1"), optics)


def of(solution: radiosity.Solution, name: str) -> npt.NDArray[np.bool_]:
    """Which patches are of a surface."""
    names = np.array([s.name for s in solution.patches.scene.surfaces])
    return names[solution.patches.surface] == name


def mean(values: Floats, patches: radiosity.Patches, chosen: npt.NDArray[np.bool_]) -> float:
    """Mean over area and bands."""
    return float(np.average(values[chosen].mean(axis=1), weights=patches.area[chosen]))


def assert_balanced(solution: radiosity.Solution, within: float) -> None:
    r = solution.report
    out = np.sum([r.absorbed, r.escaped, r.lost_on_backs], axis=0)
    assert np.abs(out / np.add(r.emitted, r.from_lights) - 1).max() < within
    assert abs(r.imbalance) < within


@pytest.mark.parametrize(("rho", "tau"), [(0.5, 0.3), (0.3, 0.5), (0.1, 0.7), (0.0, 0.8)])
def test_furnaces_stay_even_with_sheets(rho: float, tau: float) -> None:
    # All send back 0.8 of what meets them, by one way or the other: B = E / (1 - 0.8).
    walls = all_walls(reflectance=0.8, emission=1.0)
    sheets: dict[str, Any] = {"reflectance": rho, "diffuse_transmittance": tau, "emission": 1.0}
    surfaces = [
        *box((1, 1.5, 1.2), **walls),
        quad((0, 0.6, 0), (0, 0, 1.2), (1, 0, 0), name="partition", **sheets),
        quad((0.3, 0.9, 0.4), (0.4, 0, 0.1), (0, 0.3, 0), name="leaf", **sheets),
    ]
    solution = radiosity.solve(Scene(surfaces).patches(max_edge=0.3), accuracy=0.002, closure="exact")
    np.testing.assert_allclose(solution.radiosity, 5.0, rtol=1e-4)
    backs = solution.patches.two_sided
    assert backs.sum() > 10
    np.testing.assert_allclose(solution.back_radiosity[backs], 5.0, rtol=1e-4)
    assert_balanced(solution, 1e-3)


@pytest.mark.parametrize(("rho", "tau"), [(0.3, 0.4), (0.0, 0.9), (0.1, [0.2, 0.4, 0.8])])
def test_a_sheet_between_infinite_plates_has_its_closed_form(rho: float, tau: Any) -> None:
    # Side walls are ideal mirrors, so that the plates have no end, and what leaves one plate arrives on the next.
    mirrors = {name: {"specular": 1.0} for name in ("x0", "x1", "y0", "y1")}
    plates = {"z0": {"reflectance": 0.2, "emission": 1.0}, "z1": {"reflectance": 0.5}}
    sheet = quad((0, 0, 0.5), (1, 0, 0), (0, 1, 0), name="sheet", reflectance=rho, diffuse_transmittance=tau)
    solution = radiosity.solve(
        Scene([*box((1, 1, 1), **mirrors, **plates), sheet]).patches(max_edge=0.25), accuracy=0.003, closure="exact"
    )
    # Radiosities of floor, underside and upper side of the sheet, and ceiling; each is the irradiance of its opposite.
    for band, t in enumerate(np.atleast_1d(tau)):
        bounce = np.array([[0, 0.2, 0, 0], [rho, 0, 0, t], [t, 0, 0, rho], [0, 0, 0.5, 0]])
        floor, underside, upper, ceiling = np.linalg.solve(np.eye(4) - bounce, [1.0, 0, 0, 0])
        sheets = of(solution, "sheet")
        for values, wanted in (
            (solution.radiosity[of(solution, "z0")], floor), (solution.back_radiosity[sheets], underside),
            (solution.radiosity[sheets], upper), (solution.radiosity[of(solution, "z1")], ceiling),
        ):  # fmt: skip
            # Patches are of one size.
            assert values[:, band].mean() == pytest.approx(wanted, rel=2e-3)
            np.testing.assert_allclose(values[:, band], wanted, rtol=0.02)
    assert_balanced(solution, 1e-3)


def two_rooms(tau: Any, rho: float = 0.2) -> Scene:
    """A lamp and a light in the one room, and a door of paper to the other; a box stands before it there."""
    walls = all_walls(reflectance=[0.6, 0.5, 0.4])
    surfaces = [
        *box((2, 1, 1), **walls),
        quad((1, 0, 0), (0, 1, 0), (0, 0, 1), name="paper", reflectance=rho, diffuse_transmittance=tau),
        quad((0.3, 0.3, 0.99), (0, 0.3, 0), (0.3, 0, 0), name="lamp", emission=[9.0, 8.0, 6.0]),
        quad((1.2, 0.2, 0.3), (0, 0.3, 0), (0.3, 0, 0.2), name="leaf", reflectance=0.1,
             diffuse_transmittance=[0.1, 0.4, 0.05]),
    ]  # fmt: skip
    return Scene(surfaces, [PointLight((0.5, 0.8, 0.3), [0.3, 0.3, 0.3])])


@pytest.mark.parametrize("tau", [0.6, [0.2, 0.4, 0.1]])
def test_light_gets_into_the_next_room_as_paths_find_it(tau: Any) -> None:
    patches = two_rooms(tau).patches(max_edge=0.2)
    solution = radiosity.solve(patches, accuracy=0.01, seed=5)
    assert_balanced(solution, 0.01)
    found = radiosity.path_irradiance(patches, samples=2048, seed=6)
    assert found.back_irradiance is not None and found.back_error is not None
    area = patches.area[:, None]
    sides = [
        (solution.irradiance, found.irradiance, found.error),
        (solution.back_irradiance, found.back_irradiance, found.back_error),
    ]
    for k, surface in enumerate(patches.scene.surfaces):
        for side, (one, other, noise) in enumerate(sides[: 1 + surface.two_sided]):
            own = patches.surface == k
            # Bands share their paths.
            error = np.sqrt(((area * noise)[own].sum(axis=1) ** 2).sum())
            off, total = (area * (one - other))[own].sum(axis=0), (area * other)[own].sum(axis=0)
            assert (np.abs(off) < 4 * error + 0.015 * total).all(), (surface.name, side)
    # What the paper takes on both sides and what both rooms take is all that shines; half of it gets through at most.
    behind = (patches.centre[:, 0] > 1) & ~patches.two_sided
    assert 0.01 < mean(solution.irradiance, patches, behind) / mean(solution.irradiance, patches, ~behind) < 1


def test_what_passes_into_a_solid_is_lost_there() -> None:
    # A crate stands on a shelf of glassy plastic, not quite along its patches. Light from below ends in it.
    crate = [
        quad(c, u, v, name=f"crate {k}", reflectance=0.5)
        for k, (c, u, v) in enumerate([
            ((0.33, 0.37, 0.8), (0.31, 0, 0), (0, 0.29, 0)), ((0.33, 0.37, 0.5), (0.31, 0, 0), (0, 0, 0.3)),
            ((0.64, 0.37, 0.5), (0, 0.29, 0), (0, 0, 0.3)), ((0.64, 0.66, 0.5), (-0.31, 0, 0), (0, 0, 0.3)),
            ((0.33, 0.66, 0.5), (0, -0.29, 0), (0, 0, 0.3)),
        ])
    ]  # fmt: skip
    room = box((1, 1, 1), **{**all_walls(reflectance=0.3), "z0": {"reflectance": 0.2, "emission": 1.0}})
    shelf = quad((0, 0, 0.5), (1, 0, 0), (0, 1, 0), name="shelf", reflectance=0.1, diffuse_transmittance=0.7)
    patches = Scene([*room, *crate, shelf]).patches(max_edge=0.25, contacts=False)
    solution = radiosity.solve(patches, accuracy=0.005, seed=3)
    assert_balanced(solution, 0.01)
    # What arrives below the crate, on the four patches in the middle, and passes.
    under = of(solution, "shelf") & (np.abs(patches.centre[:, :2] - 0.5) < 0.25).all(axis=1)
    passed = 0.7 * solution.back_irradiance[under, 0].mean() * 0.31 * 0.29
    assert under.sum() == 4
    assert solution.report.lost_on_backs[0] == pytest.approx(passed, rel=0.05)


def test_errors_that_are_told_hold() -> None:
    # Means of patches against a far more accurate solution of the same.
    patches = two_rooms(0.6).patches(max_edge=0.25)
    truth = radiosity.solve(patches, accuracy=0.001, seed=1)
    for seed in (2, 3):
        rough = radiosity.solve(patches, accuracy=0.02, seed=seed)
        sides = [(rough.irradiance, truth.irradiance, patches.area)]
        sides += [(rough.back_irradiance[patches.two_sided], truth.back_irradiance[patches.two_sided],
                   patches.area[patches.two_sided])]  # fmt: skip
        difference, level, weight = (np.concatenate(v) for v in zip(*[(a - b, b, w) for a, b, w in sides], strict=True))
        rms = np.sqrt(np.average((difference**2).mean(axis=1), weights=weight))
        assert rms / np.average(level.mean(axis=1), weights=weight) < rough.report.estimated_error


def test_a_mesh_of_the_engines_own_is_as_accurate_as_asked() -> None:
    solution = radiosity.solve(two_rooms(0.6), accuracy=0.03, seed=2)
    assert solution.report.reached
    assert_balanced(solution, 0.02)
    middles = [(1.6, 0.5, 0.0), (0.5, 0.7, 0.0)]
    truth = radiosity.path_irradiance(two_rooms(0.6), middles, (0, 0, 1), samples=1 << 15)
    field = solution.irradiance_at(middles, (0, 0, 1))
    np.testing.assert_allclose(field, truth.irradiance, rtol=0.06)


def lamp_with_shade() -> Scene:
    """A bulb of an eighth of a metre within four sides of paper, on a table by a wall."""
    bulb = [
        quad(c, u, v, name=f"bulb {k}", emission=[40.0, 32.0, 20.0])
        for k, (c, u, v) in enumerate([
            ((-0.05, -0.05, 0.25), (0.1, 0, 0), (0, 0, 0.1)), ((0.05, -0.05, 0.25), (0, 0.1, 0), (0, 0, 0.1)),
            ((0.05, 0.05, 0.25), (-0.1, 0, 0), (0, 0, 0.1)), ((-0.05, 0.05, 0.25), (0, -0.1, 0), (0, 0, 0.1)),
        ])
    ]  # fmt: skip
    paper: dict[str, Any] = {"reflectance": [0.35, 0.3, 0.2], "diffuse_transmittance": [0.5, 0.42, 0.3]}
    ring = 0.2 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    shade = [
        quad((*ring[k], 0.15), (*(ring[(k + 1) % 4] - ring[k]), 0), (0, 0, 0.3), name=f"shade {k}", **paper)
        for k in range(4)
    ]
    table = quad((-0.8, -0.8, 0), (1.6, 0, 0), (0, 1.6, 0), name="table", reflectance=[0.4, 0.3, 0.2])
    wall = quad((-0.8, 0.8, 0), (1.6, 0, 0), (0, 0, 1.2), name="wall", reflectance=[0.7, 0.7, 0.65])
    return Scene([*bulb, *shade, table, wall])


def test_a_gathered_picture_of_a_lampshade_is_what_paths_see() -> None:
    scene = lamp_with_shade()
    eye, size = radiosity.Camera.look_at((0.5, -1.1, 0.65), (0, 0.15, 0.25), (0, 0, 1)), {"width": 80, "height": 60}
    solution = radiosity.solve(scene.patches(max_edge=0.05), accuracy=0.01, seed=7)
    truth = radiosity.path_trace(scene, eye, samples=2048, seed=8, **size)
    picture = render(solution, eye, mode="gather", samples=256, **size)  # type: ignore[arg-type]
    # Within surfaces: edges are where pixels are drawn from other points.
    brightness = np.where(truth.image[..., 0] > 0, truth.image.mean(axis=2), np.nan)
    steps = np.stack([np.roll(brightness, s, axis=a) for a in (0, 1) for s in (-1, 1)])
    inner = (np.abs(steps / brightness - 1) < 0.25).all(axis=0)
    assert inner.mean() > 0.3
    level = truth.image[inner].mean()
    off, noise = (picture - truth.image)[inner] / level, truth.standard_error[inner] / level
    # What looks at the bulb is hidden from it by the shade but for few, so that the gather has noise of its own.
    assert np.sqrt(max(np.mean(off**2) - np.mean(noise**2), 0)) < 0.05
    assert abs(off.mean()) < 0.01
    # The shade is dark on the outside but for what passes: all is behind it.
    assert np.nanmax(brightness) > 10 * np.nanmedian(brightness)
