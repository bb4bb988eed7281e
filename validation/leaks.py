"""Small scenes of the kind that leaks light or shadow in bakers: one region is lit, all else must be exactly dark.

Lengths are metres, z is up. No wall is where a regular mesh would have an edge, and floors, ceilings and walls run on
beneath and behind whatever stands on them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

import radiosity

Array = np.ndarray

REFLECTANCE = 0.6
PROBE = 1e-3
"""How far off a side is asked whether it is in the dark, m; thinner than all that is solid."""

X, Y, Z = 6.1, 3.1, 2.3
"""The room, m."""

Region = Callable[[Array], Array]
"""(n, 3) points -> (n,) whether they are in the region."""


@dataclass(frozen=True)
class Leak:
    """A scene and where there is light in it."""

    name: str
    scene: radiosity.Scene
    lit: Region
    """Where light may come; all else is dark."""

    def dark_sides(self, patches: radiosity.Patches) -> tuple[Array, Array]:
        """(n,) whether the front and whether the back of each patch must be dark."""
        front, back = (patches.centre + side * PROBE * patches.normal for side in (1, -1))
        return ~self.lit(front), ~self.lit(back)

    def turned(self) -> Leak:
        """The same, turned about all axes and rounded to single precision as files are."""
        turn = rotation(0.37, 0.21, -0.53)

        def moved(surface: radiosity.Surface) -> radiosity.Surface:
            vertices = (np.asarray(surface.vertices) @ turn.T + 0.3).astype(np.float32).astype(float)
            return radiosity.Surface(
                vertices, surface.faces, surface.reflectance, surface.emission, surface.name, surface.two_sided
            )

        scene = radiosity.Scene([moved(surface) for surface in self.scene.surfaces], name=self.scene.name)
        return Leak(f"{self.name}, turned", scene, lambda p: self.lit((p - 0.3) @ turn))


def rotation(*angles: float) -> Array:
    """(3, 3) turns about x, y and z, one after the other."""
    turn = np.eye(3)
    for axis, angle in enumerate(angles):
        c, s = np.cos(angle), np.sin(angle)
        i, j = (axis + 1) % 3, (axis + 2) % 3
        one = np.eye(3)
        one[i, i], one[i, j], one[j, i], one[j, j] = c, -s, s, c
        turn = one @ turn
    return turn


def quads(name: str, corners: list[Array], **optics: object) -> radiosity.Surface:
    """Quadrilaterals with corners (4, 3) each."""
    faces = np.arange(4 * len(corners)).reshape(-1, 4)
    return radiosity.Surface(np.concatenate(corners), faces, REFLECTANCE, name=name, **optics)  # type: ignore[arg-type]


def box_faces(low: tuple[float, ...], high: tuple[float, ...]) -> dict[str, Array]:
    """The faces of a box that look out, by where they are."""
    (a, b, c), (d, e, f) = low, high
    return {
        name: np.array(corners)
        for name, corners in {
            "bottom": [[a, b, c], [a, e, c], [d, e, c], [d, b, c]],
            "top": [[a, b, f], [d, b, f], [d, e, f], [a, e, f]],
            "west": [[a, b, c], [a, b, f], [a, e, f], [a, e, c]],
            "east": [[d, b, c], [d, e, c], [d, e, f], [d, b, f]],
            "south": [[a, b, c], [d, b, c], [d, b, f], [a, b, f]],
            "north": [[a, e, c], [a, e, f], [d, e, f], [d, e, c]],
        }.items()
    }


def room(x: float = X, y: float = Y, z: float = Z) -> radiosity.Surface:
    """Six faces that look in."""
    return quads("room", [face[::-1] for face in box_faces((0, 0, 0), (x, y, z)).values()])


def solid(low: tuple[float, ...], high: tuple[float, ...], name: str, without: str = "") -> radiosity.Surface:
    """A box that looks out."""
    return quads(name, [face for side, face in box_faces(low, high).items() if side != without])


def sheet(name: str, *corners: tuple[float, float, float]) -> radiosity.Surface:
    """A quadrilateral with two sides."""
    return quads(name, [np.array(corners, dtype=float)], two_sided=True)


def upright(
    name: str, a: tuple[float, float], b: tuple[float, float], low: float = 0.0, top: float = Z
) -> radiosity.Surface:
    """A sheet over the line from a to b."""
    return sheet(name, (*a, low), (*b, low), (*b, top), (*a, top))


def lamp(x: float = 1.6, y: float = 1.4, z: float = 2.0) -> radiosity.Surface:
    """A small panel that shines down."""
    corners = np.array([[x, y, z], [x, y + 0.4, z], [x + 0.5, y + 0.4, z], [x + 0.5, y, z]])
    return quads("lamp", [corners], emission=100.0)


def inside(low: tuple[float, ...], high: tuple[float, ...]) -> Region:
    """The region within a box."""
    return lambda p: np.all((p > np.array(low)) & (p < np.array(high)), axis=1)


def outside_solids(*solids: tuple[tuple[float, ...], tuple[float, ...]]) -> Region:
    """The room without what is solid in it."""
    within = inside((0, 0, 0), (X, Y, Z))
    return lambda p: within(p) & ~np.any([inside(*one)(p) for one in solids], axis=0)


def scene_of(name: str, *surfaces: radiosity.Surface) -> radiosity.Scene:
    return radiosity.Scene([*surfaces, lamp()], name=name)


def furnished(name: str, *solids: tuple[tuple[float, ...], tuple[float, ...]], without: str = "") -> Leak:
    """The room with boxes in it."""
    boxes = [solid(low, high, f"box {i}", without) for i, (low, high) in enumerate(solids)]
    return Leak(name, scene_of(name, room(), *boxes), outside_solids(*solids))


WEST = inside((0, 0, 0), (3.7, Y, Z))
"""The part of the room that is lit where a wall at x = 3.7 divides it."""


def two_rooms_over_one_slab() -> Leak:
    slabs = [
        quads("floor", [np.array([[-0.4, -0.4, 0], [X + 0.4, -0.4, 0], [X + 0.4, Y + 0.4, 0], [-0.4, Y + 0.4, 0]])]),
        quads("ceiling", [np.array([[-0.4, -0.4, Z], [-0.4, Y + 0.4, Z], [X + 0.4, Y + 0.4, Z], [X + 0.4, -0.4, Z]])]),
    ]
    walls = [
        upright("south", (0, 0), (X, 0)), upright("north", (0, Y), (X, Y)), upright("west", (0, 0), (0, Y)),
        upright("east", (X, 0), (X, Y)), upright("between", (3.7, 0), (3.7, Y)),
    ]  # fmt: skip
    return Leak("two rooms over one slab", scene_of("slab", *slabs, *walls), WEST)


def cupboard() -> Leak:
    low, high = (0.0, 0.9, 0.0), (0.63, 1.72, 1.85)
    faces = {side: face for side, face in box_faces(low, high).items() if side not in ("bottom", "west")}
    closed = quads("cupboard", list(faces.values()), two_sided=True)
    return Leak("closed cupboard on a wall", scene_of("cupboard", room(), closed), outside_solids((low, high)))


def dark_neighbour() -> Leak:
    """A closed room beside another: their shared wall has two sides, and the bright one's floor runs on beneath."""
    shared = upright("shared", (3.7, 0), (3.7, Y))
    bright = quads(
        "bright", [face[::-1] for s, face in box_faces((0, 0, 0), (3.7, Y, Z)).items() if s not in ("east", "bottom")]
    )
    dark = quads(
        "dark", [face[::-1] for s, face in box_faces((3.7, 0, 0), (X, Y, Z)).items() if s not in ("west", "bottom")]
    )
    floor = quads("floor", [np.array([[0, 0, 0], [X, 0, 0], [X, Y, 0], [0, Y, 0]], dtype=float)])
    return Leak("dark room beside a bright one", scene_of("neighbours", bright, dark, floor, shared), WEST)


def thin_sheet() -> Leak:
    return Leak("thin sheet", scene_of("sheet", room(), upright("sheet", (3.7, 0), (3.7, Y))), WEST)


def thin_box() -> Leak:
    wall = solid((3.7, 0, 0), (3.78, Y, Z), "partition")
    return Leak("thin box", scene_of("thin box", room(), wall), WEST)


def lean_to() -> Leak:
    """A roof that meets the floor at 45 degrees: dark beneath."""
    roof = sheet("roof", (3.9, 0, 0), (X, 0, 2.2), (X, Y, 2.2), (3.9, Y, 0))
    rise = 2.2 / (X - 3.9)
    within = inside((0, 0, 0), (X, Y, Z))
    return Leak(
        "joint below 90 degrees",
        scene_of("lean-to", room(), roof),
        lambda p: within(p) & (p[:, 2] > rise * (p[:, 0] - 3.9)),
    )


def table() -> Leak:
    legs = [((x, y, 0.0), (x + 0.07, y + 0.07, 0.7)) for x in (2.9, 4.33) for y in (0.87, 1.64)]
    return furnished("table", *legs, ((2.86, 0.83, 0.7), (4.44, 1.75, 0.74)))


def box_with_bottom() -> Leak:
    return furnished("box on the floor", ((3.1, 1.2, 0.0), (3.83, 1.77, 0.9)))


def box_without_bottom() -> Leak:
    return furnished("box without a bottom", ((3.1, 1.2, 0.0), (3.83, 1.77, 0.9)), without="bottom")


def stacked_boxes() -> Leak:
    return furnished("box on a box", ((3.1, 1.2, 0.0), (4.27, 2.13, 0.8)), ((3.45, 1.41, 0.8), (3.83, 1.77, 1.3)))


def partition_into_walls() -> Leak:
    """A sheet whose edges are hidden in walls, floor and ceiling."""
    through = upright("through", (3.7, -0.2), (3.7, Y + 0.2), -0.2, Z + 0.2)
    return Leak("partition that ends in the walls", scene_of("through", room(), through), WEST)


def crossing_sheets() -> Leak:
    sheets = [upright("across", (3.7, 0), (3.7, Y)), upright("along", (0, 2.05), (X, 2.05))]
    return Leak("crossing sheets", scene_of("crossing", room(), *sheets), inside((0, 0, 0), (3.7, 2.05, Z)))


def picture() -> Leak:
    """A box with its back on the wall."""
    return furnished("picture on a wall", ((2.3, Y - 0.03, 0.9), (3.17, Y, 1.52)))


def walls_of_different_heights() -> Leak:
    """A low ceiling that ends at a high wall: dark above it and behind."""
    low = sheet("low ceiling", (0, 0, 2.1), (3.7, 0, 2.1), (3.7, Y, 2.1), (0, Y, 2.1))
    return Leak(
        "walls of different heights",
        scene_of("heights", room(), low, upright("high wall", (3.7, 0), (3.7, Y))),
        inside((0, 0, 0), (3.7, Y, 2.1)),
    )


def corner_column() -> Leak:
    return furnished("column in a corner", ((X - 0.43, Y - 0.37, 0.0), (X, Y, Z)))


def turned_wall() -> Leak:
    """A wall across the room at an angle."""
    a, b = np.array([3.05, 0.0]), np.array([4.45, Y])
    across = upright("turned wall", (a[0], a[1]), (b[0], b[1]))
    within = inside((0, 0, 0), (X, Y, Z))

    def west(p: Array) -> Array:
        return within(p) & ((b - a)[0] * (p[:, 1] - a[1]) - (b - a)[1] * (p[:, 0] - a[0]) > 0)

    return Leak("wall at an angle", scene_of("turned", room(), across), west)


def staircase() -> Leak:
    steps = [((3.3 + 0.37 * i, 0.0, 0.0), (3.67 + 0.37 * i, 1.13, 0.23 * (i + 1))) for i in range(6)]
    return furnished("staircase", *steps)


def poster() -> Leak:
    """A sheet in the plane of the wall: nothing is dark, and which of the two is seen is all one."""
    corners = np.array([[2.3, Y, 0.9], [2.3, Y, 1.52], [3.17, Y, 1.52], [3.17, Y, 0.9]])[::-1]
    return Leak(
        "poster in the plane of a wall",
        scene_of("poster", room(), quads("poster", [corners])),
        inside((0, 0, 0), (X, Y, Z)),
    )


CORPUS = {
    make.__name__: make
    for make in (
        two_rooms_over_one_slab, cupboard, dark_neighbour, thin_sheet, thin_box, lean_to, table, box_with_bottom,
        box_without_bottom, stacked_boxes, partition_into_walls, crossing_sheets, picture, walls_of_different_heights,
        corner_column, turned_wall, staircase, poster,
    )
}  # fmt: skip
"""Every scene by name."""


def most_light_in_the_dark(leak: Leak, solution: radiosity.Solution) -> float:
    """The greatest irradiance of any side that must be dark, W/m2."""
    front, back = leak.dark_sides(solution.patches)
    back &= solution.patches.two_sided
    return float(max(solution.irradiance[front].max(initial=0.0), solution.back_irradiance[back].max(initial=0.0)))
