"""Infinitely long strips: everything that two-dimensional geometry and Hottel's strings can say."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from radiosity.catalogue.arguments import (
    Angle,
    Factor,
    Floats,
    Interval,
    Length,
    answer,
    finite,
    interval,
    nonnegative,
    positive,
    require,
    within,
)
from radiosity.catalogue.registry import configuration

Plane = npt.NDArray[np.complexfloating[Any, Any]]
"""Points of the plane across the strips, x + i y."""


@configuration("C-1", "infinite strip to equal strip, directly opposed", np.sqrt(2.0) - 1, width=1.0, gap=1.0)
def equal_parallel_strips(*, width: Length, gap: Length) -> Factor:
    """F_12 between two infinitely long strips of one width, directly opposite in parallel planes.

    Args:
        width: of both, m.
        gap: distance of the planes, m.

    Source: Howell C-1; Hottel's crossed strings. Relative accuracy about 1e-15.

    Raises:
        ValueError: a size that is not positive.
    """
    w, h = positive(width=width, gap=gap)
    return answer(w / (h + np.hypot(w, h)))


@configuration("C-2", "infinite strip to parallel strip of another width, centred", 0.5 * (13**0.5 - 5**0.5),
               width_1=1.0, width_2=2.0, gap=1.0)  # fmt: skip
def coaxial_strips(*, width_1: Length, width_2: Length, gap: Length) -> Factor:
    """F_12 between infinitely long strips in parallel planes, the middle of one straight above that of the other.

    Args:
        width_1, width_2: of the strips, m.
        gap: distance of the planes, m.

    Source: Howell C-2; Hottel's crossed strings. Relative accuracy about 1e-15.

    Raises:
        ValueError: a size that is not positive.
    """
    a, b, h = positive(width_1=width_1, width_2=width_2, gap=gap)
    return answer(2 * b / (np.hypot(a + b, 2 * h) + np.hypot(a - b, 2 * h)))


@configuration("C-2a", "infinite strip to parallel strip anywhere", 0.23779660173108116,
               x_1=(0.0, 1.0), x_2=(1.0, 2.5), gap=1.0)  # fmt: skip
def parallel_strips(*, x_1: Interval, x_2: Interval, gap: Length) -> Factor:
    """F_12 between infinitely long strips in parallel planes, anywhere.

    Args:
        x_1, x_2: where each strip starts and ends across its length, m.
        gap: distance of the planes, m.

    Source: Howell C-2a; Hottel's crossed strings. Relative accuracy about 1e-14 where the view is not grazing.

    Raises:
        ValueError: an interval that does not start before it ends, or a gap that is not positive.
    """
    a, b = interval(x_1=x_1)
    c, d = interval(x_2=x_2)
    (h,) = positive(gap=gap)
    return answer(_exchange(a + 0j, b + 0j, c + 1j * h, d + 1j * h) / (b - a))


@configuration("C-5", "infinite strip to strip with common edge, at any angle", 1 - np.sqrt(0.5),
               width_1=1.0, width_2=1.0, angle=np.pi / 2)  # fmt: skip
def strips_with_common_edge(*, width_1: Length, width_2: Length, angle: Angle) -> Factor:
    """F_12 between infinitely long strips that share an edge, like an open book.

    Args:
        width_1, width_2: of the strips, m.
        angle: between their inner faces, 0 to pi.

    Source: Howell C-5, of which C-3 is the right angle and C-4 the case of equal widths, 1 - sin(angle / 2); Hottel's
    crossed strings. Relative accuracy about 1e-15.

    Raises:
        ValueError: a size that is not positive, or an angle outside 0 to pi.
    """
    a, b = positive(width_1=width_1, width_2=width_2)
    (phi,) = within(0.0, np.pi, angle=angle)
    third = np.hypot(a - b, 2 * np.sqrt(a * b) * np.sin(phi / 2))
    return answer(2 * b * np.cos(phi / 2) ** 2 / (a + b + third))


@configuration("C-5a", "infinite strip to strip in a plane at any angle, without common edge", 0.12314723089546506,
               u_1=(0.5, 1.5), u_2=(1.0, 2.0), angle=np.pi / 2)  # fmt: skip
def strips_at_angle(*, u_1: Interval, u_2: Interval, angle: Angle) -> Factor:
    """F_12 between infinitely long strips whose planes meet in a line parallel to both.

    Args:
        u_1, u_2: where each strip starts and ends, as distances from that line, m.
        angle: between the inner faces, above 0 and below pi.

    Source: Howell C-5a; Hottel's crossed strings. Relative accuracy about 1e-14 where the view is not grazing.

    Raises:
        ValueError: an interval that does not start before it ends or reaches below 0, or an angle outside 0 to pi.
    """
    a, b = interval(0.0, u_1=u_1)
    c, d = interval(0.0, u_2=u_2)
    (phi,) = within(0.0, np.pi, angle=angle)
    turn = np.exp(1j * phi)
    return answer(_exchange(a + 0j, b + 0j, c * turn, d * turn) / (b - a))


@configuration("", "infinite surface to infinite surface by crossed strings", 1 / 3,
               crossed=(5.0, 5.0), uncrossed=(4.0, 4.0), width=3.0)  # fmt: skip
def crossed_strings(*, crossed: Interval, uncrossed: Interval, width: Length) -> Factor:
    """F_12 between any two infinitely long surfaces, by the lengths of strings stretched between their edges.

    Strings are taut: they go around what stands in the way, and around surface 1 or 2 itself where it bulges.

    Args:
        crossed: lengths of the two strings that join opposite edges, m.
        uncrossed: lengths of the two that join edges of the same side, m.
        width: length of the outline of surface 1 (of a string across it where it is hollow), m.

    Source: Hottel 1954. The difference of the sums loses digits where the surfaces are far apart for their widths.

    Raises:
        ValueError: negative lengths, a width that is not positive, or crossed strings shorter than the uncrossed.
    """
    p, q = nonnegative(**{"first of crossed": crossed[0], "second of crossed": crossed[1]})
    r, s = nonnegative(**{"first of uncrossed": uncrossed[0], "second of uncrossed": uncrossed[1]})
    (w,) = positive(width=width)
    require(p + q >= r + s, "crossed strings must be at least as long as uncrossed ones: exchange the two pairs")
    return answer((p + q - r - s) / (2 * w))


@configuration("", "side to side of a long three-sided duct", 1 / 3, side_1=3.0, side_2=4.0, side_3=5.0)
def triangular_duct(*, side_1: Length, side_2: Length, side_3: Length) -> Factor:
    """F_12 between two sides of an infinitely long duct of three plane or bulging sides.

    Args:
        side_1, side_2, side_3: widths of the sides (lengths of their outlines), m.

    Source: Hottel 1954; closure and reciprocity leave no other answer.

    Raises:
        ValueError: a size that is not positive, or sides 1 and 2 too short to make a triangle with side 3.
    """
    a, b, c = positive(side_1=side_1, side_2=side_2, side_3=side_3)
    closes = (a + b >= c) & (b + c >= a) & (c + a >= b)
    require(closes, "side_1, side_2 and side_3 must make a triangle: no side longer than the other two together")
    return answer((a + b - c) / (2 * a))


@configuration("", "segment to segment in the plane: long strips by their cross-sections", 0.12314723089546505,
               start_1=(0.5, 0.0), end_1=(1.5, 0.0), start_2=(0.0, 2.0), end_2=(0.0, 1.0))  # fmt: skip
def segments(*, start_1: Length, end_1: Length, start_2: Length, end_2: Length) -> Factor:
    """F_12 between infinitely long strips given by their cross-sections, two segments in the plane.

    Args:
        start_1, end_1, start_2, end_2: (..., 2) ends of the segments, m. Each segment faces to the left of the way
            from its start to its end, and all of each must be in front of the other.

    Source: Hottel 1954, crossed strings. Relative accuracy about 1e-14 where the view is not grazing.

    Raises:
        ValueError: points without x and y along the last axis, a segment without length, or one that reaches behind
            the other.
    """
    values = finite(start_1=start_1, end_1=end_1, start_2=start_2, end_2=end_2)
    for name, value in zip(("start_1", "end_1", "start_2", "end_2"), values, strict=True):
        require(value.ndim > 0 and value.shape[-1] == 2, f"{name} must have x and y along its last axis, (..., 2)")
    a, b, c, d = (value[..., 0] + 1j * value[..., 1] for value in values)
    require((a != b) & (c != d), "start_1 and end_1, start_2 and end_2 must differ: a segment has a length")
    inside = -1e-12 * np.maximum(abs(b - a), abs(d - c)) * np.maximum(abs(a - c), abs(b - d))
    ahead = [((p - o) / (e - o)).imag * abs(e - o) ** 2 >= inside for o, e, p in _ends(a, b, c, d)]
    require(np.all(ahead), "one segment reaches behind the other: cut it there, or exchange start and end to turn it")
    return answer(_exchange(a, b, d, c) / abs(b - a))


def _ends(a: Plane, b: Plane, c: Plane, d: Plane) -> list[tuple[Plane, Plane, Plane]]:
    """Start and end of one segment with an end of the other, four times."""
    return [(a, b, c), (a, b, d), (c, d, a), (c, d, b)]


def _exchange(a: Plane, b: Plane, c: Plane, d: Plane) -> Floats:
    """Half of crossed less uncrossed strings between segments a b and c d, points of the complex plane.

    a is beside c and b beside d. (p + q)^2 - (r + s)^2 is taken apart until no large terms cancel, with
    (d - a)(c - b) - (c - a)(d - b) = (b - a)(c - d).
    """
    crossed, uncrossed = (d - a) * (c - b), (c - a) * (d - b)
    strings = abs(d - a) + abs(c - b) + abs(c - a) + abs(d - b)
    squares = ((b - a) * np.conj(d - c)).real
    products = ((b - a) * (c - d) * np.conj(crossed + uncrossed)).real / (abs(crossed) + abs(uncrossed))
    half: Floats = (squares + products) / strings
    return half
