"""Spheres: to what surrounds them, to what they look at, and from within."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from radiosity.catalogue.arguments import Factor, Floats, Interval, Length, answer, interval, points, positive, require
from radiosity.catalogue.registry import configuration

UNIT_SQUARE = ((0.0, 0.0, 1.0), (0.0, 1.0, 1.0), (1.0, 1.0, 1.0), (1.0, 0.0, 1.0))


@configuration("", "sphere to coaxial disk", 0.5 * (1 - 0.5**0.5), disk_radius=1.0, distance=1.0)
def sphere_to_disk(*, disk_radius: Length, distance: Length) -> Factor:
    """F_12 from a sphere of any radius to a disk whose axis goes through the centre of the sphere.

    The sphere must not cut the plane of the disk; its radius does not matter.

    Args:
        disk_radius: of the disk, m.
        distance: from the centre of the sphere to the centre of the disk, m.

    Source: Feingold and Gupta 1970: the share of all directions that the disk fills. Relative accuracy about 1e-15.

    Raises:
        ValueError: a size that is not positive.
    """
    r, h = positive(disk_radius=disk_radius, distance=distance)
    slant = np.hypot(r, h)
    return answer(0.5 * (r / slant) * (r / (slant + h)))


@configuration("C-121", "sphere to rectangle, corner straight below", 1 / 24, width=1.0, length=1.0, distance=1.0)
def sphere_to_rectangle(*, width: Length, length: Length, distance: Length) -> Factor:
    """F_12 from a sphere of any radius to a rectangle with a corner at the foot of the perpendicular from its centre.

    Rectangles elsewhere in the plane are sums and differences of up to four of these. The sphere must not cut the
    plane; its radius does not matter.

    Args:
        width, length: sides, m.
        distance: from the centre of the sphere to the corner, m.

    Source: Howell C-121, and B-106 for a point source; Feingold and Gupta 1970. Relative accuracy about 1e-15.

    Raises:
        ValueError: a size that is not positive.
    """
    a, b, h = positive(width=width, length=length, distance=distance)
    return answer(np.arctan2(a * b, h * np.hypot(np.hypot(a, b), h)) / (4 * np.pi))


@configuration("C-124", "sphere to polygon", 1 / 24, polygon=UNIT_SQUARE, centre=(0.0, 0.0, 0.0))
def sphere_to_polygon(*, polygon: npt.ArrayLike, centre: npt.ArrayLike) -> Factor:
    """F_12 from a sphere of any radius to a flat polygon in a plane that does not cut it.

    Args:
        polygon: (..., n, 3) corners in order, m.
        centre: (..., 3) of the sphere, m.

    Source: Howell C-124; Feingold and Gupta 1970: a quarter of the solid angle over pi, here by triangles after Van
    Oosterom and Strackee 1983. Absolute accuracy about 1e-16 a triangle.

    Raises:
        ValueError: arrays of other shapes, or less than three corners.
    """
    corners, origin = points(polygon=polygon, centre=centre)
    require(corners.ndim > 1 and corners.shape[-2] > 2, "polygon must have three corners or more, (..., n, 3)")
    rays = corners - origin[..., None, :]
    fan = [_solid_angle(rays[..., 0, :], rays[..., k, :], rays[..., k + 1, :]) for k in range(1, rays.shape[-2] - 1)]
    return answer(np.abs(np.sum(fan, axis=0)) / (4 * np.pi))


@configuration("", "sphere to coaxial cylinder around its axis", 0.5 * (0.8**0.5 - 0.5**0.5),
               cylinder_radius=1.0, ends=(1.0, 2.0))  # fmt: skip
def sphere_to_cylinder(*, cylinder_radius: Length, ends: Interval) -> Factor:
    """F_12 from a sphere to the inside of an open cylinder whose axis goes through its centre.

    Args:
        cylinder_radius: above that of the sphere, which does not matter otherwise, m.
        ends: where the cylinder starts and ends along the axis, from the centre of the sphere, m. Its planes must
            not cut the sphere.

    Source: Feingold and Gupta 1970: the share of all directions that the cylinder fills. Absolute accuracy about 1e-16.

    Raises:
        ValueError: a radius that is not positive, or ends out of order.
    """
    (r,) = positive(cylinder_radius=cylinder_radius)
    start, end = interval(ends=ends)
    return answer(0.5 * (end / np.hypot(r, end) - start / np.hypot(r, start)))


@configuration("", "outer sphere to enclosed sphere", 0.25, inner_radius=1.0, outer_radius=2.0)
def outer_sphere_to_inner(*, inner_radius: Length, outer_radius: Length) -> Factor:
    """F_21 from the inside of a sphere to a sphere within it; the inner sphere sees nothing but the outer.

    Args:
        inner_radius, outer_radius: of the spheres, m. They need not share their centre.

    Source: reciprocity. Exact.

    Raises:
        ValueError: a radius that is not positive, or an inner one that exceeds the outer.
    """
    return answer(_radii(inner_radius, outer_radius) ** 2)


@configuration("", "outer sphere to itself around enclosed sphere", 0.75, inner_radius=1.0, outer_radius=2.0)
def outer_sphere_to_itself(*, inner_radius: Length, outer_radius: Length) -> Factor:
    """F_22 from the inside of a sphere to itself, past a sphere within it.

    Args:
        inner_radius, outer_radius: of the spheres, m. They need not share their centre.

    Source: closure. Relative accuracy about 1e-16 where the radii differ.

    Raises:
        ValueError: a radius that is not positive, or an inner one that exceeds the outer.
    """
    ratio = _radii(inner_radius, outer_radius)
    return answer((1 - ratio) * (1 + ratio))


@configuration("", "inside of a sphere, patch to patch", 0.25, area_2=np.pi, radius=1.0)
def sphere_patches(*, area_2: Length, radius: Length) -> Factor:
    """F_12 from any part of the inside of a sphere to any other part of it, or to itself.

    Args:
        area_2: of the part that receives, m2.
        radius: of the sphere, m.

    Source: the kernel is 1 / (4 pi radius^2) everywhere on a sphere. Exact.

    Raises:
        ValueError: a size that is not positive, or an area larger than that of the sphere.
    """
    area, r = positive(area_2=area_2, radius=radius)
    share = area / (4 * np.pi * r**2)
    require(share <= 1 + 1e-12, "area_2 must not exceed the area of the sphere, 4 pi radius^2")
    return answer(share)


@configuration("", "spherical cap to its base", 0.5, radius=1.0, height=1.0)
def cap_to_base(*, radius: Length, height: Length) -> Factor:
    """F_12 from the inside of a spherical cap to the disk that closes it; 1/2 of a hemisphere.

    Args:
        radius: of the sphere that the cap is cut from, m.
        height: of the cap above the disk, at most 2 ``radius``, m; ``radius`` makes a hemisphere.

    Source: closure with :func:`sphere_patches`. Exact. The rest, height / (2 radius), the cap sends to itself.

    Raises:
        ValueError: a size that is not positive, or a height of more than 2 radius.
    """
    r, h = positive(radius=radius, height=height)
    require(h <= 2 * r, "height must not exceed 2 radius, which is the whole sphere")
    return answer(1 - h / (2 * r))


def _radii(inner_radius: Length, outer_radius: Length) -> Floats:
    """The ratio of two radii that must not exceed 1."""
    inner, outer = positive(inner_radius=inner_radius, outer_radius=outer_radius)
    require(inner <= outer, "inner_radius must not exceed outer_radius: exchange them")
    ratio: Floats = inner / outer
    return ratio


def _solid_angle(a: Floats, b: Floats, c: Floats) -> Floats:
    """Signed solid angle of a triangle seen from the origin."""
    volume = np.sum(a * np.cross(b, c), axis=-1)
    la, lb, lc = (np.linalg.norm(v, axis=-1) for v in (a, b, c))
    dots = np.sum(a * b, axis=-1) * lc + np.sum(b * c, axis=-1) * la + np.sum(c * a, axis=-1) * lb
    angle: Floats = 2 * np.arctan2(volume, la * lb * lc + dots)
    return angle
