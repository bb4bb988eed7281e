"""Closed rooms with random convex solids in them, and random triangles."""

from __future__ import annotations

from itertools import product

import numpy as np

import radiosity

Array = np.ndarray

ROOM = np.array([1.0, 1.3, 0.9])
"""Edges of the room, m."""


def random_rotation(rng: np.random.Generator) -> Array:
    """(3, 3) evenly distributed over all turns."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


def walls(cells: int) -> list[radiosity.Surface]:
    """The six walls of the room, cells x cells quadrilaterals each, facing in."""
    surfaces = []
    for axis, high in product(range(3), (False, True)):
        u, v = np.roll(np.eye(3), -axis - 1, axis=0)[:2] * ROOM
        if high:
            u, v = v, u
        origin = np.eye(3)[axis] * ROOM * high
        s, t = np.meshgrid(np.linspace(0, 1, cells + 1), np.linspace(0, 1, cells + 1))
        vertices = origin + s.reshape(-1, 1) * u + t.reshape(-1, 1) * v
        first = np.array([j * (cells + 1) + i for j in range(cells) for i in range(cells)])
        faces = np.stack([first, first + 1, first + cells + 2, first + cells + 1], axis=1)
        surfaces.append(radiosity.Surface(vertices, faces, name=f"wall {'xyz'[axis]}{int(high)}"))
    return surfaces


def box(centre: Array, half: Array, turn: Array, name: str) -> radiosity.Surface:
    """A box that faces out."""
    signs = np.array(list(product((-1, 1), repeat=3)))
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return radiosity.Surface(centre + signs * half @ turn.T, faces, name=name)


def tetrahedron(corners: Array, name: str) -> radiosity.Surface:
    """A tetrahedron that faces out."""
    a, b, c, d = corners
    if np.dot(np.cross(b - a, c - a), d - a) > 0:
        corners = corners[[0, 2, 1, 3]]
    return radiosity.Surface(corners, [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]], name=name)


def random_solids(rng: np.random.Generator, count: int) -> list[radiosity.Surface]:
    """Solids off the walls and each other, because the balls about them are."""
    solids: list[radiosity.Surface] = []
    balls: list[tuple[Array, float]] = []
    while len(solids) < count:
        radius = rng.uniform(0.1, 0.4)
        centre = rng.uniform(0, ROOM)
        is_inside = np.all(centre > radius * 1.02) and np.all(centre < ROOM - radius * 1.02)
        if not is_inside or any(np.linalg.norm(centre - c) < 1.02 * (radius + r) for c, r in balls):
            continue
        balls.append((centre, radius))
        name = f"solid {len(solids)}"
        if rng.random() < 0.5:
            half = rng.uniform(0.1, 1, 3)
            solids.append(box(centre, half * radius / np.linalg.norm(half), random_rotation(rng), name))
        else:
            corners = rng.normal(size=(4, 3))
            corners *= radius / np.linalg.norm(corners, axis=1, keepdims=True)
            solids.append(tetrahedron(centre + corners, name))
    return solids


def random_room(seed: int) -> list[radiosity.Surface]:
    """A closed room with one to three solids; walls of 1, 4 or 9 patches each."""
    rng = np.random.default_rng(seed)
    cells = int(rng.integers(1, 4))
    return walls(cells) + random_solids(rng, int(rng.integers(1, 4)))


def patches_of_surfaces(surfaces: list[radiosity.Surface]) -> radiosity.Patches:
    """One patch a face."""
    return radiosity.Scene(surfaces).patches(as_is=True)


def moved(
    surfaces: list[radiosity.Surface], scale: float = 1.0, turn: Array | None = None, shift: Array | None = None
) -> list[radiosity.Surface]:
    """The same surfaces elsewhere and in another unit of length."""
    turn = np.eye(3) if turn is None else turn
    shift = np.zeros(3) if shift is None else shift
    return [radiosity.Surface(scale * (s.vertices @ turn.T + shift), s.faces, name=s.name) for s in surfaces]


def cut_in_front(polygon: Array, plane: Array) -> Array:
    """The part of a convex polygon in front of the plane of another, by its right-hand normal."""
    normal = np.cross(plane[1] - plane[0], plane[2] - plane[0])
    heights = (polygon - plane[0]) @ normal
    kept = []
    for k, h in enumerate(heights):
        m = (k + 1) % len(polygon)
        if h >= 0:
            kept.append(polygon[k])
        if h * heights[m] < 0:
            kept.append(polygon[k] + h / (h - heights[m]) * (polygon[m] - polygon[k]))
    return np.array(kept).reshape(-1, 3)
