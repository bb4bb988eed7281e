"""Inside cones and frusta, which are cylinders where the radii are equal."""

from __future__ import annotations

import numpy as np

from radiosity.catalogue.arguments import Factor, Floats, Length, answer, nonnegative, positive, require
from radiosity.catalogue.disks import disk_exchange
from radiosity.catalogue.registry import configuration


@configuration("", "base of a cone or frustum to its side", 1 - (5.25 - (5.25**2 - 4) ** 0.5) / 2 / 4,
               base_radius=2.0, top_radius=0.5, height=1.0)  # fmt: skip
def frustum_base_to_side(*, base_radius: Length, top_radius: Length, height: Length) -> Factor:
    """F_12 from a base of a frustum to the inside of its side; the other base takes the rest.

    Args:
        base_radius: of the base that sends, m.
        top_radius: of the other base, 0 for a cone, m.
        height: distance of the bases, m.

    Source: closure with Howell C-41. Relative accuracy about 1e-15.

    Raises:
        ValueError: a base radius or height that is not positive, or a negative top radius.
    """
    a, b, h, _ = _frustum(base_radius, top_radius, height)
    return answer(_side_exchange(a, b, h) / a**2)


@configuration("", "side of a cone or frustum to its base", 0.5**0.5, base_radius=1.0, top_radius=0.0, height=1.0)
def frustum_side_to_base(*, base_radius: Length, top_radius: Length, height: Length) -> Factor:
    """F_12 from the inside of the side of a frustum to one of its bases.

    Args:
        base_radius: of the base that receives, m.
        top_radius: of the other base, 0 for a cone, m.
        height: distance of the bases, m.

    Source: reciprocity with :func:`frustum_base_to_side`. Relative accuracy about 1e-15.

    Raises:
        ValueError: a base radius or height that is not positive, or a negative top radius.
    """
    a, b, h, slant = _frustum(base_radius, top_radius, height)
    return answer(_side_exchange(a, b, h) / ((a + b) * slant))


@configuration("", "side of a cone or frustum to itself", 1 - 0.5**0.5, base_radius=1.0, top_radius=0.0, height=1.0)
def frustum_side_to_itself(*, base_radius: Length, top_radius: Length, height: Length) -> Factor:
    """F_11 from the inside of the side of a frustum to itself.

    Args:
        base_radius, top_radius: of the bases, m; a top radius of 0 makes a cone.
        height: distance of the bases, m.

    Source: closure with Howell C-41; of a cone 1 - sin(half of the opening angle), of a cylinder C-78.
    Relative accuracy about 1e-15.

    Raises:
        ValueError: a base radius or height that is not positive, or a negative top radius.
    """
    a, b, h, slant = _frustum(base_radius, top_radius, height)
    across = np.hypot(h, a + b)
    rest = a + b + 4 * a * (b / (across + slant))  # a + b + across - slant
    return answer(h / slant * (h * rest / ((across + a + b) * (a + b))))


@configuration("C-118", "side of a frustum to side of attached frustum", 0.4228749865729858, radius_1=1.0, radius_2=1.5,
               radius_3=1.0, height_1=1.0, height_2=1.0)  # fmt: skip
def frustum_to_attached_frustum(
    *, radius_1: Length, radius_2: Length, radius_3: Length, height_1: Length, height_2: Length
) -> Factor:
    """F_12 from the inside of the side of a frustum to that of another that continues it, with the same axis.

    Args:
        radius_1: of the free end of frustum 1, may be 0, m.
        radius_2: of the end that both share, m.
        radius_3: of the free end of frustum 2, may be 0, m.
        height_1, height_2: of the frusta, m.

    Source: Howell C-118; Buraczewski 1977: factor algebra on C-41. C-117 is radius_1 = 0 or radius_3 = 0. Absolute
    accuracy of A_1 F_12 about 1e-15 of the largest disk.

    Raises:
        ValueError: a height or radius_2 that is not positive, other negative radii, or a waist: radius_2 below the
            straight line from radius_1 to radius_3, where it would block the view between the ends.
    """
    a, c = nonnegative(radius_1=radius_1, radius_3=radius_3)
    b, g, h = positive(radius_2=radius_2, height_1=height_1, height_2=height_2)
    require(b * (g + h) >= (a * h + c * g) * (1 - 1e-12), "radius_2 must not be a waist, below the line from radius_1")
    sides = b**2 - disk_exchange(a, b, g) - disk_exchange(b, c, h) + disk_exchange(a, c, g + h)
    return answer(sides / ((a + b) * np.hypot(g, a - b)))


def _frustum(base_radius: Length, top_radius: Length, height: Length) -> tuple[Floats, Floats, Floats, Floats]:
    """Radii, height and slant height of a frustum."""
    a, h = positive(base_radius=base_radius, height=height)
    (b,) = nonnegative(top_radius=top_radius)
    return a, b, h, np.hypot(h, a - b)


def _side_exchange(a: Floats, b: Floats, h: Floats) -> Floats:
    """A F / pi between a base of radius a and the side of a frustum with other base b and height h."""
    root = np.hypot(h, a - b) * np.hypot(h, a + b)
    rest = h**2 + (b - a) * (b + a)
    small = 2 * a**2 * h**2 / (root + np.maximum(rest, 0.0))
    exchange: Floats = np.where(rest > 0, small, 0.5 * (root - rest))
    return exchange
