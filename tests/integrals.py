"""Form factors straight from their definition: cos cos / (pi r^2) summed over points of both surfaces.

Gauss-Legendre points along straight directions and equal steps around circles, so smooth integrands are exact to
rounding. Where surfaces touch, coordinates are chosen in which the integrand is smooth.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

Array = np.ndarray


class Surface(NamedTuple):
    """Points (n, 3), unit normals (n, 3) and the area that each point stands for (n,)."""

    points: Array
    normals: Array
    areas: Array


def gauss(start: float, end: float, n: int) -> tuple[Array, Array]:
    """Points and weights on an interval."""
    x, w = np.polynomial.legendre.leggauss(n)
    return start + (end - start) * (1 + x) / 2, w * (end - start) / 2


def integral(function: Callable[..., Array], *ends: tuple[float, float], n: int = 40) -> float:
    """Of a function of one to three variables over a box."""
    rules = [gauss(*pair, n) for pair in ends]
    grid = np.meshgrid(*(x for x, _ in rules), indexing="ij")
    weights = np.meshgrid(*(w for _, w in rules), indexing="ij")
    return float(np.sum(np.prod(weights, axis=0) * function(*grid)))


def rectangle(origin: object, u: object, v: object, n: int = 20) -> Surface:
    """A parallelogram whose normal is u x v."""
    o, u, v = (np.asarray(x, float) for x in (origin, u, v))
    s, w = gauss(0, 1, n)
    points = o + s[:, None, None] * u + s[:, None] * v
    across = np.cross(u, v)
    return _surface(points, across, np.outer(w, w) * np.linalg.norm(across))


def triangle(a: object, b: object, c: object, n: int = 24) -> Surface:
    """A triangle whose normal is (b - a) x (c - a)."""
    a, b, c = (np.asarray(x, float) for x in (a, b, c))
    s, w = gauss(0, 1, n)
    points = a + s[:, None, None] * ((b - a) + s[:, None] * (c - b))
    across = np.cross(b - a, c - a)
    return _surface(points, across, np.outer(w * s, w) * np.linalg.norm(across))


def ring(centre: object, axis: object, inner: float, outer: float, n: int = 20, m: int = 48) -> Surface:
    """A flat ring, or a disk, whose normal is the axis."""
    e, f, axis = _frame(axis)
    r, w = gauss(inner, outer, n)
    turn = 2 * np.pi * np.arange(m) / m
    points = np.asarray(centre, float) + r[:, None, None] * (np.cos(turn)[:, None] * e + np.sin(turn)[:, None] * f)
    return _surface(points, axis, np.outer(w * r, np.full(m, 2 * np.pi / m)))


def side(radius: float, start: float, end: float, n: int = 20, m: int = 48, outward: bool = False) -> Surface:
    """The side of a cylinder around the z axis, seen from inside or outside."""
    z, w = gauss(start, end, n)
    turn = 2 * np.pi * np.arange(m) / m
    radial = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=-1)
    points = radius * radial + z[:, None, None] * np.array([0.0, 0.0, 1.0])
    normals = np.broadcast_to(radial if outward else -radial, points.shape)
    return _surface(points, normals, np.outer(w, np.full(m, 2 * np.pi * radius / m)))


def cap(centre: object, axis: object, radius: float, height: float, n: int = 20, m: int = 48) -> Surface:
    """The inside of a spherical cap around an axis."""
    e, f, axis = _frame(axis)
    level, w = gauss(radius - height, radius, n)
    turn = 2 * np.pi * np.arange(m) / m
    wide = np.sqrt(radius**2 - level**2)
    points = wide[:, None, None] * (np.cos(turn)[:, None] * e + np.sin(turn)[:, None] * f)
    points = points + level[:, None, None] * axis
    return _surface(points + np.asarray(centre, float), -points, np.outer(w, np.full(m, 2 * np.pi * radius / m)))


def factor(one: Surface, two: Surface) -> float:
    """F_12 between surfaces that see all of each other."""
    total = 0.0
    for p, n, a in zip(*one, strict=True):
        total += a * point_factor(p, n, two)
    return total / float(np.sum(one.areas))


def point_factor(point: Array, normal: Array, two: Surface) -> float:
    """F_12 from an element; what is behind it or faces away does not count."""
    way = two.points - point
    r2 = np.sum(way**2, axis=-1)
    cosines = np.maximum(way @ np.asarray(normal, float), 0) * np.maximum(-np.sum(way * two.normals, axis=-1), 0)
    return float(np.sum(two.areas * cosines / r2**2) / np.pi)


def share(centre: object, two: Surface) -> float:
    """The share of all directions from a point that a surface fills: the factor from a sphere around that point."""
    way = two.points - np.asarray(centre, float)
    cosines = -np.sum(way * two.normals, axis=-1)
    return float(np.sum(two.areas * np.abs(cosines) / np.sum(way**2, axis=-1) ** 1.5) / (4 * np.pi))


def strip_factor(one: tuple[Array, Array], two: tuple[Array, Array], n: int = 40) -> float:
    """F_12 between infinitely long strips with the given ends, by cos cos / (2 r) over both segments."""
    (a, b), (c, d) = (tuple(np.asarray(end, float) for end in ends) for ends in (one, two))
    s, w = gauss(0, 1, n)
    p, q = a + s[:, None] * (b - a), c + s[:, None] * (d - c)
    way = q[None] - p[:, None]
    r = np.linalg.norm(way, axis=-1)
    # |cross| of a way with a segment is r cos times its length.
    first = np.abs(way[..., 0] * (b - a)[1] - way[..., 1] * (b - a)[0])
    second = np.abs(way[..., 0] * (d - c)[1] - way[..., 1] * (d - c)[0])
    return float(w @ (first * second / (2 * r**3)) @ w / np.linalg.norm(b - a))


def cone(half_angle: float, tilt: float, n: int = 60) -> float:
    """The factor to all directions within an angle of an axis, cut at the horizon of the element."""

    def ring(a: Array) -> Array:
        low = np.clip(-np.cos(tilt) * np.cos(a) / np.maximum(np.sin(tilt) * np.sin(a), 1e-300), -1, 1)
        reach = np.arccos(low)
        x, w = gauss(0, 1, n)
        turn = reach[..., None] * x
        level = np.cos(tilt) * np.cos(a)[..., None] + np.sin(tilt) * np.sin(a)[..., None] * np.cos(turn)
        return 2 * np.sin(a) * reach * np.sum(w * np.maximum(level, 0), axis=-1) / np.pi

    # Beyond the angle at which the cone touches the horizon it is cut; the square root there needs squared steps.
    touch = min(abs(np.pi / 2 - tilt), half_angle)
    whole = integral(ring, (0, touch), n=n)
    cut = integral(lambda t: ring(touch + (half_angle - touch) * t**2) * 2 * t * (half_angle - touch), (0, 1), n=n)
    return whole + cut


def wedge(a: float, b: float, c: float, angle: float, n: int = 60) -> float:
    """F_12 between rectangles a x c and b x c with common edge c at an angle.

    The integral over positions along the edge is over their difference u with weight 2 (c - u). What remains is over a
    box with a singular corner; pyramids with their tip there make it smooth.
    """

    def pyramid(s: Array, p: Array, q: Array, face: int) -> Array:
        x, z, u = (
            coordinate * size
            for coordinate, size in zip(np.roll([s, s * p, s * q], face, axis=0), (a, b, c), strict=True)
        )
        r2 = x**2 + z**2 - 2 * x * z * np.cos(angle) + u**2
        return s**2 * a * b * c * np.sin(angle) ** 2 * x * z * 2 * (c - u) / (np.pi * r2**2)

    cube = [(0.0, 1.0)] * 3
    return sum(integral(lambda s, p, q, f=face: pyramid(s, p, q, f), *cube, n=n) for face in range(3)) / (a * c)


def bent_strips(a: float, b: float, angle: float, n: int = 60) -> float:
    """F_12 between infinitely long strips a and b that share an edge."""

    def corner(s: Array, t: Array, x: float, y: float) -> Array:
        r2 = x**2 + (y * t) ** 2 - 2 * x * y * t * np.cos(angle)
        return x * y * np.sin(angle) ** 2 * x * y * t / (2 * r2**1.5) + 0 * s

    square = [(0.0, 1.0)] * 2
    halves = ((a, b), (b, a))
    return sum(integral(lambda s, t, x=x, y=y: corner(s, t, x, y), *square, n=n) for x, y in halves) / a


def around_axis(radius: float, one: tuple[float, float], two: tuple[float, float], reach: float = np.pi) -> float:
    """F_12 between sections of the inside of a cylinder, over differences of azimuth up to ``reach``.

    Along the axis 1 / (c^2 + z^2)^2 is integrated twice: z arctan(z / c) / (2 c^3).
    """

    def twice(z: float, c: Array) -> Array:
        return z * np.arctan(z / c) / (2 * c**3)

    def azimuth(turn: Array) -> Array:
        c = 2 * radius * np.sin(turn / 2)
        (a, b), (d, e) = one, two
        heights = twice(e - a, c) - twice(e - b, c) - twice(d - a, c) + twice(d - b, c)
        return 2 * radius * (c**2 / 2) ** 2 / (np.pi * radius**2) * heights

    return integral(azimuth, (0, reach), n=120) / (one[1] - one[0])


def _frame(axis: object) -> tuple[Array, Array, Array]:
    """Two unit vectors across an axis, and the axis as a unit vector."""
    axis = np.asarray(axis, float) / np.linalg.norm(axis)
    e = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    e /= np.linalg.norm(e)
    return e, np.cross(axis, e), axis


def _surface(points: Array, normals: object, areas: Array) -> Surface:
    """Flattened, with normals of unit length."""
    normals = np.broadcast_to(np.asarray(normals, float), points.shape)
    normals = normals / np.linalg.norm(normals, axis=-1, keepdims=True)
    return Surface(points.reshape(-1, 3), normals.reshape(-1, 3), areas.ravel())
