"""A room with a mirror and a pane of glass, as a scene for those who want to see that they are followed."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from radiosity.scene import Camera, Scene, Surface

WHITE, RED, GREEN, BLUE = [0.75, 0.75, 0.72], [0.6, 0.12, 0.1], [0.2, 0.5, 0.2], [0.15, 0.25, 0.6]

ROOM = (4.0, 3.0, 2.5)
"""Its size along x, y and z, metres."""

MIRROR_AT = 0.02
"""Where on x the mirror hangs, metres; it looks along +x."""


def mirror_room(specular: float = 0.9, transmittance: float = 0.8) -> Scene:
    """A room whose only lamp looks into a mirror: behind the lamp, its light arrives by the mirror alone.

    Two boxes stand behind the lamp, one of them behind a pane of glass, and none of them in straight sight of it.

    Args:
        specular: mirror reflectance of the mirror; what it does not reflect it absorbs.
        transmittance: of the pane, from both sides; of the rest it reflects half as a mirror does.
    """
    x, y, z = np.diag(ROOM)
    o = np.zeros(3)
    surfaces = [
        _quad("floor", o, x, y, reflectance=[0.5, 0.42, 0.35]),
        _quad("ceiling", z, y, x, reflectance=WHITE),
        _quad("left wall", o, y, z, reflectance=WHITE),
        _quad("right wall", x, z, y, reflectance=GREEN),
        _quad("front wall", o, z, x, reflectance=WHITE),
        _quad("back wall", y, x, z, reflectance=WHITE),
        _quad("mirror", (MIRROR_AT, 0.3, 0.3), (0, 2.4, 0), (0, 0, 1.9), specular=specular),
        _quad("lamp", (2.2, 1.2, 1.2), (0, 0, 0.6), (0, 0.6, 0), emission=[60.0, 54.0, 44.0]),
        _quad(
            "pane", (2.5, 0.9, 0.0), (1.2, 0, 0), (0, 0, 1.1), two_sided=True, transmittance=transmittance,
            specular=0.5 * (1 - transmittance),
        ),
        _box("red box", (2.8, 1.9, 0.0), (0.6, 0.6, 1.0), RED),
        _box("blue box", (2.9, 1.1, 0.0), (0.4, 0.4, 0.5), BLUE),
    ]  # fmt: skip
    cameras = [
        Camera.look_at((3.7, 0.35, 1.6), (1.2, 1.7, 1.0), (0, 0, 1), name="before the mirror"),
        Camera.look_at((0.6, 0.4, 1.7), (3.2, 1.7, 0.6), (0, 0, 1), name="from the mirror"),
    ]
    return Scene(surfaces, cameras=cameras, name="mirror room", bands=["R", "G", "B"])


def _quad(name: str, corner: npt.ArrayLike, u: npt.ArrayLike, v: npt.ArrayLike, **optics: Any) -> Surface:
    """A parallelogram that looks along u x v."""
    c, u, v = (np.asarray(a, dtype=np.float64) for a in (corner, u, v))
    faces = np.array([[0, 1, 2, 3]])
    return Surface(np.array([c, c + u, c + u + v, c + v]), faces, name=name, **{"reflectance": 0.0, **optics})


def _box(name: str, corner: npt.ArrayLike, size: npt.ArrayLike, reflectance: npt.ArrayLike) -> Surface:
    """A box that stands on the floor, without the face that it stands on."""
    corners = np.array([(i, j, k) for k in (0, 1) for j in (0, 1) for i in (0, 1)], dtype=np.float64)
    faces = np.array([[4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])
    return Surface(np.asarray(corner) + corners * np.asarray(size), faces, reflectance, name=name)
