"""Rectangles to rectangles: parallel, perpendicular, hinged.

Corner sums are built from kernels that vanish wherever one of their arguments does, so that what would cancel is never
added. Where two rectangles are far apart for their size, the sum would still lose digits; there the definition is
integrated by Gauss-Legendre points, which is then exact to rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import product

import numpy as np
import numpy.typing as npt

from radiosity.catalogue.arguments import (
    Angle,
    Factor,
    Floats,
    Interval,
    Length,
    answer,
    interval,
    positive,
    require,
    within,
)
from radiosity.catalogue.registry import configuration

Kernel = Callable[[Floats, Floats, Floats, Floats], Floats]

FAR = 4.0
"""Distance of centres over the sum of half diagonals from which on Gauss-Legendre points replace a corner sum."""

POINTS = 8
"""Points per direction for them: the error of each direction is below (FAR + sqrt(FAR^2 - 1))^-16 = 5e-15."""


@configuration("C-11", "rectangle to equal parallel rectangle, directly opposed", 0.19982489569838746,
               width=1.0, length=1.0, gap=1.0)  # fmt: skip
def equal_parallel_rectangles(*, width: Length, length: Length, gap: Length) -> Factor:
    """F_12 from a rectangle to its equal, directly opposite in a parallel plane.

    Args:
        width, length: sides of both, m.
        gap: distance of the planes, m.

    Source: Howell C-11; Hamilton and Morgan 1952. Relative accuracy about 1e-14 for any proportions.

    Raises:
        ValueError: a size that is not positive.
    """
    a, b, c = positive(width=width, length=length, gap=gap)
    return answer(4 * _parallel_kernel(a, b, c) / (a * b))


@configuration("C-13", "rectangle to parallel rectangle anywhere, sides aligned", 0.04831493152345359,
               x_1=(0.0, 1.0), y_1=(0.0, 1.0), x_2=(1.0, 2.5), y_2=(0.5, 1.0), gap=1.0)  # fmt: skip
def parallel_rectangles(*, x_1: Interval, y_1: Interval, x_2: Interval, y_2: Interval, gap: Length) -> Factor:
    """F_12 from a rectangle to another in a parallel plane, anywhere, with sides along the same two axes.

    Args:
        x_1, y_1: where rectangle 1 starts and ends along x and y, m.
        x_2, y_2: the same of rectangle 2.
        gap: distance of the planes, m.

    Source: Howell C-13; Gross, Spindler and Hahn 1981; Ehlert and Smith 1993. A corner sum: its error in A_1 F_12 is
    about 1e-15 of the largest length squared, which shows relative to F_12 where rectangles are narrow for their
    distance; rectangles that are small in both directions for their distance keep a relative accuracy of 1e-12.

    Raises:
        ValueError: an interval that does not start before it ends, or a gap that is not positive.
    """
    sides = [interval(x_1=x_1), interval(y_1=y_1), interval(x_2=x_2), interval(y_2=y_2)]
    (c,) = positive(gap=gap)
    (x1, y1, x2, y2), c = _broadcast(sides, c)
    total = np.zeros(c.shape)
    for i, j, k, m in product(range(2), repeat=4):
        total += (-1) ** (i + j + k + m) * _parallel_kernel(np.abs(x1[i] - x2[k]), np.abs(y1[j] - y2[m]), c)
    far = _are_far([(x1, x2), (y1, y2)], c)
    if np.any(far):
        cut = [s[:, far] for s in (x1, y1, x2, y2)]
        g = c[far] ** 2
        total[far] = _integrated(cut, lambda x, v, y, w: g / ((x - v) ** 2 + (y - w) ** 2 + g) ** 2)
    return answer(total / (_size(x1) * _size(y1)))


@configuration("C-12", "square to parallel square of another size, centred", 0.517653079515534,
               edge_1=1.0, edge_2=2.0, gap=1.0)  # fmt: skip
def coaxial_squares(*, edge_1: Length, edge_2: Length, gap: Length) -> Factor:
    """F_12 from a square to a parallel square with sides along the same axes and the centre straight above.

    Args:
        edge_1, edge_2: edges of the squares, m.
        gap: distance of the planes, m.

    Source: Howell C-12; Crawford 1972. Accuracy as that of :func:`parallel_rectangles`.

    Raises:
        ValueError: a size that is not positive.
    """
    a, b, c = positive(edge_1=edge_1, edge_2=edge_2, gap=gap)
    return parallel_rectangles(
        x_1=(-a / 2, a / 2), y_1=(-a / 2, a / 2), x_2=(-b / 2, b / 2), y_2=(-b / 2, b / 2), gap=c
    )


@configuration("C-14", "rectangle to perpendicular rectangle, common edge", 0.20004377607540316,
               width_1=1.0, width_2=1.0, length=1.0)  # fmt: skip
def perpendicular_rectangles_with_common_edge(*, width_1: Length, width_2: Length, length: Length) -> Factor:
    """F_12 from a rectangle to a perpendicular one that shares an edge with it, as floor and wall.

    Args:
        width_1, width_2: how far each reaches from the common edge, m.
        length: the common edge, m.

    Source: Howell C-14; Hamilton and Morgan 1952. Relative accuracy about 1e-14 for any proportions.

    Raises:
        ValueError: a size that is not positive.
    """
    a, b, c = positive(width_1=width_1, width_2=width_2, length=length)
    return answer(_hinge_kernel(a, b, c) / (a * c))


@configuration("C-15", "rectangle to perpendicular rectangle anywhere, sides aligned", 0.06104061564092379,
               x_1=(0.5, 1.5), y_1=(0.0, 1.0), y_2=(0.5, 2.0), z_2=(0.25, 1.0))  # fmt: skip
def perpendicular_rectangles(*, x_1: Interval, y_1: Interval, y_2: Interval, z_2: Interval) -> Factor:
    """F_12 from a rectangle in the plane z = 0 to one in the plane x = 0, anywhere, with sides along the axes.

    Args:
        x_1, y_1: where rectangle 1 starts and ends along x, its distance from the other plane, and along y, m.
        y_2, z_2: where rectangle 2 starts and ends along y, and along z, its height above the plane of 1, m.

    Source: Howell C-15; Gross, Spindler and Hahn 1981; Ehlert and Smith 1993. A corner sum with the accuracy that
    :func:`parallel_rectangles` has.

    Raises:
        ValueError: an interval that does not start before it ends, or x_1 or z_2 that reach below 0, behind the
            other rectangle.
    """
    sides = [interval(0.0, x_1=x_1), interval(y_1=y_1), interval(y_2=y_2), interval(0.0, z_2=z_2)]
    (x1, y1, y2, z2), _ = _broadcast(sides, np.zeros(()))
    total = np.zeros(x1.shape[1:])
    for i, j, k, m in product(range(2), repeat=4):
        sign = (-1) ** (i + j + k + m + 1)
        total += sign * 0.5 * _hinge_kernel(x1[i], z2[m], np.abs(y1[j] - y2[k]))
    far = _are_far([(x1, np.zeros_like(x1)), (y1, y2), (np.zeros_like(z2), z2)], np.zeros(total.shape))
    if np.any(far):
        cut = [s[:, far] for s in (x1, y1, z2, y2)]
        total[far] = _integrated(cut, lambda x, z, y, v: x * z / (x**2 + z**2 + (y - v) ** 2) ** 2)
    return answer(total / (_size(x1) * _size(y1)))


@configuration("C-16", "rectangle to rectangle with common edge, at any angle", 0.37090532115005137,
               width_1=1.0, width_2=1.0, length=1.0, angle=np.pi / 3)  # fmt: skip
def hinged_rectangles(*, width_1: Length, width_2: Length, length: Length, angle: Angle) -> Factor:
    """F_12 from a rectangle to another that shares an edge with it, like the leaves of a hinge.

    Not closed in elementary functions: the double contour integral is, but for one smooth integral, which
    Gauss-Legendre points take to rounding. Absolute accuracy about 1e-13 of similar sides, 1e-12 where they differ
    by a factor of 100.

    Args:
        width_1, width_2: how far each reaches from the common edge, m.
        length: the common edge, m.
        angle: between the two inner faces, above 0 and up to pi.

    Source: Howell C-16, after Feingold 1966; evaluated by contour integration (Sparrow 1963).

    Raises:
        ValueError: a size that is not positive, or an angle outside 0 to pi.
    """
    a, b, c = positive(width_1=width_1, width_2=width_2, length=length)
    (phi,) = within(0.0, np.pi, angle=angle)
    require(phi > 0, "angle must be above 0: closed leaves see each other completely and need no formula")
    a, b, c, phi = np.broadcast_arrays(a, b, c, phi)
    r = np.hypot(a - b, 2 * np.sqrt(a * b) * np.sin(phi / 2))
    along = _facing_edges(a, c) + _facing_edges(b, c) - _facing_edges(r, c) - _facing_edges(np.zeros_like(a), c)
    across = a * _side_edges(a, b, c, phi) + b * _side_edges(b, a, c, phi)
    return answer((along + 2 * np.cos(phi) * across) / (2 * np.pi * a * c))


@configuration("C-9", "tilted plane to the ground below it", 0.14644660940672624, tilt=np.pi / 4)
def tilted_plane_to_ground(*, tilt: Angle) -> Factor:
    """F_12 from the upper face of a plane surface of any shape to an infinite ground that it is tilted against.

    Args:
        tilt: angle between the face and the ground, 0 where it looks straight up, pi where it looks straight down.

    Source: Howell C-9. The rest, cos(tilt / 2)^2, goes to the sky.

    Raises:
        ValueError: a tilt outside 0 to pi.
    """
    (tau,) = within(0.0, np.pi, tilt=tilt)
    return answer(np.sin(tau / 2) ** 2)


def _parallel_kernel(x: Floats, y: Floats, z: Floats) -> Floats:
    """A quarter of the exchange A F between opposed x by y rectangles at distance z; zero for x = 0 and y = 0."""
    X, Y = x / z, y / z
    total = 0.5 * np.log1p(X**2 * (Y**2 / (1 + X**2 + Y**2))) + _edge_term(X, Y) + _edge_term(Y, X)
    kernel: Floats = z**2 * total / (2 * np.pi)
    return kernel


def _edge_term(X: Floats, Y: Floats) -> Floats:
    """X s atan(X / s) - X atan X with s = sqrt(1 + Y^2), of terms of the size of the result."""
    s = np.hypot(1.0, Y)
    excess = Y * (Y / (1 + s))  # s - 1
    term: Floats = X * (excess * np.arctan(X / s) - np.arctan2(X * excess, s + X**2))
    return term


def _hinge_kernel(x: Floats, z: Floats, u: Floats) -> Floats:
    """The exchange A F of perpendicular rectangles x by u and z by u with common edge u; zero where one of them is."""
    x, z, u = np.broadcast_arrays(x, z, u)
    scale = np.maximum(np.maximum(x, z), u)
    # Squares of what is narrower than this vanish.
    empty = np.minimum(np.minimum(x, z), u) <= 1e-150 * scale
    x, z, u = (np.where(empty, 1.0, side) / np.where(empty, 1.0, scale) for side in (x, z, u))
    low, high, r = np.minimum(x, z), np.maximum(x, z), np.hypot(x, z)
    d = low * (low / (r + high))  # r - high
    angles = low * np.arctan2(u, low) - d * np.arctan2(u, r) + high * np.arctan2(d * u, high * r + u**2)
    rise = u**2 * np.log1p((x / u) ** 2 * (z**2 / (u**2 + r**2)))
    logs = rise + _fallen_log(x, u, z) + _fallen_log(z, u, x)
    exchange = scale**2 * (u * angles + 0.25 * logs) / np.pi
    return np.where(empty, 0.0, exchange)


def _fallen_log(p: Floats, q: Floats, s: Floats) -> Floats:
    """p^2 ln of p^2 (p^2 + q^2 + s^2) / ((p^2 + q^2) (p^2 + s^2)), which is at most 1."""
    pq, ps = p**2 + q**2, p**2 + s**2
    drop = (q**2 / pq) * (s**2 / ps)
    near = np.log1p(-np.minimum(drop, 0.5))
    logs: Floats = p**2 * np.where(drop < 0.5, near, np.log(p**2 * ((pq + s**2) / (pq * ps))))
    return logs


def _facing_edges(d: Floats, c: Floats) -> Floats:
    """The integral of ln r over two parallel edges of length c at distance d, without 3/2 c^2, which cancels."""
    squares = d**2 + c**2
    edges: Floats = (
        0.5 * (c**2 - d**2) * np.log(squares) + d**2 * np.log(np.where(d > 0, d, 1.0)) + 2 * c * d * np.arctan2(c, d)
    )
    return edges


def _side_edges(a: Floats, b: Floats, c: Floats, phi: Floats) -> Floats:
    """The integral over xi from 0 to b of (M(r) / r^2), r from the point a on one leaf to xi on the other.

    M is the integral of 1/2 ln(1 + c^2 / s^2) s ds from 0 to r. With xi = a (cos phi + sin phi sinh t) it is analytic
    for |Im t| < pi / 2, so 128 points suffice.
    """
    nodes, weights = _gauss(128)
    sine = np.maximum(np.sin(phi), 1e-9)
    low, high = np.arcsinh(-np.cos(phi) / sine), np.arcsinh((b / a - np.cos(phi)) / sine)
    half = 0.5 * (high - low)
    r = a * sine * np.cosh(low + np.multiply.outer(1 + nodes, half))
    q = (c / r) ** 2
    total: Floats = 0.25 * half * np.einsum("a,a...->...", weights, r * (np.log1p(q) + q * np.log1p(1 / q)))
    return total


@cache
def _gauss(n: int) -> tuple[Floats, Floats]:
    """Gauss-Legendre points and weights on [-1, 1]."""
    nodes, weights = np.polynomial.legendre.leggauss(n)
    return nodes, weights


def _size(ends: Floats) -> Floats:
    """Length of intervals (2, ...)."""
    length: Floats = ends[1] - ends[0]
    return length


def _broadcast(sides: list[list[Floats]], gap: Floats) -> tuple[list[Floats], Floats]:
    """Intervals as arrays (2, ...) of one common shape, and the gap in that shape."""
    flat = np.broadcast_arrays(*(end for side in sides for end in side), gap)
    return [np.stack(flat[k : k + 2]) for k in range(0, len(flat) - 1, 2)], flat[-1].copy()


def _are_far(pairs: list[tuple[Floats, Floats]], gap: Floats) -> npt.NDArray[np.bool_]:
    """Whether two boxes, given by pairs of intervals along each axis, are far apart for their size."""
    apart = gap**2 + sum((0.5 * (one.sum(axis=0) - two.sum(axis=0))) ** 2 for one, two in pairs)
    halves = [np.sqrt(sum((0.5 * _size(pair[k])) ** 2 for pair in pairs)) for k in (0, 1)]
    far: npt.NDArray[np.bool_] = np.sqrt(apart) > FAR * (halves[0] + halves[1])
    return far


def _integrated(sides: list[Floats], kernel: Kernel) -> Floats:
    """The exchange A F of rectangles u_1 by v_1 and u_2 by v_2: Gauss-Legendre points on the definition.

    ``sides`` are u_1, v_1, u_2 and v_2, (2, n) each; ``kernel(u_1, u_2, v_1, v_2)`` is cos cos / r^2.
    """
    nodes, weights = _gauss(POINTS)
    shares = 0.5 * (1 + nodes[:, None])
    u1, v1, u2, v2 = (side[0] + shares * _size(side) for side in sides)
    pairs = 0.25 * np.outer(weights, weights)
    total = np.zeros(sides[0].shape[1])
    for i, j in product(range(POINTS), repeat=2):
        values = kernel(u1[i], u2[j], v1[:, None], v2[None])
        total += pairs[i, j] * np.einsum("ab,abn->n", pairs, values)
    exchange: Floats = total * np.prod([_size(side) for side in sides], axis=0) / np.pi
    return exchange
