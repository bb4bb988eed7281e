"""Scenes for the comparison of view-factor programs, with the factors where a closed form gives all of them.

Only NumPy is needed here, so that each program can be run from its own environment.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import terrain

Array = NDArray[np.float64]
Faces = NDArray[np.int64]
Truth = Callable[[], Array]

PLATE = 0.09950629459898  # unit squares at gap 1, a centred half-size plate midway; smooth 4-D Gauss-Legendre


@dataclass(frozen=True)
class Scene:
    """Patches, all triangles or all plane quadrilaterals."""

    name: str
    vertices: Array  # (m, 3)
    faces: Faces  # (n, 3) or (n, 4), right-hand rule about the normal
    closed: bool  # every row sums to 1
    occluded: bool  # patches hide one another
    truth: Truth | None = None  # all factors, (n, n), NaN where unknown; None: exact values of a sample are computed

    @property
    def polygons(self) -> Array:
        """Corners of the patches, (n, 3 or 4, 3)."""
        return self.vertices[self.faces]

    @property
    def normals(self) -> Array:
        """Unit normals, (n, 3)."""
        p = self.polygons
        n = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
        return n / np.linalg.norm(n, axis=1, keepdims=True)

    @property
    def areas(self) -> Array:
        """Areas, (n,)."""
        p = self.polygons
        fan = np.cross(p[:, 1:-1] - p[:, :1], p[:, 2:] - p[:, :1]).sum(axis=1)
        return np.linalg.norm(fan, axis=1) / 2


def scene(name: str) -> Scene:
    """The scene of this name."""
    return SCENES[name](name)


def cube(n: int) -> Callable[[str], Scene]:
    """The inside of the unit cube, n x n squares a side."""

    def build(name: str) -> Scene:
        sides = [rectangle(o, u, v, n, n) for o, u, v in box_sides(np.zeros(3), np.eye(3), inwards=True)]
        vertices, faces = weld(np.concatenate(sides))
        return Scene(name, vertices, faces, True, False, lambda: cube_factors(vertices[faces], n))

    return build


def plate(name: str) -> Scene:
    """Two facing unit squares at gap 1 and, midway, both sides of a centred square of half the size."""
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    small = 0.25 + 0.5 * square
    up, down = square, np.add(square[::-1], [0, 0, 1])
    quads = np.stack([up, down, small[::-1] * [1, 1, 0] + [0, 0, 0.5], small * [1, 1, 0] + [0, 0, 0.5]])
    vertices, faces = weld(quads)
    return Scene(name, vertices, faces, False, True, plate_factors)


def plate_factors() -> Array:
    """The factors between the large squares of ``plate``; NaN where a side of the small one takes part.

    Its sides lie on one another, and programs that trace rays cannot tell which of them was hit.
    """
    factors = np.full((4, 4), np.nan)
    factors[:2, :2] = [[0, PLATE], [PLATE, 0]]
    return factors


def room(name: str) -> Scene:
    """A room of 2 x 3 x 2.5 m in squares of 0.25 m; a box turned about z and a tilted plate of 2 cm hang free in it.

    Both turns are 3-4-5 triangles, so that the corners are plane to rounding.
    """
    walls = [
        rectangle(o, u, v, round(np.linalg.norm(u) / 0.25), round(np.linalg.norm(v) / 0.25))
        for o, u, v in box_sides(np.zeros(3), np.diag([2, 3, 2.5]), inwards=True)
    ]
    turn = np.array([[0.8, 0.6, 0], [-0.6, 0.8, 0], [0, 0, 1]])
    tilt = np.array([[1, 0, 0], [0, 0.8, 0.6], [0, -0.6, 0.8]])
    box = solid(np.array([0.6, 1.1, 0.3]), np.diag([0.7, 0.5, 0.9]) @ turn, 2)
    thin = solid(np.array([0.4, 0.9, 1.9]), np.diag([1.1, 0.8, 0.02]) @ tilt, 2)
    vertices, faces = weld(np.concatenate([*walls, *box, *thin]))
    return Scene(name, vertices, faces, True, True)


def crater(cells: int) -> Callable[[str], Scene]:
    """The smooth crater with 2 cells^2 triangles."""

    def build(name: str) -> Scene:
        return Scene(name, *terrain.smooth_crater(cells), False, True)

    return build


def rough(name: str) -> Scene:
    """The rough cratered field of 2,048 triangles."""
    return Scene(name, *terrain.rough_terrain(), False, True)


SCENES: dict[str, Callable[[str], Scene]] = {
    "cube-600": cube(10),
    "cube-2400": cube(20),
    "cube-6144": cube(32),
    "cube-15000": cube(50),
    "plate": plate,
    "room": room,
    "rough-2048": rough,
    "crater-2048": crater(32),
    "crater-4608": crater(48),
    "crater-10082": crater(71),
}


def box_sides(origin: Array, edges: Array, *, inwards: bool) -> list[tuple[Array, Array, Array]]:
    """Origin and two edges of each side of a box whose three edges are the rows of ``edges``, right-handed."""
    sides = []
    for k in range(3):
        u, v, w = edges[(k + 1) % 3], edges[(k + 2) % 3], edges[k]
        low, high = (origin, u, v), (origin + w, v, u)
        sides += [low, high] if inwards else [(low[0], v, u), (high[0], u, v)]
    return sides


def solid(origin: Array, edges: Array, n: int) -> list[Array]:
    """The outside of a box, n x n patches a side, but thin sides not divided across."""
    length = np.linalg.norm(edges, axis=1).max()
    return [
        rectangle(o, u, v, *(n if np.linalg.norm(e) > 0.1 * length else 1 for e in (u, v)))
        for o, u, v in box_sides(origin, edges, inwards=False)
    ]


def rectangle(origin: Array, u: Array, v: Array, nu: int, nv: int) -> Array:
    """A rectangle with normal u x v as nu x nv quadrilaterals, (nu * nv, 4, 3)."""
    s, t = (np.arange(n + 1)[:, None] / n for n in (nu, nv))
    grid = origin + s[:, None] * u + t[None] * v
    corners = [grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]]
    return np.stack(corners, axis=2).reshape(-1, 4, 3)


def weld(polygons: Array) -> tuple[Array, Faces]:
    """Vertices and faces in which corners at the same place are one vertex."""
    points = polygons.reshape(-1, 3)
    _, first, index = np.unique(np.round(points, 9), axis=0, return_index=True, return_inverse=True)
    return points[first], index.reshape(polygons.shape[:2])


def cube_factors(polygons: Array, n: int) -> Array:
    """All factors of the cube in units of a patch, where the areas are 1 and offsets are whole numbers."""
    low = np.rint(n * polygons.min(axis=1)).astype(int)
    axis = np.argmin(np.ptp(polygons, axis=1), axis=1)
    offsets = np.arange(n)
    parallel, across = parallel_cells(offsets, n), perpendicular_cells(n)
    factors = np.zeros((len(polygons), len(polygons)))
    for i, (a, corner) in enumerate(zip(axis, low, strict=True)):
        others = [k for k in range(3) if k != a]
        facing = (axis == a) & (low[:, a] != corner[a])
        factors[i, facing] = parallel[tuple(np.abs(low[facing][:, others] - corner[others]).T)]
        for b in others:
            side, along = axis == b, 3 - a - b
            mine = np.where(low[side, b] == 0, corner[b], n - 1 - corner[b])
            theirs = low[side, a] if corner[a] == 0 else n - 1 - low[side, a]
            factors[i, side] = across[np.abs(low[side, along] - corner[along]), mine, theirs]
    return factors


def parallel_cells(offsets: NDArray[np.int64], gap: int) -> Array:
    """Factor between unit squares of facing planes by their offsets along both axes, (n, n).

    Aligned rectangles are differences of the corner function; for equal cells these are second differences.
    """
    d = np.arange(-1, len(offsets) + 1, dtype=np.longdouble)
    g = parallel_corner(d[:, None], d[None], np.longdouble(gap))
    return second_difference(second_difference(g, 0), 1).astype(float)


def perpendicular_cells(n: int) -> Array:
    """Factor between unit squares of perpendicular planes, (n, n, n).

    Indexed by offset along the common edge, and by the distance of either square from that edge.
    """
    d = np.arange(-1, n + 1, dtype=np.longdouble)
    r = np.arange(n + 1, dtype=np.longdouble)
    g = perpendicular_corner(d[:, None, None], np.hypot(r[:, None], r[None, :])[None])
    return np.diff(np.diff(second_difference(g, 0), axis=1), axis=2).astype(float)


def second_difference(values: NDArray[np.longdouble], axis: int) -> NDArray[np.longdouble]:
    """2 f(d) - f(d - 1) - f(d + 1)."""
    return -np.diff(values, 2, axis=axis)


def parallel_corner(u: NDArray[np.longdouble], v: NDArray[np.longdouble], gap: np.longdouble) -> NDArray[np.longdouble]:
    """Corner function of parallel aligned rectangles; Ehlert and Smith 1993, Howell's catalogue C-13."""
    p, q = np.hypot(u, gap), np.hypot(v, gap)
    g = v * p * np.arctan(v / p) + u * q * np.arctan(u / q) - gap**2 / 2 * np.log(u**2 + v**2 + gap**2)
    return g / (2 * np.arctan2(np.longdouble(0), np.longdouble(-1)))


def perpendicular_corner(d: NDArray[np.longdouble], r: NDArray[np.longdouble]) -> NDArray[np.longdouble]:
    """Corner function of perpendicular aligned rectangles; Ehlert and Smith 1993, Howell's catalogue C-14.

    ``d`` is the offset along the common edge, ``r`` the hypotenuse of the distances from it.
    """
    square = r**2 + d**2
    log = np.log(np.where(square > 0, square, 1))
    g = d * r * np.arctan2(d, r) - (r**2 - d**2) * log / 4
    return g / (2 * np.arctan2(np.longdouble(0), np.longdouble(-1)))
