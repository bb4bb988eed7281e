"""Two cylinders of one finite length and one axis, and the annular ends of the space between them."""

from __future__ import annotations

import numpy as np

from radiosity.catalogue.arguments import Factor, Floats, Length, answer, positive, require
from radiosity.catalogue.registry import configuration

ARGUMENTS = {"inner_radius": 1.0, "outer_radius": 2.0, "length": 2.0}


@configuration("", "outer coaxial cylinder to inner, finite length", 0.33710602751895047, **ARGUMENTS)
def outer_cylinder_to_inner(*, inner_radius: Length, outer_radius: Length, length: Length) -> Factor:
    """F_21 from the inside of a cylinder to the outside of another of the same length and axis within it.

    Args:
        inner_radius, outer_radius: of the cylinders, m.
        length: of both, m.

    Source: Hamilton and Morgan 1952. Relative accuracy about 1e-15.

    Raises:
        ValueError: a size that is not positive, or an inner radius that is not below the outer.
    """
    return answer(_outer_to_inner(*_cylinders(inner_radius, outer_radius, length)))


@configuration("C-91", "outer coaxial cylinder to itself, finite length", 0.2284810189879989, **ARGUMENTS)
def outer_cylinder_to_itself(*, inner_radius: Length, outer_radius: Length, length: Length) -> Factor:
    """F_22 from the inside of a cylinder to itself, past another cylinder of the same length and axis.

    Args:
        inner_radius, outer_radius: of the cylinders, m.
        length: of both, m.

    Source: Howell C-91; Hamilton and Morgan 1952. Absolute accuracy about 1e-15.

    Raises:
        ValueError: a size that is not positive, or an inner radius that is not below the outer.
    """
    return answer(_outer_to_itself(*_cylinders(inner_radius, outer_radius, length)))


@configuration("", "outer coaxial cylinder to one annular end", 0.21720647674652532, **ARGUMENTS)
def outer_cylinder_to_annular_end(*, inner_radius: Length, outer_radius: Length, length: Length) -> Factor:
    """F_23 from the inside of a cylinder to one of the rings that close the space around a coaxial cylinder within.

    Args:
        inner_radius, outer_radius: of the cylinders, which are those of the ring, m.
        length: of both, m.

    Source: closure with :func:`outer_cylinder_to_inner` and :func:`outer_cylinder_to_itself`. Absolute accuracy about
    1e-15.

    Raises:
        ValueError: a size that is not positive, or an inner radius that is not below the outer.
    """
    sizes = _cylinders(inner_radius, outer_radius, length)
    return answer(0.5 * (1 - _outer_to_inner(*sizes) - _outer_to_itself(*sizes)))


@configuration("C-77", "outside of cylinder to annular disk at its end", 0.16289397248104953, **ARGUMENTS)
def inner_cylinder_to_annular_end(*, inner_radius: Length, outer_radius: Length, length: Length) -> Factor:
    """F_13 from the outside of a cylinder to a ring around one of its ends.

    Args:
        inner_radius: of the cylinder and of the inside of the ring, m.
        outer_radius: of the outside of the ring, m.
        length: of the cylinder, m.

    Source: Howell C-77; Rea 1975: closure, as what misses the two rings meets an outer cylinder of the same length.
    Absolute accuracy about 1e-15 outer_radius / inner_radius.

    Raises:
        ValueError: a size that is not positive, or an inner radius that is not below the outer.
    """
    sizes = _cylinders(inner_radius, outer_radius, length)
    return answer(0.5 * (1 - sizes[0] * _outer_to_inner(*sizes)))


@configuration("", "annular end to annular end between coaxial cylinders", 0.20359076536786647, **ARGUMENTS)
def annular_end_to_other_end(*, inner_radius: Length, outer_radius: Length, length: Length) -> Factor:
    """F_34 between the two rings that close the space between coaxial cylinders, past the inner cylinder.

    Args:
        inner_radius, outer_radius: of the cylinders, which are those of the rings, m.
        length: of both, m.

    Source: closure and reciprocity with the others of this family. Absolute accuracy about 1e-15 times the area of a
    cylinder over that of a ring.

    Raises:
        ValueError: a size that is not positive, or an inner radius that is not below the outer.
    """
    R, gap, L = _cylinders(inner_radius, outer_radius, length)
    inner, itself = _outer_to_inner(R, gap, L), _outer_to_itself(R, gap, L)
    ring = gap * (R + 1)
    to_inner = L * (1 - R * inner) / ring
    to_outer = L * R * (1 - inner - itself) / ring
    return answer(1 - to_inner - to_outer)


def _cylinders(inner_radius: Length, outer_radius: Length, length: Length) -> tuple[Floats, Floats, Floats]:
    """Outer radius, width of the gap and length, over the inner radius."""
    a, b, h = positive(inner_radius=inner_radius, outer_radius=outer_radius, length=length)
    require(a < b, "inner_radius must be below outer_radius: there is no space between the cylinders")
    return b / a, (b - a) / a, h / a


def _outer_to_inner(R: Floats, gap: Floats, L: Floats) -> Floats:
    """F_21 as (2 arctan(L / sqrt(R^2 - 1)) + N / (2 L)) / (pi R), with no difference of large terms in N."""
    ring = gap * (R + 1)  # R^2 - 1
    A, B, edge = L**2 + ring, L**2 - ring, np.sqrt(ring)
    P = np.hypot(L, gap) * np.hypot(L, R + 1)
    sine = np.arctan2(1.0, edge)  # arcsin(1 / R)
    # (P + B)(P - B) = 4 L^2 R^2, and one of the factors is a sum of positive terms.
    large = P + abs(B)
    small = 4 * L**2 * R**2 / large
    swing = small * sine - P * np.arctan2(edge * small, ring * P + abs(B))
    N = 2 * np.pi * L**2 / (P + A) + np.where(B < 0, swing, -swing)
    factor: Floats = (2 * np.arctan2(L, edge) + N / (2 * L)) / (np.pi * R)
    return factor


def _outer_to_itself(R: Floats, gap: Floats, L: Floats) -> Floats:
    """F_22, with lengths relative to L; one form of it for short cylinders, one for long ones."""
    inner, outer = 1 / L, R / L
    edge = np.sqrt(gap * (R + 1)) / L
    root = np.hypot(1.0, 2 * outer)
    short = np.arctan2(edge, inner) + root * np.arctan2(inner, edge * root) - 2 * inner * np.arctan2(1.0, 2 * edge)
    short = short - 0.5 * np.pi / (2 * outer + root)
    more = 4 * outer**2 / (1 + root)  # root - 1
    long = np.pi * gap / L - more * np.arctan2(edge * root, inner) + 2 * inner * np.arctan(2 * edge)
    long = long - np.arctan2(edge * inner * more, inner**2 + edge**2 * root)
    factor: Floats = np.where(outer > 1, short, long) / (np.pi * outer)
    return factor
