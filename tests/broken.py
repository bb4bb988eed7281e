"""Models that are broken in one way each, and the one that is sound."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from known import CUBE, INWARD

from radiosity import Scene, Surface

SIZE = np.array([4.0, 3.0, 2.5])
"""Metres of a room that spans from the origin along x, y and z; z is up."""


def room(reflectance: float = 0.6) -> Scene:
    """A closed room, a surface for each wall, with a lamp under its ceiling and a cupboard on its floor."""
    surfaces = [
        Surface(CUBE[corners] * SIZE, [[0, 1, 2, 3]], reflectance, name=name) for name, corners in INWARD.items()
    ]
    lamp = [[1.5, 1.2, 2.4], [1.5, 1.8, 2.4], [2.5, 1.8, 2.4], [2.5, 1.2, 2.4]]
    surfaces += [Surface(lamp, [[0, 1, 2, 3]], 0.0, 100.0, "lamp"), cupboard()]
    return Scene(surfaces, name="room")


def cupboard(at: tuple[float, float, float] = (0.4, 1.0, 0.0)) -> Surface:
    """A box that looks outward and stands on the floor without a bottom."""
    outward = [INWARD[name][::-1] for name in INWARD if name != "floor"]
    return Surface(CUBE * [0.6, 1.0, 1.2] + at, outward, 0.4, name="cupboard")


def surface(scene: Scene, name: str) -> Surface:
    return next(s for s in scene.surfaces if s.name == name)


def turn(found: Surface, faces: list[int]) -> None:
    found.faces = np.array(found.faces)
    found.faces[faces] = found.faces[faces][:, ::-1]


def missing_face() -> Scene:
    scene = room()
    scene.surfaces = [s for s in scene.surfaces if s.name != "right"]
    return scene


def small_hole() -> Scene:
    """A ceiling of four strips, of which one is shorter by 0.2 m."""
    scene = room()
    ceiling = surface(scene, "ceiling")
    x, y, z = SIZE
    strips = []
    for k in range(4):
        a, b, end = y * k / 4, y * (k + 1) / 4, x - (0.2 if k == 2 else 0.0)
        strips += [[0, a, z], [0, b, z], [end, b, z], [end, a, z]]
    ceiling.vertices, ceiling.faces = np.array(strips), np.arange(16).reshape(4, 4)
    return scene


def flipped_wall() -> Scene:
    scene = room()
    turn(surface(scene, "back"), [0])
    return scene


def flipped_side() -> Scene:
    """One side of the cupboard looks inward."""
    scene = room()
    turn(surface(scene, "cupboard"), [4])
    return scene


def inside_out_cupboard() -> Scene:
    scene = room()
    turn(surface(scene, "cupboard"), [0, 1, 2, 3, 4])
    return scene


def rug_in_the_floor() -> Scene:
    scene = room()
    rug = [[1.5, 0.5, 0], [3.0, 0.5, 0], [3.0, 2.0, 0], [1.5, 2.0, 0]]
    scene.surfaces.append(Surface(rug, [[0, 1, 2, 3]], 0.3, name="rug"))
    return scene


def doubled_wall() -> Scene:
    scene = room()
    left = surface(scene, "left")
    scene.surfaces.append(Surface(left.vertices, left.faces, 0.3, name="wallpaper"))
    return scene


def sliver() -> Scene:
    """A strip of half a millimetre along the floor, as cutting a mesh leaves it."""
    scene = room()
    floor = surface(scene, "floor")
    x, y, _ = SIZE
    floor.vertices = [[0, 0, 0], [x, 0, 0], [x, 1, 0], [0, 1, 0], [x, 1.0005, 0], [0, 1.0005, 0], [x, y, 0], [0, y, 0]]
    floor.faces = np.array([[0, 1, 2, 3], [3, 2, 4, 5], [5, 4, 6, 7]])
    return scene


def non_manifold() -> Scene:
    """A fin between two opposite edges of the room."""
    scene = room()
    fin = CUBE[[0, 2, 7, 5]] * SIZE
    scene.surfaces.append(Surface(fin, [[0, 1, 2, 3]], 0.5, name="fin", two_sided=True))
    return scene


def in_millimetres() -> Scene:
    """A room whose 4000 mm were read as metres."""
    scene = room()
    for found in scene.surfaces:
        found.vertices = 1000 * np.asarray(found.vertices)
    return scene


def in_kilometres() -> Scene:
    scene = room()
    for found in scene.surfaces:
        found.vertices = 0.001 * np.asarray(found.vertices)
    return scene


def white_wall() -> Scene:
    scene = room()
    surface(scene, "left").reflectance = 0.98
    return scene


def floating_wall() -> Scene:
    """A wall that ends 2 mm above the floor."""
    scene = room()
    wall = surface(scene, "front")
    corners = np.array(wall.vertices)
    corners[corners[:, 2] == 0, 2] = 0.002
    wall.vertices = corners
    return scene


def buried_face() -> Scene:
    """A shelf within the closed cupboard."""
    scene = room()
    shelf = [[0.5, 1.1, 0.6], [0.9, 1.1, 0.6], [0.9, 1.9, 0.6], [0.5, 1.9, 0.6]]
    scene.surfaces.append(Surface(shelf, [[0, 1, 2, 3]], 0.5, name="shelf"))
    return scene


def lamp_toward_ceiling() -> Scene:
    """A lamp that is fixed 1 cm below the ceiling and shines upward."""
    scene = room()
    lamp = surface(scene, "lamp")
    turn(lamp, [0])
    lamp.vertices = np.asarray(lamp.vertices) + np.array([0, 0, 0.09])
    return scene


def lamp_without_area() -> Scene:
    scene = room()
    line = [[1, 1, 1], [2, 1, 1], [3, 1, 1]]
    scene.surfaces.append(Surface(line, [[0, 1, 2]], 0.0, 50.0, "tube"))
    return scene


def nan_vertex() -> Scene:
    scene = room()
    corners = np.array(surface(scene, "cupboard").vertices)
    corners[3, 1] = np.nan
    surface(scene, "cupboard").vertices = corners
    return scene


MODELS: dict[str, tuple[Callable[[], Scene], str, str, list[int]]] = {
    "missing face": (missing_face, "light-escapes", "ceiling", [0]),
    "small hole": (small_hole, "light-escapes", "right", [0]),
    "flipped wall": (flipped_wall, "turned-faces", "back", [0]),
    "flipped side": (flipped_side, "mixed-winding", "cupboard", [4]),
    "inside-out cupboard": (inside_out_cupboard, "back-in-sight", "cupboard", [0, 1, 2, 3, 4]),
    "rug in the floor": (rug_in_the_floor, "overlapping-faces", "rug", [0]),
    "doubled wall": (doubled_wall, "duplicate-faces", "wallpaper", [0]),
    "sliver": (sliver, "sliver-faces", "floor", [1]),
    "millimetres": (in_millimetres, "implausible-size", "", []),
    "kilometres": (in_kilometres, "implausible-size", "", []),
    "white wall": (white_wall, "high-reflectance", "left", []),
    "floating wall": (floating_wall, "narrow-gap", "floor", [0]),
    "buried face": (buried_face, "buried-faces", "shelf", [0]),
    "lamp toward the ceiling": (lamp_toward_ceiling, "blocked-lamp", "lamp", [0]),
    "lamp without area": (lamp_without_area, "lamp-without-area", "tube", []),
    "NaN": (nan_vertex, "non-finite-vertex", "cupboard", []),
}
"""How to make it, and the code, surface and faces that tell of it."""
