"""A table lamp with a paper shade, beside a plant: light that passes through what it falls on."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from radiosity.scene import Camera, Scene, Surface

Floats = npt.NDArray[np.float64]

WALL, FLOOR, WOOD = [0.72, 0.7, 0.66], [0.3, 0.22, 0.16], [0.36, 0.22, 0.12]

PAPER, THROUGH_PAPER = [0.4, 0.34, 0.24], [0.44, 0.35, 0.21]
"""What warm white paper reflects, and what passes through it."""

LEAF, THROUGH_LEAF = [0.05, 0.12, 0.03], [0.07, 0.24, 0.02]
"""Of green leaves: thin ones pass as much as they reflect and more (Jacquemoud and Baret 1990, PROSPECT)."""

TABLE = 0.74
"""Height of the table, metres."""

LAMP = (0.0, 0.0)
"""Where on x and z the lamp stands on the table."""


def lampshade(transmittance: float = 1.0) -> Scene:
    """A table lamp whose paper shade glows, and a plant with the light behind its leaves, at dusk.

    Args:
        transmittance: scales what passes through paper and leaves; with 0 they are opaque.
    """
    x, z = LAMP
    paper, leaf = (transmittance * np.array(t) for t in (THROUGH_PAPER, THROUGH_LEAF))
    foot = [(0.085, 0.0), (0.09, 0.012), (0.08, 0.025), (0.055, 0.04), (0.082, 0.085), (0.085, 0.12), (0.06, 0.16),
            (0.03, 0.185), (0.012, 0.195), (0.007, 0.205), (0.007, 0.29)]  # fmt: skip
    bulb = [(0.007, 0.29), (0.04, 0.315), (0.052, 0.35), (0.04, 0.385), (0.0, 0.4)]
    pot = [(0.055, 0.0), (0.08, 0.13), (0.073, 0.13), (0.07, 0.115), (0.0, 0.115)]
    surfaces = [
        *_room(),
        *_table(),
        _turned("lamp foot", foot, 24, (x, TABLE, z), [0.2, 0.36, 0.4]),
        _turned("bulb", bulb, 12, (x, TABLE, z), 0.3, emission=[300.0, 225.0, 140.0]),
        _turned("shade", [(0.19, 0.265), (0.168, 0.33), (0.146, 0.395), (0.124, 0.46)], 24, (x, TABLE, z), PAPER,
                diffuse_transmittance=paper),
        _turned("pot", pot, 20, (0.36, TABLE, 0.02), [0.45, 0.2, 0.12]),
        _leaves("leaves", (0.36, TABLE + 0.115, 0.02), leaf),
        _box("blue book", (-0.42, TABLE, -0.02), (0.22, 0.035, 0.15), [0.1, 0.17, 0.35]),
        _box("red book", (-0.4, TABLE + 0.035, -0.01), (0.19, 0.028, 0.13), [0.45, 0.09, 0.07]),
    ]  # fmt: skip
    cameras = [
        Camera.look_at((0.14, 1.12, 1.35), (0.08, 0.98, 0.0), vertical_fov=math.radians(40), name="the lamp"),
        Camera.look_at((0.75, 1.15, 0.45), (0.15, 0.98, -0.05), vertical_fov=math.radians(40), name="through leaves"),
    ]
    return Scene(surfaces, cameras=cameras, name="lampshade", bands=["R", "G", "B"])


def _room() -> list[Surface]:
    """A closed room with a window at dusk on the left; the wall behind the table at z = -0.35."""
    o, x, y, z = np.array([-1.0, 0.0, -0.36]), np.array([2.1, 0, 0]), np.array([0, 1.9, 0]), np.array([0, 0, 1.9])
    at, up, along = o + np.array([0.0, 0.9, 0.7]), np.array([0, 0.8, 0]), np.array([0, 0, 0.9])
    return [
        _quad("floor", o, z, x, FLOOR),
        _quad("ceiling", o + y, x, z, WALL),
        _quad("wall behind", o, x, y, WALL),
        _framing("left wall", _corners(o, y, z), _corners(at, up, along), WALL),
        _quad("right wall", o + x, z, y, WALL),
        _quad("wall in front", o + z, y, x, WALL),
        _quad("window", at, up, along, 0.05, emission=[0.5, 0.8, 1.4]),
    ]


def _table() -> list[Surface]:
    legs = [(sx, sz) for sx in (-0.7, 0.64) for sz in (-0.3, 0.24)]
    return [
        _box("table", (-0.72, TABLE - 0.035, -0.32), (1.44, 0.035, 0.64), WOOD, is_closed=True),
        *(_box(f"leg {k}", (a, 0.0, b), (0.06, TABLE - 0.035, 0.06), WOOD) for k, (a, b) in enumerate(legs)),
    ]


def _quad(name: str, corner: npt.ArrayLike, u: Floats, v: Floats, reflectance: npt.ArrayLike,
          emission: npt.ArrayLike = 0.0) -> Surface:  # fmt: skip
    """A parallelogram that looks along u x v."""
    return Surface(_corners(corner, u, v), np.array([[0, 1, 2, 3]]), reflectance, emission, name)


def _corners(corner: npt.ArrayLike, u: Floats, v: Floats) -> Floats:
    c = np.asarray(corner, dtype=np.float64)
    return np.array([c, c + u, c + u + v, c + v])


def _framing(name: str, outer: Floats, inner: Floats, reflectance: npt.ArrayLike) -> Surface:
    """What one quad leaves around another within it; (4, 3) corners each."""
    faces = [[k, (k + 1) % 4, 4 + (k + 1) % 4, 4 + k] for k in range(4)]
    return Surface(np.concatenate([outer, inner]), np.array(faces), reflectance, name=name)


def _box(name: str, corner: Sequence[float], size: Sequence[float], reflectance: npt.ArrayLike,
         is_closed: bool = False) -> Surface:  # fmt: skip
    """A box; without the face that it stands on unless it is closed."""
    corners = np.array([(i, j, k) for k in (0, 1) for j in (0, 1) for i in (0, 1)], dtype=np.float64)
    faces = [[4, 5, 7, 6], [1, 0, 2, 3], [2, 6, 7, 3], [0, 4, 6, 2], [5, 1, 3, 7]]
    faces += [[0, 1, 5, 4]] if is_closed else []
    return Surface(np.asarray(corner) + corners * np.asarray(size), np.array(faces), reflectance, name=name)


def _turned(name: str, profile: Sequence[tuple[float, float]], sides: int, foot: tuple[float, float, float],
            reflectance: npt.ArrayLike, emission: npt.ArrayLike = 0.0,
            diffuse_transmittance: npt.ArrayLike = 0.0) -> Surface:  # fmt: skip
    """A profile of (radius, height), upward on the outside, turned about the vertical through ``foot``."""
    angle = 2 * math.pi * np.arange(sides) / sides
    rings = [np.column_stack([r * np.cos(angle), np.full(sides, h), r * np.sin(angle)]) for r, h in profile]
    k, following = np.arange(sides), (np.arange(sides) + 1) % sides
    faces = []
    for row, ((_, _), (above, _)) in enumerate(pairwise(profile)):
        low, high = row * sides, (row + 1) * sides
        # A ring of radius 0 is one point.
        last = k if above == 0 else following
        faces.append(np.column_stack([low + following, low + k, high + k, high + last]))
    vertices, index = np.unique(np.concatenate(rings).round(12), axis=0, return_inverse=True)
    return Surface(vertices + np.asarray(foot), index.reshape(-1)[np.concatenate(faces)], reflectance, emission, name,
                   diffuse_transmittance=diffuse_transmittance)  # fmt: skip


def _leaves(name: str, root: tuple[float, float, float], transmittance: Floats) -> Surface:
    """Leaves that rise from a pot and arch outward, all one surface."""
    vertices, faces, count = [], [], 0
    for k in range(13):
        # By the golden angle, the outer ones longer and lower.
        turn, out = 2.4 * k + 0.4, (k + 0.5) / 13
        blade, cells = _leaf(0.16 + 0.1 * out, 0.035 + 0.012 * out, math.radians(80 - 45 * out), 0.9 + 0.6 * out)
        c, s = math.cos(turn), math.sin(turn)
        blade = blade @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
        vertices.append(blade + np.asarray(root) + 0.03 * out * np.array([c, 0, s]))
        faces.append(cells + count)
        count += len(blade)
    return Surface(
        np.concatenate(vertices), np.concatenate(faces), LEAF, 0.0, name, diffuse_transmittance=transmittance
    )


def _leaf(length: float, half_width: float, rise: float, bend: float) -> tuple[Floats, npt.NDArray[np.int64]]:
    """A blade along x that rises at an angle and bends down by another, both in radians, folded along its rib."""
    t = np.linspace(0, 1, 7)
    slope = rise - bend * t
    step = length / (len(t) - 1)
    rib = np.cumsum(np.column_stack([np.cos(slope), np.sin(slope), np.zeros(len(t))]) * step, axis=0)
    rib -= rib[0]
    width = half_width * np.sin(math.pi * t**0.8) ** 0.9 + 0.002 * (1 - t)
    lift = np.column_stack([-np.sin(slope), np.cos(slope), np.zeros(len(t))]) * (0.35 * width)[:, None]
    edge = np.column_stack([np.zeros((len(t), 2)), width])
    # Both edges end in the tip.
    vertices = np.concatenate([rib, (rib + lift + edge)[:-1], (rib + lift - edge)[:-1]])
    n = len(t)
    faces = []
    for first, order in ((n, 1), (2 * n - 1, -1)):
        side = [*range(first, first + n - 1), n - 1]
        for k in range(n - 1):
            faces.append([k, side[k], side[k + 1]][::order])
            faces += [[k, side[k + 1], k + 1][::order]] if k < n - 2 else []
    return vertices, np.array(faces)
