"""Mirrors and clear glass in the transport of light, against images, symmetry, the furnace and closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import radiosity
from radiosity import DirectionalLight, PointLight, Scene, SpotLight, Surface

Floats = npt.NDArray[np.float64]

QUAD = np.array([[0, 1, 2, 3]])


def quad(corner: Any, u: Any, v: Any, **optics: Any) -> Surface:
    """A parallelogram that looks along u x v."""
    c, u, v = (np.asarray(x, dtype=float) for x in (corner, u, v))
    return Surface(np.array([c, c + u, c + u + v, c + v]), QUAD, **{"reflectance": 0.0, **optics})


def box(size: tuple[float, float, float], **walls: dict[str, Any]) -> list[Surface]:
    """The inside of a box from the origin; of walls named x0, x1, y0 ... the optics."""
    x, y, z = np.diag(np.asarray(size, dtype=float))
    o = np.zeros(3)
    faces = {"x0": (o, y, z), "x1": (x, z, y), "y0": (o, z, x), "y1": (y, x, z), "z0": (o, x, y), "z1": (z, y, x)}
    return [quad(*faces[name], name=name, **optics) for name, optics in walls.items()]


def solved(surfaces: list[Surface], lights: Any = (), *, accuracy: float = 0.005, edge: float = 0.25, **options: Any):
    patches = Scene(surfaces, lights=list(lights)).patches(max_edge=edge)
    return radiosity.solve(patches, accuracy=accuracy, **options)


def of(solution: radiosity.Solution, name: str) -> npt.NDArray[np.bool_]:
    """Which patches are of a surface."""
    names = np.array([s.name for s in solution.patches.scene.surfaces])
    return names[solution.patches.surface] == name


def mean(solution: radiosity.Solution, name: str) -> float:
    """Irradiance of a surface, mean over it and bands."""
    chosen = of(solution, name)
    return float(np.average(solution.irradiance[chosen].mean(axis=1), weights=solution.patches.area[chosen]))


def assert_balanced(solution: radiosity.Solution, within: float) -> None:
    r = solution.report
    out = np.sum([r.absorbed, r.escaped, r.lost_on_backs, r.unfollowed or np.zeros(len(r.bands))], axis=0)
    into = np.add(r.emitted, r.from_lights)
    assert np.abs(out / into - 1).max() < within
    assert abs(r.imbalance) < within


def on_factors(surfaces: list[Surface], name: str, obstructions: Any = (), edge: float = 0.25) -> Floats:
    """(k, bands) irradiance of a surface by form factors pair by pair, to 1e-6."""
    patches = Scene(surfaces, obstructions=list(obstructions)).patches(max_edge=edge)
    solution = radiosity.solve(patches, transport=radiosity.form_factors(patches), closure="exact")
    return solution.irradiance[of(solution, name)]


RECEIVER = quad((-1, 0, 0), (0.5, 0, 0), (0, 0.5, 0), name="receiver")


@pytest.mark.parametrize("specular", [1.0, 0.6])
def test_a_lamp_seen_in_a_mirror_only_is_its_image(specular: float) -> None:
    # The lamp looks up, away from the receiver; its image at twice the height of the mirror looks down.
    lamp = quad((1, 0, 1), (0.5, 0, 0), (0, 0.5, 0), emission=10.0, name="lamp")
    mirror = quad((-2, -2, 2), (0, 5, 0), (5, 0, 0), specular=specular, name="mirror")
    image = quad((1, 0, 3), (0, 0.5, 0), (0.5, 0, 0), emission=10.0, name="lamp")
    seen = solved([RECEIVER, lamp, mirror], accuracy=0.002)
    wanted = specular * on_factors([RECEIVER, image], "receiver")
    np.testing.assert_allclose(seen.irradiance[of(seen, "receiver")], wanted, rtol=3e-3)
    # Most of the power of the lamp leaves the scene by rays, whose number goes by the noise on receivers.
    assert_balanced(seen, 0.02)


@pytest.mark.parametrize("emission", [10.0, 0.2])
def test_a_mirror_of_finite_size_is_a_hole_to_the_image(emission: float) -> None:
    # The doubled scene has a wall with a hole where the mirror is. With little emission beside that of the wall above,
    # the lamp is found by rays, otherwise by area.
    sky = quad((-1, -1, 3), (0, 2, 0), (1.8, 0, 0), emission=0.2, name="sky")  # up to the plane of the mirror
    lamp = quad((-0.25, -0.25, 1), (0, 0.5, 0), (0.5, 0, 0), emission=emission, name="lamp")
    receiver = quad((-0.5, -0.5, 0), (1, 0, 0), (0, 1, 0), name="receiver")
    mirror = quad((0.8, -0.3, 0.2), (0, 0, 0.5), (0, 0.6, 0), specular=0.9, name="mirror")
    seen = solved([sky, lamp, receiver, mirror], accuracy=0.003)
    straight = solved([sky, lamp, receiver, Surface(mirror.vertices, QUAD, 0.0, name="mirror")], accuracy=0.003)
    # What the mirror adds is what comes through the hole from beyond.
    beyond = [
        Surface((np.asarray(s.vertices) * (-1, 1, 1) + (1.6, 0, 0))[::-1], QUAD, 0.0, s.emission, f"beyond {s.name}")
        for s in (sky, lamp)
    ]
    wall = [
        quad((0.8, -9, -9), (0, 8.7, 0), (0, 0, 18), name="wall 1"),
        quad((0.8, 0.3, -9), (0, 8.7, 0), (0, 0, 18), name="wall 2"),
        quad((0.8, -0.3, -9), (0, 0.6, 0), (0, 0, 9.2), name="wall 3"),
        quad((0.8, -0.3, 0.7), (0, 0.6, 0), (0, 0, 8.3), name="wall 4"),
    ]
    added = 0.9 * on_factors([receiver, *beyond], "receiver", wall)
    difference = seen.irradiance[of(seen, "receiver")] - straight.irradiance[of(straight, "receiver")]
    level = straight.irradiance[of(straight, "receiver")].mean()
    np.testing.assert_allclose(difference, added, atol=0.01 * level)
    assert np.mean(difference) == pytest.approx(added.mean(), rel=0.05)


def room_with_lamp(mirror: dict[str, Any]) -> list[Surface]:
    paint: dict[str, Any] = {"x1": [0.7, 0.2, 0.5], "y0": 0.6, "y1": [0.3, 0.6, 0.3], "z0": 0.4, "z1": 0.8}
    walls = {"x0": mirror, **{name: {"reflectance": rho} for name, rho in paint.items()}}
    lamp = quad((0.3, 0.3, 1.15), (0, 0.4, 0), (0.4, 0, 0), emission=[12.0, 10.0, 6.0], name="lamp")
    return [*box((1.0, 1.5, 1.2), **walls), lamp]


def doubled(surfaces: list[Surface]) -> list[Surface]:
    """The surfaces and their images in the plane x = 0."""
    images = [
        Surface((np.asarray(s.vertices) * (-1, 1, 1))[::-1], QUAD, s.reflectance, s.emission, f"{s.name} image")
        for s in surfaces
    ]
    return [*surfaces, *images]


def test_a_room_with_a_perfect_mirror_for_a_wall_is_half_of_the_doubled_room() -> None:
    room = room_with_lamp({"specular": 1.0})
    half = solved(room, accuracy=0.004)
    whole = solved(doubled(room[1:]), accuracy=0.004, seed=5)
    mine, theirs = half.patches.centre, whole.patches.centre
    pairs = [(i, int(np.argmin(np.linalg.norm(theirs - mine[i], axis=1)))) for i in np.flatnonzero(~of(half, "x0"))]
    i, j = np.array(pairs).T
    assert np.linalg.norm(theirs[j] - mine[i], axis=1).max() < 1e-9
    area = half.patches.area[i, None]
    difference = half.irradiance[i] - whole.irradiance[j]
    rms = np.sqrt(np.average(difference**2, weights=np.broadcast_to(area, difference.shape)))
    rms /= np.average(half.irradiance[i], weights=np.broadcast_to(area, difference.shape))
    # Both estimates are upper ends of intervals.
    assert rms < np.hypot(half.report.estimated_error, whole.report.estimated_error)
    assert_balanced(half, 0.003)
    assert half.report.absorbed_by_mirrors == [0.0, 0.0, 0.0]


def test_a_mesh_of_the_engines_own_follows_mirrors() -> None:
    room = room_with_lamp({"specular": 1.0})
    half = radiosity.solve(Scene(room), accuracy=0.02)
    whole = radiosity.solve(Scene(doubled(room[1:])), accuracy=0.02)
    for name in ("x1", "y0", "y1", "z0", "z1"):
        assert mean(half, name) == pytest.approx(mean(whole, name), rel=0.02)
    assert half.report.reached


@pytest.mark.parametrize(
    "mirrors",
    [
        {"x0": {"specular": 1.0}},
        {"x0": {"specular": 1.0}, "x1": {"specular": 1.0}},
        {"x0": {"specular": 1.0}, "y0": {"specular": 1.0}, "z0": {"specular": 1.0}},
        # All that meets these goes on, is reflected diffusely, or is made good by emission.
        {"x0": {"specular": 0.5, "reflectance": 0.2, "emission": 0.3}},
        {"x0": {"specular": 0.9, "emission": 0.1}, "y1": {"specular": 0.9, "emission": 0.1}},
    ],
)
def test_furnaces_stay_even_with_mirrors(mirrors: dict[str, Any]) -> None:
    rho, exitance = 0.6, 2.0
    plain = {"reflectance": rho, "emission": exitance}
    # A mirror sends as much as any wall if E = (1 - rho - specular) times that.
    full = exitance / (1 - rho)
    scaled = {name: {**m, "emission": full * m.get("emission", 0.0)} for name, m in mirrors.items()}
    walls = {name: scaled.get(name, plain) for name in ("x0", "x1", "y0", "y1", "z0", "z1")}
    solution = solved(box((1, 1.5, 1.2), **walls), accuracy=0.002, closure="exact")
    is_plain = ~np.any([of(solution, name) for name in mirrors], axis=0)
    np.testing.assert_allclose(solution.radiosity[is_plain], full, rtol=1e-4)
    np.testing.assert_allclose(solution.irradiance, full, rtol=1e-4)
    assert_balanced(solution, 1e-3)


def test_panes_and_mirrors_exchange_reciprocally() -> None:
    a = quad((0, 0, 0), (1, 0, 0), (0, 1, 0), emission=1.0, name="a")
    b = quad((2, 0, 1.5), (0, 1, 0), (0.7, 0, 0), emission=1.0, name="b")
    pane = quad((1.4, -1, -1), (0, 3.5, 0), (0, 0, 3.5), specular=0.25, transmittance=0.5, two_sided=True, name="pane")
    mirror = quad((-1, 2, -1), (4, 0, 0), (0, 0, 4), specular=0.8, name="mirror")
    both = solved([a, b, pane, mirror], accuracy=0.003, edge=0.5)
    dark = np.zeros((len(both.patches), 1))
    sent = []
    for source, target in (("a", "b"), ("b", "a")):
        lit = both.relight(emission=np.where(of(both, source)[:, None], 1.0, dark))
        chosen = of(lit, target)
        sent.append(float(lit.patches.area[chosen] @ lit.irradiance[chosen, 0]))
    assert sent[0] == pytest.approx(sent[1], rel=5e-3)
    assert sent[0] > 0.005


def inverse_square(points: Floats, light: Any, up: Any = (0, 0, 1)) -> Floats:
    """Irradiance of points that look up, per W/sr."""
    r = np.asarray(light) - points
    return np.maximum(r @ np.asarray(up), 0) / np.linalg.norm(r, axis=1) ** 3


def over(patches: radiosity.Patches, chosen: npt.NDArray[np.bool_], value: Any, n: int = 8) -> Floats:
    """The mean of a function of points over rectangular patches, by Gauss points."""
    x, w = np.polynomial.legendre.leggauss(n)
    s, t = np.meshgrid((x + 1) / 2, (x + 1) / 2)
    weights = np.outer(w, w).ravel() / 4
    a, b, _, d = np.moveaxis(patches.polygons[chosen], 1, 0)
    points = a[:, None] + s.ravel()[:, None] * (b - a)[:, None] + t.ravel()[:, None] * (d - a)[:, None]
    return np.array([weights @ value(p) for p in points])


FLOOR = quad((0, 0, 0), (1, 0, 0), (0, 1, 0), name="floor")


def test_a_point_light_is_seen_in_a_mirror() -> None:
    mirror = quad((0, -2, 0), (0, 5, 0), (0, 0, 5), specular=0.75, name="mirror")  # looks along x
    light = (0.4, 0.3, 0.8)
    solution = solved([FLOOR, mirror], [PointLight(light, 5.0)], accuracy=0.002)
    image = (-0.4, 0.3, 0.8)
    chosen = of(solution, "floor")
    wanted = over(solution.patches, chosen, lambda p: 5 * (inverse_square(p, light) + 0.75 * inverse_square(p, image)))
    np.testing.assert_allclose(solution.irradiance[chosen, 0], wanted, rtol=4e-3)
    assert solution.report.unfollowed == [0.0]
    # A mirror takes what it neither reflects nor lets through.
    at = mean(solution, "mirror") * 25
    assert solution.report.absorbed_by_mirrors[0] == pytest.approx(0.25 * at, rel=1e-6)
    assert_balanced(solution, 1e-6)


def test_spots_and_parallel_light_are_seen_in_mirrors() -> None:
    mirror = quad((0, -2, 0), (0, 5, 0), (0, 0, 5), specular=0.75, name="mirror")
    down = np.array([-0.6, 0.0, -0.8])
    parallel = solved([FLOOR, mirror], [DirectionalLight(down, 2.0)], accuracy=0.002)
    # The sun in the mirror shines along (0.6, 0, -0.8), and reaches all of the floor as the mirror is high.
    np.testing.assert_allclose(parallel.irradiance[of(parallel, "floor")], 2 * 0.8 * 1.75, rtol=2e-3)
    # A spot that points at the mirror, and away from the floor.
    spot = SpotLight((0.5, 0.5, 1.0), (-1, 0, 0), 3.0, inner_angle=1.0, outer_angle=1.001)
    lit = solved([FLOOR, mirror], [spot], accuracy=0.004, edge=0.125)
    image = np.array((-0.5, 0.5, 1.0))

    def seen(p: Floats) -> Floats:
        towards = (p - image) / np.linalg.norm(p - image, axis=1)[:, None]
        return np.where(towards[:, 0] > np.cos(1.0005), 0.75 * 3 * inverse_square(p, image), 0.0)

    chosen = of(lit, "floor")
    wanted = over(lit.patches, chosen, seen, 24)
    whole = lambda v: np.average(v, weights=lit.patches.area[chosen])  # noqa: E731
    direct = over(
        lit.patches, chosen,
        lambda p: np.where((0.5 - p[:, 0]) / np.linalg.norm(p - (0.5, 0.5, 1.0), axis=1) > np.cos(1.0005),
                           3 * inverse_square(p, (0.5, 0.5, 1.0)), 0.0), 24)  # fmt: skip
    assert whole(lit.irradiance[chosen, 0]) == pytest.approx(whole(wanted + direct), rel=0.01)
    assert whole(wanted) > 0.1


def rows_of_images(x: float, width: float, specular: float, most: int) -> list[tuple[float, float]]:
    """Where a thing between mirrors at 0 and ``width`` seems to be, and what is left of it there."""
    found = [(x, 1.0)]
    for n in range(1, most + 1):
        # n reflections, the last at either mirror.
        shift = width * (n // 2) * 2
        ends = [shift + x, -shift + x] if n % 2 == 0 else [-shift - x, shift + 2 * width - x]
        found += [(e, specular**n) for e in ends]
    return found


FACING = [
    quad((0, -2, 0), (0, 5, 0), (0, 0, 5), name="left"),
    quad((1, -2, 0), (0, 0, 5), (0, 5, 0), name="right"),
]


def facing(specular: float) -> list[Surface]:
    return [Surface(s.vertices, QUAD, 0.0, name=s.name, specular=specular) for s in FACING]


@pytest.mark.parametrize("specular", [0.9, 1.0])
def test_a_point_light_between_facing_mirrors_has_no_end_of_images(specular: float) -> None:
    solution = solved([FLOOR, *facing(specular)], [PointLight((0.3, 0.5, 0.6), 2.0)], accuracy=0.003)
    chosen = of(solution, "floor")
    images = rows_of_images(0.3, 1.0, specular, 400)

    def seen(p: Floats) -> Floats:
        return sum((2 * left * inverse_square(p, (x, 0.5, 0.6)) for x, left in images), np.zeros(len(p)))

    wanted = over(solution.patches, chosen, seen)
    error = solution.irradiance[chosen, 0] / wanted - 1
    assert np.sqrt(np.mean(error**2)) < max(solution.report.estimated_error, 0.005)
    assert np.sqrt(np.mean(error**2)) < 0.01


@pytest.mark.parametrize("specular", [0.5, 0.95])
def test_a_lamp_between_facing_mirrors_counts_by_images_and_by_rays_once_each(specular: float) -> None:
    lamp = quad((0.3, 0.4, 0.6), (0, 0.2, 0), (0.2, 0, 0), emission=20.0, name="lamp")
    solution = solved([FLOOR, *facing(specular), lamp], accuracy=0.005)
    assert solution.report.luminaires == 1
    row = [
        quad((x - 0.1, 0.4, 0.6), (0, 0.2, 0), (0.2, 0, 0), emission=20.0 * left, name=f"image {k}")
        for k, (x, left) in enumerate(rows_of_images(0.4, 1.0, specular, 60))
    ]
    wanted = on_factors([FLOOR, *row], "floor")
    error = solution.irradiance[of(solution, "floor")] / wanted - 1
    assert abs(np.mean(error)) < 0.005
    assert np.sqrt(np.mean(error**2)) < 0.02


@pytest.mark.parametrize("kind", ["lamp", "rays", "point"])
@pytest.mark.parametrize("panes", [1, 2])
def test_glass_leaves_its_transmittance(kind: str, panes: int) -> None:
    lamp = quad((0.25, 0.25, 1), (0, 0.5, 0), (0.5, 0, 0), emission=0.0 if kind == "point" else 2.0, name="lamp")
    glow = [quad((-1, -1, 2), (0, 3, 0), (3, 0, 0), emission=2.0, name="glow")] if kind == "rays" else []
    lights = [PointLight((0.5, 0.5, 0.9), 3.0)] if kind == "point" else []
    sheet = [
        quad((-1, -1, 0.3 + 0.2 * k), (3, 0, 0), (0, 3, 0), transmittance=0.7, name=f"pane {k}") for k in range(panes)
    ]
    clear = solved([FLOOR, lamp, *glow], lights, accuracy=0.003, edge=0.5)
    behind = solved([FLOOR, lamp, *glow, *sheet], lights, accuracy=0.003, edge=0.5)
    ratio = behind.irradiance[of(behind, "floor")] / clear.irradiance[of(clear, "floor")]
    assert np.mean(ratio) == pytest.approx(0.7**panes, rel=0.004)
    assert np.abs(ratio / 0.7**panes - 1).max() < 0.04


def test_glass_is_seen_through_from_behind_and_its_back_is_black() -> None:
    lamp = quad((0.25, 0.25, 1), (0, 0.5, 0), (0.5, 0, 0), emission=2.0, name="lamp")
    pane = quad((-3, -3, 0.3), (0, 7, 0), (7, 0, 0), transmittance=0.5, specular=0.3, name="pane")  # looks down
    clear, behind = (solved([FLOOR, lamp, *more], accuracy=0.003, edge=0.5) for more in ([], [pane]))
    ratio = mean(behind, "floor") / mean(clear, "floor")
    assert ratio == pytest.approx(0.5, rel=0.004)
    assert behind.report.lost_on_backs[0] == pytest.approx(0.5 * clear.report.emitted[0], rel=0.05)


def test_sensitivities_and_relights_keep_the_exchange_with_its_mirrors() -> None:
    walls: dict[str, dict[str, Any]] = {
        "x0": {"reflectance": 0.2, "specular": 0.5}, "x1": {"specular": 1.0}, "y0": {"reflectance": 0.6},
        "y1": {"reflectance": 0.3}, "z0": {"reflectance": 0.4}, "z1": {"reflectance": 0.8, "emission": 0.1},
    }  # fmt: skip
    lamp = quad((0.3, 0.3, 1.1), (0, 0.4, 0), (0.4, 0, 0), emission=5.0, name="lamp")
    solution = solved([*box((1.0, 1.5, 1.2), **walls), lamp], [PointLight((0.5, 1.2, 0.7), 1.0)], edge=0.5)
    sensitivity = solution.sensitivity("z0")
    floor = of(solution, "z0")
    value = np.average(solution.irradiance[floor, 0], weights=solution.patches.area[floor])
    # The target is linear in all that shines.
    told = (sensitivity.emission * solution.emission).sum() + (sensitivity.lights * solution.lights).sum()
    assert told == pytest.approx(value, rel=1e-3)
    step = 1e-4
    paint = solution.reflectance + step * of(solution, "x0")[:, None]
    changed, before = (solution.relight(reflectance=r) for r in (paint, solution.reflectance))
    difference = np.average((changed.irradiance - before.irradiance)[floor, 0], weights=solution.patches.area[floor])
    assert sensitivity.reflectance[of(solution, "x0")].sum() * step == pytest.approx(difference, rel=0.02)
    np.testing.assert_array_equal(before.irradiance, solution.irradiance)
    with pytest.raises(ValueError, match=r"reflectance 0\.6 must stay below 0\.5"):
        solution.relight(reflectance=0.6)


def test_the_same_seed_gives_the_same_bytes_on_any_number_of_threads() -> None:
    room = room_with_lamp({"specular": 0.7, "reflectance": 0.1})
    one, two = (solved(room, accuracy=0.02, threads=n, seed=3) for n in (1, 3))
    np.testing.assert_array_equal(one.irradiance, two.irradiance)
    np.testing.assert_array_equal(one.error, two.error)


def test_what_cannot_follow_mirrors_says_so() -> None:
    patches = Scene(room_with_lamp({"specular": 0.5})).patches(count=100)
    refusal = r"surface 'x0' is a mirror, which .* cannot follow: solve with transport='sampled'"
    for method in ("auto", "monte_carlo", "hemicube", "hierarchical"):
        with pytest.raises(ValueError, match=refusal):
            radiosity.form_factors(patches, method=method)
    with pytest.raises(ValueError, match=refusal):
        radiosity.solve(patches, transport="hierarchical")
    for solver in ("shooting", "southwell", "overshooting"):
        with pytest.raises(ValueError, match=refusal):
            radiosity.solve(patches, solver=solver)
