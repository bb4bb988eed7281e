"""Scenes with shadows and interreflection, lit by path tracing; see ``make_known_answers.py``.

All surfaces are one-sided and every solid is shut or stands on a wall, so that one irradiance a patch says all.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from pieces import rectangle

import radiosity

Floats = npt.NDArray[np.float64]
Point = Sequence[float]
SIDES = ("left", "right", "front", "back", "floor", "ceiling")
"""Where x, y and z are lowest and highest, in turn."""


def shell(
    low: Point, high: Point, reflectance: object, *, inside: bool, leave: Sequence[str] = (), name: str = ""
) -> list[radiosity.Surface]:
    """The faces of an upright box that face in or out, but for some; reflectance of all or a dict by side."""
    a, b = np.asarray(low, float), np.asarray(high, float)
    surfaces = []
    for k, side in enumerate(SIDES):
        if side in leave:
            continue
        axis, is_high = divmod(k, 2)
        u, v = (np.eye(3)[(axis + step) % 3] * (b - a) for step in (1, 2))
        origin = a + np.eye(3)[axis] * (b - a) * is_high
        if bool(is_high) == inside:
            u, v = v, u
        rho = reflectance[side] if isinstance(reflectance, dict) else reflectance
        surfaces.append(rectangle(list(origin), u, v, rho, name=f"{name} {side}".strip()))
    return surfaces


def room(low: Point, high: Point, reflectance: object, **options: object) -> list[radiosity.Surface]:
    """An upright box seen from inside."""
    return shell(low, high, reflectance, inside=True, **options)  # type: ignore[arg-type]


def block(low: Point, high: Point, reflectance: object, **options: object) -> list[radiosity.Surface]:
    """An upright box seen from outside."""
    return shell(low, high, reflectance, inside=False, **options)  # type: ignore[arg-type]


def lamp(low: tuple[float, float], high: tuple[float, float], z: float, emission: object) -> radiosity.Surface:
    """A black rectangle that shines down."""
    return rectangle([*low, z], [0, high[1] - low[1], 0], [high[0] - low[0], 0, 0], 0.0, emission, name="lamp")


def keyhole() -> radiosity.Scene:
    """A bright room lights a dark one through a hole of 0.25 m in a wall 5 cm thick."""
    rho = 0.6
    rooms = room([0, 0, 0], [1, 1, 1], rho, leave=["right"], name="bright")
    rooms += room([1.05, 0, 0], [2, 1, 1], rho, leave=["left"], name="dark")
    tunnel = room([1, 0.375, 0.375], [1.05, 0.625, 0.625], rho, leave=["left", "right"], name="hole")
    strips = []
    for k, ((y, z), (dy, dz)) in enumerate(
        [((0, 0), (1, 0.375)), ((0, 0.625), (1, 0.375)), ((0, 0.375), (0.375, 0.25)), ((0.625, 0.375), (0.375, 0.25))]
    ):
        strips.append(rectangle([1, y, z], [0, 0, dz], [0, dy, 0], rho, name=f"bright strip {k}"))
        strips.append(rectangle([1.05, y, z], [0, dy, 0], [0, 0, dz], rho, name=f"dark strip {k}"))
    light = lamp((0.4, 0.4), (0.6, 0.6), 0.99, 100.0)
    return radiosity.Scene([*rooms, *strips, *tunnel, light], name="keyhole")


def study() -> radiosity.Scene:
    """A room with a table on four legs, a shelf on the wall and a lamp under the ceiling, in three colours."""
    walls = {
        "left": [0.6, 0.15, 0.1], "right": [0.2, 0.35, 0.6], "front": 0.7, "back": 0.7,
        "floor": [0.4, 0.3, 0.2], "ceiling": 0.8,
    }  # fmt: skip
    wood = [0.5, 0.35, 0.2]
    surfaces = room([0, 0, 0], [4, 3, 2.6], walls)
    surfaces += block([1.2, 1.0, 0.7], [2.6, 1.9, 0.76], wood, name="table")
    for k, (x, y) in enumerate([(1.25, 1.05), (2.48, 1.05), (1.25, 1.78), (2.48, 1.78)]):
        surfaces += block([x, y, 0], [x + 0.07, y + 0.07, 0.7], wood, leave=["floor", "ceiling"], name=f"leg {k}")
    for k, z in enumerate((0.9, 1.3, 1.7)):
        surfaces += block([1, 2.7, z], [3, 3, z + 0.03], wood, leave=["back"], name=f"board {k}")
    surfaces.append(lamp((2.6, 0.7), (3.1, 1.2), 2.5, [40.0, 36.0, 30.0]))
    return radiosity.Scene(surfaces, name="study")


def corridor() -> radiosity.Scene:
    """A corridor with a bend and bright walls; the lamp is at one end."""
    rho, width, height, first, second = 0.95, 1.5, 2.5, 5.0, 4.0
    surfaces = room([0, 0, 0], [first, width, height], rho, leave=["right", "back"], name="first")
    surfaces += room([first, 0, 0], [first + width, width + second, height], rho, leave=["left"], name="second")
    surfaces.append(rectangle([0, width, 0], [first, 0, 0], [0, 0, height], rho, name="first back"))
    surfaces.append(rectangle([first, width, 0], [0, second, 0], [0, 0, height], rho, name="second left"))
    surfaces.append(lamp((0.3, 0.5), (0.8, 1.0), height - 0.02, 50.0))
    return radiosity.Scene(surfaces, name="corridor")


def crater() -> radiosity.Scene:
    """Rough ground with craters, of 648 triangles, under a low sun."""
    return radiosity.scenes.crater(
        648, craters=12, roughness=5.0, size=100.0, elevation=25.0, azimuth=30.0, reflectance=0.5, sunlight=1.0, seed=4
    )


def window_room() -> radiosity.Scene:
    """A room lit by a window and full of boxes that stand on the floor and on each other's toes."""
    surfaces = room([0, 0, 0], [3, 3, 2.5], [0.7, 0.5], name="room")
    surfaces.append(rectangle([0.01, 0.8, 0.9], [0, 1.4, 0], [0, 0, 1.2], 0.0, [10.0, 12.0], name="window"))
    surfaces += block([1.0, 0.6, 0], [1.6, 1.2, 1.1], [0.3, 0.6], leave=["floor"], name="tall box")
    surfaces += block([1.7, 1.5, 0], [2.5, 2.2, 0.5], [0.6, 0.3], leave=["floor"], name="low box")
    surfaces += block([0.6, 2.0, 0], [1.0, 2.4, 0.4], [0.5, 0.5], leave=["floor"], name="small box")
    return radiosity.Scene(surfaces, name="window room")


def mesh_of(scene: radiosity.Scene) -> radiosity.Patches:
    """The patches that answers are stored for."""
    return scene.patches(as_is=True) if scene.name == "crater" else scene.patches(count=600, contacts=False)


PATH_TRACED = {"keyhole": keyhole, "study": study, "corridor": corridor, "crater": crater, "window room": window_room}
"""By name; what they are lit like is in ``references/``."""


def probes_on(patches: radiosity.Patches, count: int, seed: int = 0) -> tuple[Floats, npt.NDArray[np.int64], Floats]:
    """Points spread evenly by area over all patches, lamps included: (k, 3), index of the surface, (k, 3) normals.

    One in each of so many equal shares of the area, in the order of the patches.
    """
    rng = np.random.default_rng(seed)
    a, b, c, d = np.moveaxis(patches.polygons, 1, 0)
    triangles = np.stack([np.stack([a, b, c], 1), np.stack([a, c, d], 1)], axis=1).reshape(-1, 3, 3)
    area = np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1)
    up_to = np.cumsum(area)
    chosen = np.searchsorted(up_to, (np.arange(count) + rng.random(count)) / count * up_to[-1])
    s, t = np.sqrt(rng.random((count, 1))), rng.random((count, 1))
    p, q, r = np.moveaxis(triangles[chosen], 1, 0)
    points = p * (1 - s) + s * ((1 - t) * q + t * r)
    return points, patches.surface[chosen // 2].astype(np.int64), patches.normal[chosen // 2]


__all__ = ["PATH_TRACED", "block", "lamp", "mesh_of", "probes_on", "room"]
