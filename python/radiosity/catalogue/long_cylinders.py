"""Infinitely long cylinders: side by side, over a strip, in a row, one in another."""

from __future__ import annotations

import numpy as np

from radiosity.catalogue.arguments import Factor, Floats, Interval, Length, answer, interval, positive, require
from radiosity.catalogue.registry import configuration


@configuration(
    "", "infinite cylinder to parallel cylinder", 0.11069596963167251, radius_1=1.0, radius_2=1.0, distance=3.0
)
def parallel_cylinders(*, radius_1: Length, radius_2: Length, distance: Length) -> Factor:
    """F_12 from the outside of an infinitely long cylinder to that of another, parallel to it.

    Args:
        radius_1, radius_2: of the cylinders, m.
        distance: of the axes, at least the sum of the radii, m.

    Source: Hottel 1954, crossed strings. Relative accuracy about 1e-14, 1e-13 of cylinders that nearly touch.

    Raises:
        ValueError: a size that is not positive, or cylinders that overlap.
    """
    one, two, d = positive(radius_1=radius_1, radius_2=radius_2, distance=distance)
    require(d >= one + two, "distance must be at least radius_1 + radius_2: it is measured between the axes")
    a, b = np.minimum(one, two), np.maximum(one, two)
    outer, inner = np.sqrt((d - a - b) * (d + a + b)), np.sqrt((d - b + a) * (d + b - a))
    cross, open_ = np.arctan2(a + b, outer), np.arctan2(b - a, inner)
    # The inner tangents turn by cross, the outer by open; sin and cos of their difference, times d^2:
    turn = np.arctan2(4 * a * b * d**2 / ((a + b) * inner + (b - a) * outer), outer * inner + (b - a) * (b + a))
    strings = a * (cross + open_) + b * turn - 4 * a * b / (outer + inner)
    return answer(strings / (2 * np.pi * one))


@configuration("C-62", "infinite strip to parallel cylinder", 0.32175055439664219, strip=(1.0, 2.0), height=1.0,
               radius=1.0)  # fmt: skip
def strip_to_cylinder(*, strip: Interval, height: Length, radius: Length) -> Factor:
    """F_12 from an infinitely long strip to a parallel cylinder above its plane.

    Args:
        strip: where the strip starts and ends across its length, from straight below the axis, m.
        height: of the axis above the plane of the strip, at least ``radius``, m.
        radius: of the cylinder, m.

    Source: Howell C-62, and C-61 for a strip that is centred; Feingold and Gupta 1970. Relative accuracy about 1e-15.

    Raises:
        ValueError: a strip that does not start before it ends, a size that is not positive, or a cylinder that cuts
            the plane of the strip.
    """
    start, end = interval(strip=strip)
    h, r = positive(height=height, radius=radius)
    require(h >= r, "height must be at least radius: it is measured to the axis")
    return answer(r * np.arctan2(h * (end - start), h**2 + start * end) / (end - start))


@configuration("C-7", "infinite plane to a row of parallel tubes", 0.6575733718138601, diameter=1.0, pitch=2.0)
def plane_to_tube_row(*, diameter: Length, pitch: Length) -> Factor:
    """F_12 from an infinite plane to one row of infinitely long tubes that are parallel to it and to each other.

    Args:
        diameter: of the tubes, m.
        pitch: distance of their axes, at least ``diameter``, m.

    Source: Howell C-7 for one row; Hottel 1931. Relative accuracy about 1e-15. The rest passes between the tubes.

    Raises:
        ValueError: a size that is not positive, or tubes that overlap.
    """
    d, p = positive(diameter=diameter, pitch=pitch)
    require(p >= d, "pitch must be at least diameter: it is measured between the axes")
    x = d / p
    gap = np.sqrt((1 - x) * (1 + x))
    return answer(x * (x / (1 + gap) + np.arctan2(gap, x)))


@configuration("", "infinite outer cylinder to enclosed cylinder", 0.5, inner_radius=1.0, outer_radius=2.0)
def long_outer_cylinder_to_inner(*, inner_radius: Length, outer_radius: Length) -> Factor:
    """F_21 from the inside of an infinitely long cylinder to another within it; the inner sees nothing but the outer.

    Args:
        inner_radius, outer_radius: of the cylinders, m. They need not share their axis.

    Source: reciprocity. Exact.

    Raises:
        ValueError: a radius that is not positive, or an inner one that exceeds the outer.
    """
    return answer(_radii(inner_radius, outer_radius))


@configuration(
    "", "infinite outer cylinder to itself around enclosed cylinder", 0.5, inner_radius=1.0, outer_radius=2.0
)
def long_outer_cylinder_to_itself(*, inner_radius: Length, outer_radius: Length) -> Factor:
    """F_22 from the inside of an infinitely long cylinder to itself, past a cylinder within it.

    Args:
        inner_radius, outer_radius: of the cylinders, m. They need not share their axis.

    Source: closure. Exact where the radii differ.

    Raises:
        ValueError: a radius that is not positive, or an inner one that exceeds the outer.
    """
    return answer(1 - _radii(inner_radius, outer_radius))


def _radii(inner_radius: Length, outer_radius: Length) -> Floats:
    """The ratio of two radii that must not exceed 1."""
    inner, outer = positive(inner_radius=inner_radius, outer_radius=outer_radius)
    require(inner <= outer, "inner_radius must not exceed outer_radius: exchange them")
    ratio: Floats = inner / outer
    return ratio
