"""From a surface element, small enough to be a point, to rectangles, polygons, disks, spheres and cylinders.

The factor from a point is also the irradiance there from a surface of unit radiosity.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from radiosity.catalogue.arguments import (
    Angle,
    Factor,
    Floats,
    Length,
    answer,
    nonnegative,
    points,
    positive,
    require,
    within,
)
from radiosity.catalogue.registry import configuration

UNIT_SQUARE = ((0.0, 0.0, 1.0), (0.0, 1.0, 1.0), (1.0, 1.0, 1.0), (1.0, 0.0, 1.0))


@configuration("B-3", "point to parallel rectangle, corner on the normal", 0.13853160599489298,
               width=1.0, length=1.0, distance=1.0)  # fmt: skip
def point_to_parallel_rectangle(*, width: Length, length: Length, distance: Length) -> Factor:
    """F_12 from a surface element to a parallel rectangle that has a corner on the normal of the element.

    Rectangles elsewhere are sums and differences of up to four of these.

    Args:
        width, length: sides, m.
        distance: from the element to the corner, m.

    Source: Howell B-3; Hamilton and Morgan 1952. Relative accuracy about 1e-15.

    Raises:
        ValueError: a size that is not positive.
    """
    a, b, c = positive(width=width, length=length, distance=distance)
    return answer((_corner(a, b, c) + _corner(b, a, c)) / (2 * np.pi))


@configuration("B-8", "point to perpendicular rectangle, corner at the foot", 0.055734197002553505,
               height=1.0, length=1.0, distance=1.0)  # fmt: skip
def point_to_perpendicular_rectangle(*, height: Length, length: Length, distance: Length) -> Factor:
    """F_12 from a surface element to a rectangle that stands on the plane of the element.

    The foot of the perpendicular from the element to the plane of the rectangle is a corner of the rectangle.

    Args:
        height: of the rectangle above the plane of the element, m.
        length: of the side that stands on that plane, m.
        distance: from the element to the corner, m.

    Source: Howell B-8 at a right angle; Hamilton and Morgan 1952. Relative accuracy about 1e-15.

    Raises:
        ValueError: a size that is not positive.
    """
    a, b, c = positive(height=height, length=length, distance=distance)
    d = np.hypot(a, c)
    drop = a * (a / (d + c))  # d - c
    return answer((drop / d * np.arctan2(b, c) + c / d * np.arctan2(b * drop, c * d + b**2)) / (2 * np.pi))


@configuration("B-8", "point to rectangle in a plane at any angle, corner on the common line", 0.10597601666122725,
               height=1.0, length=1.0, distance=1.0, angle=np.pi / 3)  # fmt: skip
def point_to_tilted_rectangle(*, height: Length, length: Length, distance: Length, angle: Angle) -> Factor:
    """F_12 from a surface element to a rectangle that stands at any angle on the plane of the element.

    One side of the rectangle lies in the plane of the element, and ends at the point of that line nearest to it.

    Args:
        height: how far the rectangle reaches from the plane of the element, along its slope, m.
        length: of the side that lies in that plane, m.
        distance: from the element to that side, m.
        angle: between the rectangle and the ground from its foot to the element, above 0 and below pi.

    Source: Howell B-8; Hamilton and Morgan 1952. Absolute accuracy about 1e-15.

    Raises:
        ValueError: a size that is not positive, or an angle that is not between 0 and pi.
    """
    a, b, c = positive(height=height, length=length, distance=distance)
    (phi,) = within(0.0, np.pi, angle=angle)
    require((phi > 0) & (phi < np.pi), "angle must be above 0 and below pi: at either end there is nothing to see")
    v = np.hypot(a - c, 2 * np.sqrt(a * c) * np.sin(phi / 2))
    w = np.hypot(b, c * np.sin(phi))
    side = np.arctan2(a - c * np.cos(phi), w) + np.arctan2(c * np.cos(phi), w)
    top = (a * np.cos(phi) - c) / v * np.arctan2(b, v)
    return answer((np.arctan2(b, c) + top + np.cos(phi) * b / w * side) / (2 * np.pi))


@configuration("", "point to polygon, cut at the horizon", 0.13853160599489298,
               polygon=UNIT_SQUARE, position=(0.0, 0.0, 0.0), normal=(0.0, 0.0, 1.0))  # fmt: skip
def point_to_polygon(*, polygon: npt.ArrayLike, position: npt.ArrayLike, normal: npt.ArrayLike) -> Factor:
    """F_12 from a surface element to any flat polygon; what is behind the element is cut off.

    Args:
        polygon: (..., n, 3) corners in order, either way around, m; it may be hollow, but not cross itself.
        position: (..., 3) of the element, outside the polygon, m.
        normal: (..., 3) of the element, of any length.

    Source: Lambert 1760; Hottel and Sarofim 1967: a sum over the edges. Absolute accuracy about 1e-15.

    Raises:
        ValueError: arrays of other shapes, less than three corners, or a normal without length.
    """
    corners, origin, up = points(polygon=polygon, position=position, normal=normal)
    require(corners.ndim > 1 and corners.shape[-2] > 2, "polygon must have three corners or more, (..., n, 3)")
    length = np.linalg.norm(up, axis=-1, keepdims=True)
    require(length > 0, "normal must have a length: give the direction that the element faces")
    rays, up = np.broadcast_arrays(corners - origin[..., None, :], (up / length)[..., None, :])
    starts, ends = rays, np.roll(rays, -1, axis=-2)
    low, high = np.sum(starts * up, axis=-1), np.sum(ends * up, axis=-1)
    cut_start, cut_end = _cut(starts, ends, low, high), _cut(ends, starts, high, low)
    arcs = np.where((low > 0) | (high > 0), _arc(cut_start, cut_end, up), 0.0)
    total = np.sum(arcs, axis=-1) + _horizon(starts, ends, low, high, up)
    return answer(np.abs(total) / (2 * np.pi))


@configuration("B-22", "point to parallel disk, off its axis", 0.5 * (1 - 1 / 5**0.5),
               radius=1.0, distance=1.0, offset=1.0)  # fmt: skip
def point_to_parallel_disk(*, radius: Length, distance: Length, offset: Length = 0.0) -> Factor:
    """F_12 from a surface element to a disk in a parallel plane.

    Args:
        radius: of the disk, m.
        distance: of the planes, m.
        offset: of the element from the axis of the disk, m.

    Source: Howell B-22 (of a ring on a coaxial disk, all elements of which see the same); offset 0 is B-12, radius^2 /
    (radius^2 + distance^2); Hamilton and Morgan 1952. Relative accuracy about 1e-15.

    Raises:
        ValueError: a radius or distance that is not positive, or a negative offset.
    """
    r, h = positive(radius=radius, distance=distance)
    (a,) = nonnegative(offset=offset)
    root = np.hypot(h, a + r) * np.hypot(h, a - r)
    rest = h**2 + (a - r) * (a + r)
    outside = 2 * r**2 * h**2 / (root * (root + np.maximum(rest, 0.0)))
    return answer(np.where(rest > 0, outside, 0.5 * (1 - rest / root)))


@configuration("B-53", "point to perpendicular disk", 0.058156305651438,
               radius=0.5, distance=1.0, height=1.0)  # fmt: skip
def point_to_perpendicular_disk(*, radius: Length, distance: Length, height: Length) -> Factor:
    """F_12 from a surface element to a disk in a plane perpendicular to its own, the normal crossing the disk's axis.

    As seen from an element of the wall of a pipe: a disk across the pipe.

    Args:
        radius: of the disk, at most ``distance``, so that all of it is in front of the element, m.
        distance: from the element to the axis of the disk, m.
        height: of the element above the plane of the disk, m.

    Source: Howell B-53. Relative accuracy about 1e-15.

    Raises:
        ValueError: a size that is not positive, or a disk that reaches behind the element.
    """
    r, d, h = positive(radius=radius, distance=distance, height=height)
    require(r <= d, "radius must not exceed distance: the disk would reach behind the element")
    root = np.hypot(h, d + r) * np.hypot(h, d - r)
    return answer(2 * d * r**2 * h / (root * (root + d**2 + h**2 + r**2)))


@configuration("B-13", "point on the axis of a disk, tilted at any angle", 0.5 * 0.5**0.5,
               radius=1.0, distance=1.0, tilt=np.pi / 4)  # fmt: skip
def tilted_point_to_disk(*, radius: Length, distance: Length, tilt: Angle = 0.0) -> Factor:
    """F_12 from a surface element on the axis of a disk that may face aside; what it does not face is cut off.

    Args:
        radius: of the disk, m.
        distance: from the element to the centre, m.
        tilt: from the normal of the element to the centre of the disk, 0 to pi.

    Source: Howell B-13; the disk fills a cone, as a sphere does. Absolute accuracy about 1e-16.

    Raises:
        ValueError: a size that is not positive, or a tilt outside 0 to pi.
    """
    r, h = positive(radius=radius, distance=distance)
    (theta,) = within(0.0, np.pi, tilt=tilt)
    slant = np.hypot(r, h)
    return answer(_cone(r / slant, h / slant, theta))


@configuration("B-43", "point to sphere, tilted at any angle", 0.25, radius=1.0, distance=2.0, tilt=0.0)
def point_to_sphere(*, radius: Length, distance: Length, tilt: Angle = 0.0) -> Factor:
    """F_12 from a surface element to a sphere; what is below the horizon of the element is cut off.

    Args:
        radius: of the sphere, m.
        distance: from the element to the centre, at least ``radius``, m.
        tilt: from the normal of the element to the centre of the sphere, 0 to pi.

    Source: Howell B-43; Cunningham 1961. cos(tilt) (radius / distance)^2 where all of the sphere is above the horizon.
    Absolute accuracy about 1e-16; where only a sliver is above, relative accuracy is less.

    Raises:
        ValueError: a size that is not positive, a point inside the sphere, or a tilt outside 0 to pi.
    """
    r, d = positive(radius=radius, distance=distance)
    require(d >= r, "distance must be at least radius: it is measured to the centre, from outside")
    (theta,) = within(0.0, np.pi, tilt=tilt)
    return answer(_cone(r / d, np.sqrt((1 - r / d) * (1 + r / d)), theta))


@configuration("B-71", "point to infinite strip", (3**0.5 - 1) / 4, angle_1=np.pi / 6, angle_2=np.pi / 3)
def point_to_infinite_strip(*, angle_1: Angle, angle_2: Angle) -> Factor:
    """F_12 from a surface element to an infinitely long strip, or to any long surface that spans the same angles.

    Args:
        angle_1, angle_2: from the normal of the element to the two edges, seen along the strip, -pi/2 to pi/2; the
            element lies parallel to the long edges.

    Source: Howell B-71: half the difference of the sines.

    Raises:
        ValueError: an angle outside -pi/2 to pi/2: cut what is below the horizon of the element.
    """
    one, two = within(-np.pi / 2, np.pi / 2, angle_1=angle_1, angle_2=angle_2)
    return answer(np.abs(np.cos(0.5 * (one + two)) * np.sin(0.5 * (two - one))))


@configuration("", "point to right circular cylinder, level with one of its ends", 0.1946823494731683,
               radius=1.0, length=1.0, distance=2.0)  # fmt: skip
def point_to_cylinder(*, radius: Length, length: Length, distance: Length) -> Factor:
    """F_12 from a surface element that faces the axis of a cylinder, level with the plane of one of its ends.

    A cylinder that reaches to both sides is the sum of two of these, one that hovers the difference of two.

    Args:
        radius, length: of the cylinder, m.
        distance: from the element to the axis, above ``radius``, m.

    Source: Hamilton and Morgan 1952. Relative accuracy about 1e-14.

    Raises:
        ValueError: a size that is not positive, or an element inside the cylinder.
    """
    r, h, d = positive(radius=radius, length=length, distance=distance)
    require(d > r, "distance must exceed radius: it is measured to the axis, from outside")
    D, L = d / r, h / r
    inside = (d - r) / r  # D - 1
    near, far = L**2 + inside**2, L**2 + (D + 1) ** 2
    root = np.sqrt(near * far)
    middle = 1 + D**2 + L**2
    edge, swing = np.sqrt(inside / (D + 1)), np.sqrt(far / near)
    ends = 4 * D**2 / (root * (middle + root)) * np.arctan(swing * edge)
    ends = ends + np.arctan2(edge * 4 * D / (near * (swing + 1)), 1 + swing * edge**2)
    return answer((np.arctan2(L, np.sqrt(inside * (D + 1))) + L * ends) / (np.pi * D))


def _corner(a: Floats, b: Floats, c: Floats) -> Floats:
    """The part of B-3 of the edge that runs at a distance a from the normal."""
    slant = np.hypot(a, c)
    part: Floats = a / slant * np.arctan2(b, slant)
    return part


def _cone(sine: Floats, cosine: Floats, tilt: Floats) -> Floats:
    """The factor to a cone of directions with the given half angle around an axis at ``tilt`` from the normal."""
    level = np.cos(tilt)
    cut = np.sqrt(np.maximum((sine - level) * (sine + level), 0.0))
    aside = np.arctan2(cut, cosine) + level * sine**2 * np.arctan2(cut, -cosine * level)
    partial = (aside - cosine * cut) / np.pi
    return np.where(level >= sine, level * sine**2, np.where(level <= -sine, 0.0, partial))


def _cut(ends: Floats, others: Floats, height: Floats, other: Floats) -> Floats:
    """The first ends of edges, moved along the edge to the horizon where they are below it."""
    crosses = (height < 0) & (other > 0)
    share = np.where(crosses, height, 0.0) / np.where(crosses, height - other, 1.0)
    return ends + share[..., None] * (others - ends)


def _arc(a: Floats, b: Floats, up: Floats) -> Floats:
    """The angle that edges a b subtend, times the cosine between their plane and the horizon."""
    across = np.cross(a, b)
    length = np.linalg.norm(across, axis=-1)
    angle = np.arctan2(length, np.sum(a * b, axis=-1))
    flat = length > 0
    arc: Floats = np.where(flat, angle * np.sum(across * up, axis=-1) / np.where(flat, length, 1.0), 0.0)
    return arc


def _horizon(starts: Floats, ends: Floats, low: Floats, high: Floats, up: Floats) -> Floats:
    """The arcs along the horizon that close a polygon where it was cut, from each way down to the next way up.

    All crossings lie on one line, so the arcs are differences of angles measured from any one of them.
    """
    rises, falls = (low <= 0) & (high > 0), (low > 0) & (high <= 0)
    share = low / np.where(rises | falls, low - high, 1.0)
    crossings = starts + share[..., None] * (ends - starts)
    first = np.argmax(rises | falls, axis=-1)
    origin = np.take_along_axis(crossings, first[..., None, None], axis=-2)
    angles = np.arctan2(np.sum(np.cross(origin, crossings) * up, axis=-1), np.sum(origin * crossings, axis=-1))
    closing: Floats = np.sum(np.where(rises, angles, 0.0) - np.where(falls, angles, 0.0), axis=-1)
    return closing
