"""Disks and rings to disks and rings: coaxial, or on one sphere."""

from __future__ import annotations

import numpy as np

from radiosity.catalogue.arguments import (
    Angle,
    Factor,
    Floats,
    Length,
    answer,
    finite,
    nonnegative,
    positive,
    require,
    within,
)
from radiosity.catalogue.registry import configuration


@configuration("C-41", "disk to coaxial parallel disk", (3 - 5**0.5) / 2, radius_1=1.0, radius_2=1.0, gap=1.0)
def coaxial_disks(*, radius_1: Length, radius_2: Length, gap: Length) -> Factor:
    """F_12 from a disk to a parallel disk on the same axis; also base to base of a cylinder or frustum.

    Args:
        radius_1, radius_2: of the disks, m.
        gap: distance of the planes, m.

    Source: Howell C-41, and C-40 for equal disks; Hamilton and Morgan 1952. Relative accuracy about 1e-15.

    Raises:
        ValueError: a size that is not positive.
    """
    a, b, h = positive(radius_1=radius_1, radius_2=radius_2, gap=gap)
    return answer(disk_exchange(a, b, h) / a**2)


@configuration("C-52", "ring to coaxial parallel ring", 0.5021532601145652,
               inner_1=0.5, outer_1=1.0, inner_2=0.5, outer_2=1.5, gap=1.0)  # fmt: skip
def coaxial_rings(*, inner_1: Length, outer_1: Length, inner_2: Length, outer_2: Length, gap: Length) -> Factor:
    """F_12 from a flat ring to a parallel ring on the same axis, with nothing between them.

    Args:
        inner_1, outer_1: radii of ring 1, m; an inner radius of 0 makes a disk.
        inner_2, outer_2: radii of ring 2, m.
        gap: distance of the planes, m.

    Source: Howell C-52; factor algebra on C-41. Absolute accuracy of A_1 F_12 about 1e-15 of the largest disk.

    Raises:
        ValueError: a negative inner radius, one that is not below the outer radius, or a gap that is not positive.
    """
    a, c = nonnegative(inner_1=inner_1, inner_2=inner_2)
    b, d, h = positive(outer_1=outer_1, outer_2=outer_2, gap=gap)
    require(a < b, "inner_1 must be below outer_1: a ring without width has no area")
    require(c < d, "inner_2 must be below outer_2: a ring without width has no area")
    rings = disk_exchange(b, d, h) - disk_exchange(a, d, h) - disk_exchange(b, c, h) + disk_exchange(a, c, h)
    return answer(rings / ((b - a) * (b + a)))


@configuration("", "disk to disk, both inscribed in one sphere", 0.17157287525380988,
               sphere_radius=1.0, distance_1=0.5**0.5, distance_2=0.5**0.5)  # fmt: skip
def disks_in_a_sphere(*, sphere_radius: Length, distance_1: Length, distance_2: Length) -> Factor:
    """F_12 between two disks at any angle whose rims lie on one sphere and that do not cut each other.

    Every ray between the caps behind the disks crosses both disks; between caps factors are shares of the sphere.

    Args:
        sphere_radius: of the sphere, m.
        distance_1, distance_2: from the centre of the sphere to that of each disk, m; negative where the centre is
            behind the disk, seen from the other.

    Source: Feingold 1978. Relative accuracy about 1e-15.

    Raises:
        ValueError: a radius that is not positive, or a distance that is not below it.
    """
    (radius,) = positive(sphere_radius=sphere_radius)
    one, two = finite(distance_1=distance_1, distance_2=distance_2)
    require(abs(one) < radius, "distance_1 must be below sphere_radius: the disk would lie outside the sphere")
    require(abs(two) < radius, "distance_2 must be below sphere_radius: the disk would lie outside the sphere")
    require(one + two >= 0, "distance_1 and distance_2 must not add to less than 0: the disks would cut each other")
    # (R - d_1)(R - d_2) / r_1^2 with r_1^2 = (R - d_1)(R + d_1).
    return answer((radius - two) / (radius + one))


@configuration("", "half disk to half disk with common diameter", 0.25, angle=np.pi / 2)
def half_disks_with_common_diameter(*, angle: Angle) -> Factor:
    """F_12 between two half disks of one radius that share their diameter, like an open fan.

    With the lune of the sphere between them they make an enclosure, and factors from the lune are known.

    Args:
        angle: between the inner faces, 0 to pi.

    Source: factor algebra on the inside of a sphere. Absolute accuracy about 1e-16.

    Raises:
        ValueError: an angle outside 0 to pi.
    """
    (phi,) = within(0.0, np.pi, angle=angle)
    return answer((1 - phi / np.pi) ** 2)


def disk_exchange(a: Floats, b: Floats, h: Floats) -> Floats:
    """A F / pi between coaxial disks of radii a and b at distance h, which may be 0."""
    middle = h**2 + a**2 + b**2
    exchange: Floats = 2 * a**2 * b**2 / (middle + np.hypot(h, a - b) * np.hypot(h, a + b))
    return exchange
