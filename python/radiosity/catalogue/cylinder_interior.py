"""The inside of a right circular cylinder: bases, side, and sections of either."""

from __future__ import annotations

import numpy as np

from radiosity.catalogue.arguments import (
    Factor,
    Floats,
    Interval,
    Length,
    answer,
    interval,
    nonnegative,
    positive,
    require,
)
from radiosity.catalogue.registry import configuration


@configuration("C-79", "base of cylinder to its side", (5**0.5 - 1) / 2, radius=1.0, height=1.0)
def cylinder_base_to_side(*, radius: Length, height: Length) -> Factor:
    """F_12 from a base of a cylinder to the inside of its side; the other base takes the rest (C-40).

    Args:
        radius, height: of the cylinder, m.

    Source: Howell C-79; closure with C-40. Relative accuracy about 1e-15.

    Raises:
        ValueError: a size that is not positive.
    """
    h = _half_slender(radius, height)
    return answer(2 * h * _base(h))


@configuration("", "side of cylinder to its base", (5**0.5 - 1) / 4, radius=1.0, height=1.0)
def cylinder_side_to_base(*, radius: Length, height: Length) -> Factor:
    """F_21 from the inside of the side of a cylinder to one of its bases.

    Args:
        radius, height: of the cylinder, m.

    Source: reciprocity with Howell C-79. Relative accuracy about 1e-15.

    Raises:
        ValueError: a size that is not positive.
    """
    return answer(0.5 * _base(_half_slender(radius, height)))


@configuration("C-78", "side of cylinder to itself", (3 - 5**0.5) / 2, radius=1.0, height=1.0)
def cylinder_side_to_itself(*, radius: Length, height: Length) -> Factor:
    """F_22 from the inside of the side of a cylinder to itself.

    Args:
        radius, height: of the cylinder, m.

    Source: Howell C-78; Buckley 1927. Relative accuracy about 1e-15.

    Raises:
        ValueError: a size that is not positive.
    """
    h = _half_slender(radius, height)
    return answer(h * (1 - h / (1 + np.hypot(1.0, h))))


@configuration(
    "C-81",
    "section of cylinder's side to a disk across the cylinder",
    0.10519656799814761,
    radius=1.0,
    section=(1.0, 2.0),
)
def cylinder_section_to_disk(*, radius: Length, section: Interval) -> Factor:
    """F_12 from a section of the inside of a cylinder's side to a disk that fills the cylinder; also to a base.

    Args:
        radius: of the cylinder, m.
        section: where the section starts and ends, as distances from the disk along the axis, m.

    Source: Howell C-81; factor algebra on C-40. Relative accuracy about 1e-15, also of thin sections. The limit of no
    length is :func:`cylinder_ring_to_disk`.

    Raises:
        ValueError: a radius that is not positive, or a section that does not start before it ends or starts below 0.
    """
    (r,) = positive(radius=radius)
    start, end = interval(0.0, section=section)
    return answer(_section_to_disk(0.5 * start / r, 0.5 * end / r))


@configuration("B-93", "ring element of cylinder's side to a disk across the cylinder", 0.17082039324993692,
               radius=1.0, distance=1.0)  # fmt: skip
def cylinder_ring_to_disk(*, radius: Length, distance: Length) -> Factor:
    """F_12 from an element of the inside of a cylinder's side, or a ring of them, to a disk that fills the cylinder.

    Args:
        radius: of the cylinder, m.
        distance: from the element to the plane of the disk, m; 0 at its rim.

    Source: Howell B-93, and B-52 of a point; Buckley 1927. Relative accuracy about 1e-15.

    Raises:
        ValueError: a radius that is not positive, or a negative distance.
    """
    (r,) = positive(radius=radius)
    (z,) = nonnegative(distance=distance)
    h = 0.5 * z / r
    return answer(_section_to_disk(h, h))


@configuration(
    "B-51", "point of cylinder's side to the whole side", 0.6042948436682508, radius=1.0, height=2.0, position=0.5
)
def cylinder_point_to_side(*, radius: Length, height: Length, position: Length) -> Factor:
    """F_12 from an element of the inside of a cylinder's side to the whole side.

    Args:
        radius, height: of the cylinder, m.
        position: of the element above a base, at most ``height``, m.

    Source: Howell B-51; closure with B-52. Absolute accuracy about 1e-16.

    Raises:
        ValueError: a size that is not positive, or a position that is not between 0 and height.
    """
    r, h = positive(radius=radius, height=height)
    (z,) = nonnegative(position=position)
    require(z <= h, "position must not exceed height: the element is on the side")
    low, high = 0.5 * z / r, 0.5 * (h - z) / r
    return answer(1 - _section_to_disk(low, low) - _section_to_disk(high, high))


@configuration("", "section of cylinder's side to section of the side", 0.20382042637679987,
               radius=1.0, section_1=(0.0, 1.0), section_2=(1.0, 2.0))  # fmt: skip
def cylinder_section_to_section(*, radius: Length, section_1: Interval, section_2: Interval) -> Factor:
    """F_12 between sections of the inside of a cylinder's side: apart, adjacent, overlapping or the same.

    Args:
        radius: of the cylinder, m.
        section_1, section_2: where each starts and ends along the axis, m.

    Source: factor algebra on Howell C-40. Absolute accuracy of A_1 F_12 about 1e-15 of the area of a base.

    Raises:
        ValueError: a radius that is not positive, or a section that does not start before it ends.
    """
    (r,) = positive(radius=radius)
    a, b = (0.5 * end / r for end in interval(section_1=section_1))
    c, d = (0.5 * end / r for end in interval(section_2=section_2))
    steps = [abs(c - b), abs(c - a), abs(d - b), abs(d - a)]
    apart, meeting = (
        function(steps[0]) - function(steps[1]) - function(steps[2]) + function(steps[3])
        for function in (_base_to_base, _smooth)
    )
    return answer(np.where((b <= c) | (d <= a), apart, meeting) / (4 * (b - a)))


@configuration(
    "C-80", "disk in the base of a cylinder to its side", 0.5311288741492749, disk_radius=0.5, radius=1.0, height=1.0
)
def cylinder_disk_to_side(*, disk_radius: Length, radius: Length, height: Length) -> Factor:
    """F_12 from a disk in the middle of a cylinder's base to the inside of its side.

    Args:
        disk_radius: of the disk, at most ``radius``, m.
        radius, height: of the cylinder, m.

    Source: Howell C-80; closure with C-41. Relative accuracy about 1e-15.

    Raises:
        ValueError: a size that is not positive, or a disk larger than the base.
    """
    a, r, h = positive(disk_radius=disk_radius, radius=radius, height=height)
    require(a <= r, "disk_radius must not exceed radius: the disk lies in the base")
    return answer(_disk_to_side(a, r, h))


@configuration(
    "C-83",
    "ring in the base of a cylinder to its side",
    0.6470023602834347,
    inner=0.5,
    outer=1.0,
    radius=1.0,
    height=1.0,
)
def cylinder_ring_to_side(*, inner: Length, outer: Length, radius: Length, height: Length) -> Factor:
    """F_12 from a ring in a cylinder's base, around its axis, to the inside of its side.

    Args:
        inner, outer: radii of the ring, m. C-83 has outer = radius.
        radius, height: of the cylinder, m.

    Source: Howell C-83; factor algebra on C-80. Absolute accuracy about 1e-15 times the area of the base over that of
    the ring.

    Raises:
        ValueError: a size that is not positive (0 is allowed for inner), or radii that do not increase.
    """
    b, r, h = positive(outer=outer, radius=radius, height=height)
    (a,) = nonnegative(inner=inner)
    require(
        (a < b) & (b <= r), "inner must be below outer, and outer must not exceed radius: the ring lies in the base"
    )
    disks = b**2 * _disk_to_side(b, r, h) - a**2 * _disk_to_side(a, r, h)
    return answer(disks / ((b - a) * (b + a)))


def _half_slender(radius: Length, height: Length) -> Floats:
    """Height over diameter."""
    r, h = positive(radius=radius, height=height)
    ratio: Floats = 0.5 * h / r
    return ratio


def _base(h: Floats) -> Floats:
    """sqrt(1 + h^2) - h, whose square is base to base."""
    base: Floats = 1 / (np.hypot(1.0, h) + h)
    return base


def _base_to_base(h: Floats) -> Floats:
    """C-40 by height over diameter."""
    factor: Floats = _base(h) ** 2
    return factor


def _smooth(h: Floats) -> Floats:
    """C-40 less its value and slope at 0: the same second differences, but none of the kink there."""
    smooth: Floats = 2 * h**2 * (1 - h / (1 + np.hypot(1.0, h)))
    return smooth


def _section_to_disk(low: Floats, high: Floats) -> Floats:
    """(C-40(low) - C-40(high)) / (4 (high - low)), of distances from the disk over the diameter."""
    p, q = _base(low), _base(high)
    factor: Floats = 0.25 * p * q * (p + q) * (1 + (low + high) / (np.hypot(1.0, low) + np.hypot(1.0, high)))
    return factor


def _disk_to_side(a: Floats, r: Floats, h: Floats) -> Floats:
    """From a disk of radius a in the base of a cylinder to its side."""
    factor: Floats = 2 * h**2 / (np.hypot(h, r - a) * np.hypot(h, r + a) + h**2 + (r - a) * (r + a))
    return factor
