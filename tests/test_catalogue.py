"""The catalogue of form factors, each beside an integral of the definition that knows nothing of its formula."""

from __future__ import annotations

import inspect
import math
import subprocess
import sys
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from integrals import (
    around_axis,
    bent_strips,
    cap,
    cone,
    factor,
    gauss,
    integral,
    point_factor,
    rectangle,
    ring,
    share,
    side,
    strip_factor,
    triangle,
    wedge,
)

from radiosity import catalogue
from radiosity.catalogue import CONFIGURATIONS, Configuration

ORIGIN, UP = np.zeros(3), np.array([0.0, 0.0, 1.0])
ANGLES = {"angle", "angle_1", "angle_2", "tilt"}
few = settings(max_examples=40, deadline=None, derandomize=True)
sizes = st.floats(0.05, 20.0)

# Reference values from elsewhere: Howell's and Martinez's tables, recomputed in scipy to the digits shown.
TABLE: list[tuple[str, dict[str, Any], float, float]] = [
    ("equal_parallel_rectangles", {"width": 1, "length": 1, "gap": 1}, 0.19982489569838746, 1e-15),
    ("equal_parallel_rectangles", {"width": 2, "length": 1, "gap": 1}, 0.2858753849, 5e-11),
    ("equal_parallel_rectangles", {"width": 10, "length": 10, "gap": 1}, 0.8269945224, 5e-11),
    (
        "perpendicular_rectangles_with_common_edge",
        {"width_1": 1, "width_2": 1, "length": 1},
        0.20004377607540316,
        1e-15,
    ),
    ("perpendicular_rectangles_with_common_edge", {"width_1": 1, "width_2": 0.5, "length": 1}, 0.1461866791, 5e-11),
    ("perpendicular_rectangles_with_common_edge", {"width_1": 1, "width_2": 2, "length": 1}, 0.2328526028, 5e-11),
    ("point_to_parallel_rectangle", {"width": 1, "length": 1, "distance": 1}, 0.1385316060, 5e-11),
    ("point_to_perpendicular_rectangle", {"height": 1, "length": 1, "distance": 1}, 0.0557341970, 5e-11),
    ("coaxial_disks", {"radius_1": 1, "radius_2": 1, "gap": 1}, 0.3819660113, 5e-11),
    ("coaxial_disks", {"radius_1": 0.5, "radius_2": 1, "gap": 1}, 0.4688711259, 5e-11),
    ("point_to_parallel_disk", {"radius": 1, "distance": 1}, 0.5, 1e-15),
    ("equal_parallel_strips", {"width": 1, "gap": 1}, 0.4142135624, 5e-11),
    ("strips_with_common_edge", {"width_1": 1, "width_2": 1, "angle": math.pi / 2}, 0.2928932188, 5e-11),
    ("strips_with_common_edge", {"width_1": 1, "width_2": 1, "angle": math.pi / 3}, 0.5, 1e-15),
    ("parallel_cylinders", {"radius_1": 1, "radius_2": 1, "distance": 3}, 0.1106959697, 1e-10),
    ("cylinder_base_to_side", {"radius": 1, "height": 1}, 0.6180339887, 5e-11),
    ("cylinder_side_to_itself", {"radius": 1, "height": 1}, 0.3819660113, 5e-11),
    ("sphere_patches", {"area_2": math.pi, "radius": 1.5}, 1 / 9, 1e-15),
]

INTEGRALS: dict[str, tuple[Callable[..., float], list[dict[str, Any]], float]] = {}
"""By name: the integral, arguments to compare at, and the relative tolerance, which is that of the integral."""


def checks(*more: dict[str, Any], tolerance: float = 1e-11) -> Callable[[Callable[..., float]], Callable[..., float]]:
    """Compare the configuration of the same name with the decorated integral, at its example and some more places."""

    def enter(function: Callable[..., float]) -> Callable[..., float]:
        INTEGRALS[function.__name__] = (function, list(more), tolerance)
        return function

    return enter


# Rectangles.


@checks({"width": 2.0, "length": 0.7, "gap": 1.3})
def equal_parallel_rectangles(width: float, length: float, gap: float) -> float:
    return parallel_rectangles((0, width), (0, length), (0, width), (0, length), gap)


@checks({"x_1": (0.0, 1.0), "y_1": (0.0, 2.0), "x_2": (-3.0, -1.0), "y_2": (0.5, 1.0), "gap": 2.0},
        {"x_1": (0.0, 0.1), "y_1": (0.0, 0.2), "x_2": (7.0, 7.1), "y_2": (5.0, 5.3), "gap": 2.0})  # fmt: skip
def parallel_rectangles(x_1: Any, y_1: Any, x_2: Any, y_2: Any, gap: float) -> float:
    one = rectangle([x_1[0], y_1[0], 0], [x_1[1] - x_1[0], 0, 0], [0, y_1[1] - y_1[0], 0])
    two = rectangle([x_2[0], y_2[0], gap], [0, y_2[1] - y_2[0], 0], [x_2[1] - x_2[0], 0, 0])
    return factor(one, two)


@checks({"edge_1": 2.0, "edge_2": 1.0, "gap": 1.5})
def coaxial_squares(edge_1: float, edge_2: float, gap: float) -> float:
    one, two = (-edge_1 / 2, edge_1 / 2), (-edge_2 / 2, edge_2 / 2)
    return parallel_rectangles(one, one, two, two, gap)


@checks({"width_1": 1.0, "width_2": 0.5, "length": 2.0}, {"width_1": 1.0, "width_2": 2.0, "length": 0.7})
def perpendicular_rectangles_with_common_edge(width_1: float, width_2: float, length: float) -> float:
    return wedge(width_1, width_2, length, math.pi / 2)


@checks({"x_1": (1.0, 2.0), "y_1": (0.0, 1.0), "y_2": (-2.0, -1.0), "z_2": (0.0, 1.0)},
        {"x_1": (5.0, 5.3), "y_1": (0.0, 0.1), "y_2": (2.0, 2.1), "z_2": (1.0, 1.2)})  # fmt: skip
def perpendicular_rectangles(x_1: Any, y_1: Any, y_2: Any, z_2: Any) -> float:
    one = rectangle([x_1[0], y_1[0], 0], [x_1[1] - x_1[0], 0, 0], [0, y_1[1] - y_1[0], 0], n=24)
    two = rectangle([0, y_2[0], z_2[0]], [0, y_2[1] - y_2[0], 0], [0, 0, z_2[1] - z_2[0]], n=24)
    return factor(one, two)


@checks({"width_1": 1.0, "width_2": 2.0, "length": 1.5, "angle": 2.5},
        {"width_1": 2.0, "width_2": 0.5, "length": 1.0, "angle": 0.8}, tolerance=1e-10)  # fmt: skip
def hinged_rectangles(width_1: float, width_2: float, length: float, angle: float) -> float:
    return wedge(width_1, width_2, length, angle, n=80)


@checks({"tilt": 2.0}, {"tilt": math.pi / 2}, tolerance=1e-10)
def tilted_plane_to_ground(tilt: float) -> float:
    # The ground is the half of all directions around its nadir.
    return cone(math.pi / 2, math.pi - tilt)


# Strips.


@checks({"width": 0.5, "gap": 1.0})
def equal_parallel_strips(width: float, gap: float) -> float:
    return parallel_strips((0, width), (0, width), gap)


@checks({"width_1": 3.0, "width_2": 1.0, "gap": 2.0})
def coaxial_strips(width_1: float, width_2: float, gap: float) -> float:
    return parallel_strips((-width_1 / 2, width_1 / 2), (-width_2 / 2, width_2 / 2), gap)


@checks({"x_1": (0.0, 1.0), "x_2": (0.3, 0.4), "gap": 0.7}, {"x_1": (0.0, 0.01), "x_2": (3.0, 3.01), "gap": 50.0})
def parallel_strips(x_1: Any, x_2: Any, gap: float) -> float:
    return strip_factor(([x_1[0], 0], [x_1[1], 0]), ([x_2[0], gap], [x_2[1], gap]))


@checks({"width_1": 1.0, "width_2": 2.0, "angle": 0.8}, {"width_1": 1.0, "width_2": 0.3, "angle": 2.5})
def strips_with_common_edge(width_1: float, width_2: float, angle: float) -> float:
    return bent_strips(width_1, width_2, angle)


@checks({"u_1": (1.0, 1.5), "u_2": (1.0, 1.3), "angle": 0.7}, {"u_1": (0.5, 1.0), "u_2": (1.0, 4.0), "angle": 2.5})
def strips_at_angle(u_1: Any, u_2: Any, angle: float) -> float:
    way = np.array([math.cos(angle), math.sin(angle)])
    return strip_factor(([u_1[0], 0], [u_1[1], 0]), (u_2[0] * way, u_2[1] * way))


@checks()
def crossed_strings(crossed: Any, uncrossed: Any, width: float) -> float:
    # Strings of 3-4-5 triangles: strips of width 3 at a distance of 4.
    assert (crossed, uncrossed, width) == ((5, 5), (4, 4), 3)
    return equal_parallel_strips(3.0, 4.0)


@checks({"side_1": 1.0, "side_2": 1.2, "side_3": 0.7})
def triangular_duct(side_1: float, side_2: float, side_3: float) -> float:
    return bent_strips(side_1, side_2, math.acos((side_1**2 + side_2**2 - side_3**2) / (2 * side_1 * side_2)))


@checks({"start_1": (0.0, 0.0), "end_1": (1.0, 0.5), "start_2": (1.0, 3.0), "end_2": (-1.0, 2.0)})
def segments(start_1: Any, end_1: Any, start_2: Any, end_2: Any) -> float:
    return strip_factor((start_1, end_1), (start_2, end_2))


# Points.


@checks({"width": 3.0, "length": 0.5, "distance": 1.5})
def point_to_parallel_rectangle(width: float, length: float, distance: float) -> float:
    return point_factor(ORIGIN, UP, rectangle([0, 0, distance], [0, length, 0], [width, 0, 0], n=50))


@checks({"height": 0.3, "length": 1.0, "distance": 0.7})
def point_to_perpendicular_rectangle(height: float, length: float, distance: float) -> float:
    return point_to_tilted_rectangle(height, length, distance, math.pi / 2)


@checks({"height": 2.0, "length": 0.7, "distance": 1.0, "angle": 2.2}, tolerance=1e-10)
def point_to_tilted_rectangle(height: float, length: float, distance: float, angle: float) -> float:
    # The line at x = distance; the ground from there to the element goes towards -x.
    slope = [-height * math.cos(angle), 0, height * math.sin(angle)]
    return point_factor(ORIGIN, UP, rectangle([distance, 0, 0], slope, [0, -length, 0], n=80)) + point_factor(
        ORIGIN, UP, rectangle([distance, 0, 0], [0, -length, 0], slope, n=80)
    )


@checks({"polygon": ((1.0, 0.0, 1.0), (-1.0, 1.0, 2.0), (0.0, -1.0, 1.5)), "position": (0.2, 0.1, -1.0),
         "normal": (0.3, 0.2, 2.0)})  # fmt: skip
def point_to_polygon(polygon: Any, position: Any, normal: Any) -> float:
    corners = np.asarray(polygon)
    up = np.asarray(normal) / np.linalg.norm(normal)
    parts = [triangle(corners[0], corners[k], corners[k + 1], n=40) for k in range(1, len(corners) - 1)]
    back = [triangle(corners[0], corners[k + 1], corners[k], n=40) for k in range(1, len(corners) - 1)]
    return sum(point_factor(np.asarray(position), up, part) for part in parts + back)


@checks({"radius": 1.0, "distance": 1.0, "offset": 0.3}, {"radius": 1.0, "distance": 0.8, "offset": 3.0},
        {"radius": 1.0, "distance": 2.0, "offset": 0.0})  # fmt: skip
def point_to_parallel_disk(radius: float, distance: float, offset: float) -> float:
    return point_factor(np.array([offset, 0, 0]), UP, ring([0, 0, distance], -UP, 0, radius, n=60, m=200))


@checks({"radius": 1.0, "distance": 1.5, "height": 0.7})
def point_to_perpendicular_disk(radius: float, distance: float, height: float) -> float:
    return point_factor(np.array([distance, 0, height]), np.array([-1.0, 0, 0]), ring(ORIGIN, UP, 0, radius, 60, 200))


@checks({"radius": 1.0, "distance": 1.0, "tilt": 1.2}, {"radius": 1.0, "distance": 1.0, "tilt": 2.2}, tolerance=1e-10)
def tilted_point_to_disk(radius: float, distance: float, tilt: float) -> float:
    return cone(math.atan2(radius, distance), tilt)


@checks({"radius": 1.0, "distance": 2.0, "tilt": 1.0}, {"radius": 1.0, "distance": 2.0, "tilt": 1.4},
        {"radius": 1.0, "distance": 1.1, "tilt": 2.0}, {"radius": 1.0, "distance": 1.0, "tilt": 1.0},
        tolerance=1e-10)  # fmt: skip
def point_to_sphere(radius: float, distance: float, tilt: float) -> float:
    return cone(math.asin(radius / distance), tilt)


@checks({"radius": 0.5, "length": 4.0, "distance": 0.8}, {"radius": 1.0, "length": 0.1, "distance": 5.0})
def point_to_cylinder(radius: float, length: float, distance: float) -> float:
    def kernel(turn: np.ndarray, z: np.ndarray) -> np.ndarray:
        forth, across = distance - radius * np.cos(turn), radius * np.sin(turn)
        return forth * radius * (distance * np.cos(turn) - radius) / (forth**2 + across**2 + z**2) ** 2 / np.pi

    reach = math.acos(radius / distance)
    return integral(kernel, (-reach, reach), (0, length), n=120)


@checks({"angle_1": -0.5, "angle_2": 1.0})
def point_to_infinite_strip(angle_1: float, angle_2: float) -> float:
    # A strip at height 1, as long as the tangent of an angle goes.
    def kernel(x: np.ndarray, t: np.ndarray) -> np.ndarray:
        return np.cos(t) ** 2 / (np.pi * (1 + x**2) ** 1.5)

    return integral(kernel, (math.tan(angle_1), math.tan(angle_2)), (-math.pi / 2, math.pi / 2), n=60)


# Disks.


@checks({"radius_1": 0.5, "radius_2": 1.0, "gap": 1.0}, {"radius_1": 1.0, "radius_2": 0.5, "gap": 2.0})
def coaxial_disks(radius_1: float, radius_2: float, gap: float) -> float:
    return coaxial_rings(0, radius_1, 0, radius_2, gap)


@checks({"inner_1": 0.0, "outer_1": 1.0, "inner_2": 1.0, "outer_2": 1.2, "gap": 1.0})
def coaxial_rings(inner_1: float, outer_1: float, inner_2: float, outer_2: float, gap: float) -> float:
    # By symmetry one azimuth of the first ring stands for all.
    two = ring([0, 0, gap], -UP, inner_2, outer_2, n=30, m=100)
    r, w = gauss(inner_1, outer_1, 30)
    flux = [2 * np.pi * x * y * point_factor(np.array([x, 0, 0]), UP, two) for x, y in zip(r, w, strict=True)]
    return sum(flux) / (math.pi * (outer_1**2 - inner_1**2))


@checks({"sphere_radius": 1.0, "distance_1": 0.4, "distance_2": 0.9}, tolerance=1e-9)
def disks_in_a_sphere(sphere_radius: float, distance_1: float, distance_2: float) -> float:
    # Axes at 140 degrees: neither coaxial nor cutting each other.
    one, two = np.array([0.0, 0.0, 1.0]), np.array([math.sin(2.44), 0.0, math.cos(2.44)])
    rims = [math.sqrt(sphere_radius**2 - d**2) for d in (distance_1, distance_2)]
    return factor(ring(distance_1 * one, -one, 0, rims[0], 16, 40), ring(distance_2 * two, -two, 0, rims[1], 16, 40))


@checks({"angle": 2.0}, tolerance=1e-7)
def half_disks_with_common_diameter(angle: float) -> float:
    # From points of one half, by the contour of the other (Lambert): chord and arc. Points gather at the diameter.
    t, w = gauss(0, math.pi, 60)
    s, v = gauss(0, 1, 40)
    x, height = np.cos(t), np.sin(t)
    y = height[:, None] * s**2
    points = np.stack([x[:, None] + 0 * y, y, 0 * y], axis=-1).reshape(-1, 3)
    areas = (w[:, None] * height[:, None] ** 2 * 2 * s * v).ravel()
    arc, step = gauss(0, math.pi, 200)
    e = np.array([0.0, math.cos(angle), math.sin(angle)])
    rim = np.cos(arc)[:, None] * np.eye(3)[0] + np.sin(arc)[:, None] * e
    along = -np.sin(arc)[:, None] * np.eye(3)[0] + np.cos(arc)[:, None] * e
    way = rim - points[:, None]
    curve = np.cross(way, along)[..., 2] / np.sum(way**2, axis=-1) @ step
    a, b = np.array([-1.0, 0, 0]) - points, np.array([1.0, 0, 0]) - points
    across = np.cross(a, b)[:, 2]
    chord = np.sign(across) * np.arctan2(np.abs(across), np.sum(a * b, axis=-1))
    return float(areas @ np.abs(curve + chord)) / (2 * math.pi) / (math.pi / 2)


# Spheres.


@checks({"disk_radius": 1.0, "distance": 3.0})
def sphere_to_disk(disk_radius: float, distance: float) -> float:
    return share(ORIGIN, ring([0, 0, distance], -UP, 0, disk_radius, n=40))


@checks({"width": 2.0, "length": 0.5, "distance": 0.7})
def sphere_to_rectangle(width: float, length: float, distance: float) -> float:
    return share(ORIGIN, rectangle([0, 0, distance], [0, length, 0], [width, 0, 0], n=60))


@checks({"polygon": ((1.0, 0.0, 1.0), (-1.0, 1.0, 2.0), (0.0, -1.0, 1.5)), "centre": (0.5, 0.1, -1.0)})
def sphere_to_polygon(polygon: Any, centre: Any) -> float:
    corners = np.asarray(polygon)
    return sum(share(centre, triangle(corners[0], *two, n=40)) for two in pairwise(corners[1:]))


@checks({"cylinder_radius": 1.0, "ends": (-2.0, 1.0)})
def sphere_to_cylinder(cylinder_radius: float, ends: Any) -> float:
    return share(ORIGIN, side(cylinder_radius, *ends, n=60))


@checks({"inner_radius": 1.5, "outer_radius": 2.0})
def outer_sphere_to_inner(inner_radius: float, outer_radius: float) -> float:
    # Not concentric: the mean over the outer sphere of the factor to a sphere aside, cos (r / d)^2 of B-43.
    outer = cap(ORIGIN, UP, outer_radius, 2 * outer_radius, n=60)
    way = np.array([0, 0, (outer_radius - inner_radius) / 3]) - outer.points
    d = np.linalg.norm(way, axis=-1)
    seen = np.sum(way * outer.normals, axis=-1) / d * (inner_radius / d) ** 2
    return float(np.average(seen, weights=outer.areas))


@checks({"inner_radius": 0.1, "outer_radius": 2.0})
def outer_sphere_to_itself(inner_radius: float, outer_radius: float) -> float:
    # Chords that turn less than twice arccos(r / R) around the centre miss the inner sphere.
    reach = 2 * math.acos(inner_radius / outer_radius)

    def kernel(turn: np.ndarray) -> np.ndarray:
        r = 2 * outer_radius * np.sin(turn / 2)
        return np.sin(turn / 2) ** 2 / (np.pi * r**2) * 2 * np.pi * outer_radius**2 * np.sin(turn)

    return integral(kernel, (0, reach))


@checks({"area_2": 1.0, "radius": 0.7})
def sphere_patches(area_2: float, radius: float) -> float:
    away = cap(ORIGIN, -UP, radius, 0.3 * radius, n=10, m=20)
    return factor(away, cap(ORIGIN, UP, radius, area_2 / (2 * math.pi * radius), n=10, m=20))


@checks({"radius": 1.0, "height": 0.3}, {"radius": 1.0, "height": 1.7})
def cap_to_base(radius: float, height: float) -> float:
    # All that the base sends meets the cap, so reciprocity leaves the ratio of the areas.
    base = ring(ORIGIN, UP, 0, math.sqrt(height * (2 * radius - height)))
    return float(np.sum(base.areas) / np.sum(cap(ORIGIN, UP, radius, height).areas))


# Long cylinders.


@checks({"radius_1": 1.0, "radius_2": 3.0, "distance": 4.5}, {"radius_1": 2.0, "radius_2": 0.1, "distance": 3.0},
        {"radius_1": 0.001, "radius_2": 1.0, "distance": 1000.0})  # fmt: skip
def parallel_cylinders(radius_1: float, radius_2: float, distance: float) -> float:
    # From each point of cylinder 1 the other spans an angle, cut at the horizon; the factor is half of the sines.
    def seen(turn: np.ndarray) -> np.ndarray:
        x, y = distance - radius_1 * np.cos(turn), -radius_1 * np.sin(turn)
        aside = turn - np.arctan2(y, x)
        spread = np.arcsin(radius_2 / np.hypot(x, y))
        return 0.5 * (1 - np.sin(aside - spread)), np.cos(aside) * np.sin(spread)

    whole, any_ = (math.acos((radius_1 + sign * radius_2) / distance) for sign in (1, -1))
    part = integral(lambda t: seen(t)[1], (0, whole), n=60) + integral(lambda t: seen(t)[0], (whole, any_), n=60)
    return part / math.pi


@checks({"strip": (-1.0, 3.0), "height": 0.7, "radius": 0.3})
def strip_to_cylinder(strip: Any, height: float, radius: float) -> float:
    # The cylinder spans arcsin(r / d) to both sides of its axis, cos of the angle to which is h / d.
    return integral(lambda x: radius * height / (x**2 + height**2), strip, n=100) / (strip[1] - strip[0])


@checks({"diameter": 1.0, "pitch": 1.2}, {"diameter": 1.0, "pitch": 9.0})
def plane_to_tube_row(diameter: float, pitch: float) -> float:
    # Rays at an angle from the normal see tubes d / cos apart from p: all of them are caught where cos < d / p.
    touch = math.acos(diameter / pitch)
    caught = integral(np.cos, (touch, math.pi / 2))
    return caught + integral(lambda t: np.cos(t) * diameter / (pitch * np.cos(t)), (0, touch))


@checks({"inner_radius": 0.5, "outer_radius": 2.0})
def long_outer_cylinder_to_inner(inner_radius: float, outer_radius: float) -> float:
    # Not coaxial: the mean over the outer cylinder of cos (r / d), the factor of a cylinder that spans arcsin(r / d).
    turn = 2 * np.pi * np.arange(400) / 400
    way = 0.3 * (outer_radius - inner_radius) - outer_radius * np.exp(1j * turn)
    return float(np.mean((way * -np.exp(-1j * turn)).real * inner_radius / np.abs(way) ** 2))


@checks({"inner_radius": 0.1, "outer_radius": 2.0})
def long_outer_cylinder_to_itself(inner_radius: float, outer_radius: float) -> float:
    # What misses the inner cylinder is more than arcsin(r / R) aside of the normal.
    return integral(np.cos, (math.asin(inner_radius / outer_radius), math.pi / 2))


# Coaxial cylinders of finite length. The inner one hides what is beyond arccos(r / R) of it in azimuth.


@checks(
    {"inner_radius": 1.0, "outer_radius": 1.5, "length": 0.5}, {"inner_radius": 0.5, "outer_radius": 2.0, "length": 9.0}
)
def outer_cylinder_to_inner(inner_radius: float, outer_radius: float, length: float) -> float:
    r, R = inner_radius, outer_radius

    def kernel(turn: np.ndarray, u: np.ndarray) -> np.ndarray:
        squares = r**2 + R**2 - 2 * r * R * np.cos(turn) + u**2
        cosines = (R - r * np.cos(turn)) * (R * np.cos(turn) - r)
        return 2 * (length - u) * r * cosines / (np.pi * squares**2)

    reach = math.acos(r / R)
    return integral(kernel, (-reach, reach), (0, length), n=160) / length


@checks(
    {"inner_radius": 1.0, "outer_radius": 1.1, "length": 5.0}, {"inner_radius": 0.1, "outer_radius": 2.0, "length": 0.3}
)
def outer_cylinder_to_itself(inner_radius: float, outer_radius: float, length: float) -> float:
    all_, reach = (0.0, length), 2 * math.acos(inner_radius / outer_radius)
    return around_axis(outer_radius, all_, all_, reach)


@checks({"inner_radius": 0.5, "outer_radius": 2.0, "length": 3.0})
def outer_cylinder_to_annular_end(**sizes: float) -> float:
    return (1 - outer_cylinder_to_inner(**sizes) - outer_cylinder_to_itself(**sizes)) / 2


@checks({"inner_radius": 0.5, "outer_radius": 2.0, "length": 3.0})
def inner_cylinder_to_annular_end(**sizes: float) -> float:
    # An outer cylinder would catch what the rings miss.
    return (1 - outer_cylinder_to_inner(**sizes) * sizes["outer_radius"] / sizes["inner_radius"]) / 2


@checks({"inner_radius": 1.0, "outer_radius": 1.5, "length": 1.0}, tolerance=1e-10)
def annular_end_to_other_end(inner_radius: float, outer_radius: float, length: float) -> float:
    # Radii r sqrt(1 + s^2), so that what the inner cylinder hides, beyond arctan s of both, is smooth.
    top = math.sqrt((outer_radius / inner_radius) ** 2 - 1)

    def kernel(s: np.ndarray, t: np.ndarray, share: np.ndarray) -> np.ndarray:
        a, b = inner_radius * np.hypot(1, s), inner_radius * np.hypot(1, t)
        reach = np.arctan(s) + np.arctan(t)
        squares = a**2 + b**2 - 2 * a * b * np.cos(reach * share) + length**2
        return 2 * reach * length**2 / (np.pi * squares**2) * s * t * inner_radius**4

    flux = integral(kernel, (0, top), (0, top), (0, 1), n=40)
    return 2 * flux / (outer_radius**2 - inner_radius**2)


# The inside of a cylinder.


@checks({"radius": 1.0, "height": 2.5}, {"radius": 0.7, "height": 0.8})
def cylinder_base_to_side(radius: float, height: float) -> float:
    return 1 - coaxial_disks(radius, radius, height)


@checks({"radius": 1.0, "height": 2.5})
def cylinder_side_to_base(radius: float, height: float) -> float:
    return cylinder_base_to_side(radius, height) * radius / (2 * height)


@checks({"radius": 1.0, "height": 2.5}, {"radius": 1.0, "height": 0.01})
def cylinder_side_to_itself(radius: float, height: float) -> float:
    return around_axis(radius, (0, height), (0, height))


@checks({"radius": 0.7, "section": (1.0, 1.1)}, {"radius": 0.5, "section": (2.0, 9.0)})
def cylinder_section_to_disk(radius: float, section: Any) -> float:
    r, w = gauss(0, radius, 40)
    wall = side(radius, *section, n=60, m=100)
    flux = [2 * math.pi * x * y * point_factor(np.array([x, 0, 0]), UP, wall) for x, y in zip(r, w, strict=True)]
    return sum(flux) / (2 * math.pi * radius * (section[1] - section[0]))


@checks({"radius": 1.0, "distance": 3.0})
def cylinder_ring_to_disk(radius: float, distance: float) -> float:
    return point_factor(np.array([radius, 0, distance]), np.array([-1.0, 0, 0]), ring(ORIGIN, UP, 0, radius, 80, 200))


@checks({"radius": 1.0, "height": 3.0, "position": 1.5})
def cylinder_point_to_side(radius: float, height: float, position: float) -> float:
    return 1 - cylinder_ring_to_disk(radius, position) - cylinder_ring_to_disk(radius, height - position)


@checks({"radius": 1.0, "section_1": (0.0, 1.0), "section_2": (3.0, 5.0)},
        {"radius": 1.0, "section_1": (0.0, 2.0), "section_2": (0.5, 1.0)},
        {"radius": 0.5, "section_1": (1.0, 1.3), "section_2": (0.9, 1.2)})  # fmt: skip
def cylinder_section_to_section(radius: float, section_1: Any, section_2: Any) -> float:
    return around_axis(radius, section_1, section_2)


@checks({"disk_radius": 0.2, "radius": 1.0, "height": 2.0})
def cylinder_disk_to_side(disk_radius: float, radius: float, height: float) -> float:
    return 1 - coaxial_disks(disk_radius, radius, height)


@checks({"inner": 0.2, "outer": 0.5, "radius": 1.0, "height": 2.0})
def cylinder_ring_to_side(inner: float, outer: float, radius: float, height: float) -> float:
    return 1 - coaxial_rings(inner, outer, 0, radius, height)


# Cones and frusta.


@checks({"base_radius": 1.0, "top_radius": 1.5, "height": 1.0})
def frustum_base_to_side(base_radius: float, top_radius: float, height: float) -> float:
    return 1 - coaxial_disks(base_radius, top_radius, height) if top_radius else 1.0


@checks({"base_radius": 1.0, "top_radius": 1.5, "height": 1.0})
def frustum_side_to_base(base_radius: float, top_radius: float, height: float) -> float:
    area = (base_radius + top_radius) * math.hypot(height, base_radius - top_radius)
    return frustum_base_to_side(base_radius, top_radius, height) * base_radius**2 / area


@checks({"base_radius": 1.0, "top_radius": 1.5, "height": 1.0}, {"base_radius": 1.0, "top_radius": 0.7, "height": 2.0})
def frustum_side_to_itself(base_radius: float, top_radius: float, height: float) -> float:
    tops = frustum_side_to_base(top_radius, base_radius, height) if top_radius else 0.0
    return 1 - frustum_side_to_base(base_radius, top_radius, height) - tops


@checks({"radius_1": 0.3, "radius_2": 1.0, "radius_3": 0.9, "height_1": 0.5, "height_2": 2.0}, tolerance=1e-6)
def frustum_to_attached_frustum(
    radius_1: float, radius_2: float, radius_3: float, height_1: float, height_2: float
) -> float:
    # Over shares of the way from the common rim and azimuth, all of them cubes so that points gather at the rim.
    def kernel(s: np.ndarray, t: np.ndarray, p: np.ndarray) -> np.ndarray:
        a, b, turn = radius_2 + s**3 * (radius_1 - radius_2), radius_2 + t**3 * (radius_3 - radius_2), math.pi * p**3
        way = np.stack([b * np.cos(turn) - a, b * np.sin(turn), t**3 * height_2 + s**3 * height_1])
        # Normals times slant heights: one across (radius_1 - radius_2, -height_1), the other across (.., height_2).
        one = -height_1 * way[0] + (radius_2 - radius_1) * way[2]
        radial = way[0] * np.cos(turn) + way[1] * np.sin(turn)
        two = height_2 * radial - (radius_3 - radius_2) * way[2]
        cosines = np.maximum(one, 0) * np.maximum(two, 0)
        steps = 27 * (s * t * p) ** 2 * math.pi
        return 2 * a * b * cosines / (np.pi * np.sum(way**2, axis=0) ** 2) * steps

    area = math.pi * (radius_1 + radius_2) * math.hypot(height_1, radius_1 - radius_2)
    return 2 * math.pi * integral(kernel, *[(0.0, 1.0)] * 3, n=48) / area


# What follows asks of every configuration, and of families, what no single value can show.

every_configuration = pytest.mark.parametrize("entry", CONFIGURATIONS, ids=lambda entry: entry.name)


@every_configuration
def test_it_is_the_integral_of_its_definition(entry: Configuration) -> None:
    definition, places, tolerance = INTEGRALS[entry.name]
    assert entry.value == pytest.approx(definition(**entry.example), rel=tolerance)
    for arguments in [dict(entry.example), *places]:
        assert entry.function(**arguments) == pytest.approx(definition(**arguments), rel=tolerance), arguments


@every_configuration
def test_the_example_has_the_value_that_it_states(entry: Configuration) -> None:
    factor = entry.function(**entry.example)
    assert isinstance(factor, float) and 0 <= factor <= 1
    assert factor == pytest.approx(entry.value, rel=1e-13)


@pytest.mark.parametrize(("name", "arguments", "value", "tolerance"), TABLE, ids=[row[0] for row in TABLE])
def test_it_has_the_published_value(name: str, arguments: dict[str, Any], value: float, tolerance: float) -> None:
    assert getattr(catalogue, name)(**arguments) == pytest.approx(value, abs=tolerance)


@every_configuration
@pytest.mark.parametrize("scale", [1e-3, 1e4])
def test_the_unit_of_length_does_not_matter(entry: Configuration, scale: float) -> None:
    scaled = {
        name: value if name in ANGLES | {"normal"} else np.asarray(value) * scale ** (2 if name == "area_2" else 1)
        for name, value in entry.example.items()
    }
    assert entry.function(**scaled) == pytest.approx(entry.value, rel=1e-12)


@every_configuration
def test_arguments_broadcast(entry: Configuration) -> None:
    points = {"polygon", "position", "normal", "centre", "start_1", "end_1", "start_2", "end_2"}

    def repeated(name: str, value: Any) -> Any:
        if name in points:
            value = np.asarray(value)
            return np.broadcast_to(value, (2, 3, *value.shape))
        return tuple(np.full((2, 1), end) for end in value) if isinstance(value, tuple) else np.full(3, value)

    factors = entry.function(**{name: repeated(name, value) for name, value in entry.example.items()})
    assert factors.shape in {(2, 3), (3,), (2, 1)}
    np.testing.assert_allclose(factors, entry.value, rtol=1e-12)


@every_configuration
@pytest.mark.parametrize("bad", [math.nan, math.inf, "wide"])
def test_bad_numbers_are_named(entry: Configuration, bad: object) -> None:
    for name, value in entry.example.items():
        spoiled = np.where(True, bad, value) if isinstance(value, tuple) and isinstance(value[0], tuple) else bad
        spoiled = (bad, *value[1:]) if isinstance(value, tuple) and spoiled is bad else spoiled
        with pytest.raises(ValueError, match=name):
            entry.function(**{**entry.example, name: spoiled})


SIGNED = ANGLES | {"distance_1", "distance_2"}


@every_configuration
def test_sizes_below_zero_are_named(entry: Configuration) -> None:
    for name, value in entry.example.items():
        if isinstance(value, float) and value and name not in SIGNED:
            with pytest.raises(ValueError, match=rf"{name} must (not )?be (positive|negative)"):
                entry.function(**{**entry.example, name: [value, -value]})


@pytest.mark.parametrize(
    ("name", "wrong", "message"),
    [
        ("parallel_rectangles", {"x_1": (1.0, 0.0)}, "x_1 must start before it ends: exchange"),
        ("perpendicular_rectangles", {"z_2": (-1.0, 1.0)}, "z_2 must not start below 0: move or cut"),
        ("hinged_rectangles", {"angle": 4.0}, "angle must be from 0 to 3.14159 radians, not 4"),
        ("hinged_rectangles", {"angle": 0.0}, "angle must be above 0"),
        ("point_to_sphere", {"distance": 0.5}, "distance must be at least radius"),
        ("point_to_cylinder", {"distance": 1.0}, "distance must exceed radius"),
        ("point_to_perpendicular_disk", {"radius": 2.0}, "radius must not exceed distance"),
        ("point_to_tilted_rectangle", {"angle": 0.0}, "angle must be above 0 and below pi"),
        ("point_to_infinite_strip", {"angle_2": 2.0}, "angle_2 must be from"),
        ("point_to_polygon", {"polygon": np.zeros((2, 3))}, "polygon must have three corners"),
        ("point_to_polygon", {"position": [0.0, 0.0]}, "position must have x, y, z"),
        ("point_to_polygon", {"normal": [0.0, 0.0, 0.0]}, "normal must have a length"),
        ("sphere_to_polygon", {"polygon": np.zeros((2, 3))}, "polygon must have three corners"),
        ("coaxial_rings", {"inner_1": 1.0}, "inner_1 must be below outer_1"),
        ("coaxial_rings", {"inner_2": 2.0}, "inner_2 must be below outer_2"),
        ("disks_in_a_sphere", {"distance_1": 1.0}, "distance_1 must be below sphere_radius"),
        ("disks_in_a_sphere", {"distance_2": -1.0}, "distance_2 must be below sphere_radius"),
        ("disks_in_a_sphere", {"distance_2": -0.9}, "distance_1 and distance_2"),
        ("parallel_cylinders", {"distance": 1.9}, "distance must be at least radius_1 [+] radius_2"),
        ("strip_to_cylinder", {"radius": 1.5}, "height must be at least radius"),
        ("plane_to_tube_row", {"pitch": 0.9}, "pitch must be at least diameter"),
        ("long_outer_cylinder_to_inner", {"inner_radius": 3.0}, "inner_radius must not exceed outer_radius: exchange"),
        ("outer_sphere_to_itself", {"inner_radius": 3.0}, "inner_radius must not exceed outer_radius: exchange"),
        ("outer_cylinder_to_inner", {"inner_radius": 2.0}, "inner_radius must be below outer_radius"),
        ("sphere_patches", {"area_2": 13.0}, "area_2 must not exceed the area of the sphere"),
        ("cap_to_base", {"height": 2.1}, "height must not exceed 2 radius"),
        ("cylinder_section_to_disk", {"section": (-1.0, 1.0)}, "section must not start below 0"),
        ("cylinder_point_to_side", {"position": 2.1}, "position must not exceed height"),
        ("cylinder_disk_to_side", {"disk_radius": 1.1}, "disk_radius must not exceed radius"),
        ("cylinder_ring_to_side", {"outer": 1.1}, "outer must not exceed radius"),
        ("frustum_to_attached_frustum", {"radius_2": 0.9}, "radius_2 must not be a waist"),
        ("crossed_strings", {"crossed": (4.0, 3.0)}, "exchange the two pairs"),
        ("triangular_duct", {"side_1": 0.5}, "must make a triangle"),
        ("segments", {"end_1": (0.5, 0.0)}, "a segment has a length"),
        ("segments", {"start_1": 0.5}, "start_1 must have x and y"),
        ("segments", {"start_2": (0.0, 1.0), "end_2": (0.0, 2.0)}, "exchange start and end"),
    ],
    ids=lambda x: x if isinstance(x, str) and " " not in x else "",
)  # fmt: skip
def test_impossible_geometry_is_refused(name: str, wrong: dict[str, Any], message: str) -> None:
    (entry,) = (entry for entry in CONFIGURATIONS if entry.name == name)
    with pytest.raises(ValueError, match=message):
        entry.function(**{**entry.example, **wrong})


# The list itself.


def test_the_list_is_complete() -> None:
    names = [entry.name for entry in CONFIGURATIONS]
    functions = {name for name in catalogue.__all__ if inspect.isfunction(getattr(catalogue, name))}
    assert sorted(names) == names and set(names) == functions - {"find"}
    assert len({entry.number for entry in CONFIGURATIONS if entry.number}) >= 25


@every_configuration
def test_it_is_described(entry: Configuration) -> None:
    text = inspect.getdoc(entry.function)
    assert text and text.startswith("F_")
    assert all(part in text for part in ("Args:", "Source:", "Raises:"))
    assert all(name in text for name in inspect.signature(entry.function).parameters)
    if entry.number:
        assert entry.number in text


def test_entries_are_found() -> None:
    assert [entry.number for entry in catalogue.find("c-14")] == ["C-14"]
    assert {entry.name for entry in catalogue.find("coaxial DISK")} == {"coaxial_disks", "sphere_to_disk"}
    assert catalogue.find("torus") == ()
    assert str(catalogue.find("coaxial_disks")[0]) == "C-41   coaxial_disks: disk to coaxial parallel disk"


def test_it_needs_no_engine() -> None:
    script = "import sys, radiosity.catalogue; print('radiosity._native' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


# Enclosures: what leaves a surface arrives somewhere.


@few
@given(sizes, sizes, sizes)
def test_a_box_is_closed(a: float, b: float, c: float) -> None:
    walls = [catalogue.perpendicular_rectangles_with_common_edge(width_1=a, width_2=c, length=b),
             catalogue.perpendicular_rectangles_with_common_edge(width_1=b, width_2=c, length=a)]  # fmt: skip
    ceiling = catalogue.equal_parallel_rectangles(width=a, length=b, gap=c)
    assert ceiling + 2 * sum(walls) == pytest.approx(1, abs=1e-14)


@few
@given(sizes, sizes, sizes)
def test_a_frustum_is_closed(a: float, b: float, h: float) -> None:
    frustum = {"base_radius": a, "top_radius": b, "height": h}
    other = catalogue.frustum_side_to_base(base_radius=b, top_radius=a, height=h)
    to_itself, to_base = catalogue.frustum_side_to_itself(**frustum), catalogue.frustum_side_to_base(**frustum)
    assert to_itself + to_base + other == pytest.approx(1, abs=1e-14)
    across = catalogue.coaxial_disks(radius_1=a, radius_2=b, gap=h)
    assert catalogue.frustum_base_to_side(**frustum) + across == pytest.approx(1, abs=1e-14)


@few
@given(sizes, sizes, sizes)
def test_coaxial_cylinders_are_closed(r: float, gap: float, length: float) -> None:
    sizes = {"inner_radius": r, "outer_radius": r + gap, "length": length}
    ring = gap * (2 * r + gap)
    from_outer, from_inner = (
        catalogue.outer_cylinder_to_annular_end(**sizes),
        catalogue.inner_cylinder_to_annular_end(**sizes),
    )
    total = catalogue.annular_end_to_other_end(**sizes) * ring
    total += 2 * length * (r * from_inner + (r + gap) * from_outer)
    assert total == pytest.approx(ring, abs=1e-14 * (ring + 2 * length * (2 * r + gap)))


@few
@given(sizes, st.lists(st.floats(0.1, 2.0), min_size=3, max_size=5))
def test_sections_of_a_cylinder_are_closed(r: float, lengths: list[float]) -> None:
    ends = np.concatenate([[0.0], np.cumsum(lengths)])
    first = (ends[0], ends[1])
    sections = catalogue.cylinder_section_to_section(radius=r, section_1=first, section_2=(ends[:-1], ends[1:]))
    floor = catalogue.cylinder_section_to_disk(radius=r, section=first)
    ceiling = catalogue.cylinder_section_to_disk(radius=r, section=(ends[-1] - ends[1], ends[-1]))
    assert np.sum(sections) + floor + ceiling == pytest.approx(1, abs=1e-13 * max(1, r / lengths[0]))


CUBE = [(np.roll([s, -1, -1], k), np.roll([s, -1, 1], k), np.roll([s, 1, 1], k), np.roll([s, 1, -1], k))
        for k in range(3) for s in (-1, 1)]  # fmt: skip


@few
@given(st.tuples(*[st.floats(-0.9, 0.9)] * 3), st.tuples(*[st.floats(-1, 1)] * 3))
def test_a_point_sees_all_of_a_cube_cut_at_its_horizon(place: tuple[float, ...], normal: tuple[float, ...]) -> None:
    up = np.array(normal) + np.array([0, 0, 1.5])
    faces = catalogue.point_to_polygon(polygon=CUBE, position=place, normal=up)
    assert np.sum(faces) == pytest.approx(1, abs=1e-14)
    back = catalogue.point_to_polygon(polygon=CUBE, position=place, normal=-up)
    assert np.sum(back) == pytest.approx(1, abs=1e-14)
    assert np.sum(catalogue.sphere_to_polygon(polygon=CUBE, centre=place)) == pytest.approx(1, abs=1e-14)


def test_a_polygon_with_prongs_is_cut_at_the_horizon() -> None:
    # A comb in the plane x = 1 whose teeth reach below the horizon; above it two squares and a bar, each whole.
    comb = [(1, y, z) for y, z in ((0, 2), (0, -1), (1, -1), (1, 1), (2, 1), (2, -3), (3, -3), (3, 2))]
    parts = [
        [(1, y, z), (1, y + w, z), (1, y + w, z + 1), (1, y, z + 1)] for y, z, w in ((0, 0, 1), (2, 0, 1), (0, 1, 3))
    ]
    at = {"position": (0.0, 0.3, 0.0), "normal": (0.0, 0.0, 1.0)}
    whole = sum(catalogue.point_to_polygon(polygon=part, **at) for part in parts)
    assert catalogue.point_to_polygon(polygon=comb, **at) == pytest.approx(whole, rel=1e-14)
    assert catalogue.point_to_polygon(polygon=comb[::-1], **at) == pytest.approx(whole, rel=1e-14)
    assert catalogue.point_to_polygon(polygon=np.array(comb) - [0, 0, 2], **at) == 0


# The way back, and the whole as the sum of its parts.

places = st.tuples(st.floats(-5, 5), st.floats(0.1, 3)).map(lambda pair: (pair[0], pair[0] + pair[1]))
ahead = st.tuples(st.floats(0, 5), st.floats(0.1, 3)).map(lambda pair: (pair[0], pair[0] + pair[1]))


def length(ends: tuple[float, float]) -> float:
    return ends[1] - ends[0]


@few
@given(places, places, places, places, st.floats(0.1, 5))
def test_parallel_rectangles_are_reciprocal_and_add(x_1: Any, y_1: Any, x_2: Any, y_2: Any, gap: float) -> None:
    there = catalogue.parallel_rectangles(x_1=x_1, y_1=y_1, x_2=x_2, y_2=y_2, gap=gap)
    back = catalogue.parallel_rectangles(x_1=x_2, y_1=y_2, x_2=x_1, y_2=y_1, gap=gap)
    one, two = length(x_1) * length(y_1), length(x_2) * length(y_2)
    assert one * there == pytest.approx(two * back, abs=1e-13)
    middle = x_2[0] + 0.3 * length(x_2)
    halves = [catalogue.parallel_rectangles(x_1=x_1, y_1=y_1, x_2=x, y_2=y_2, gap=gap)
              for x in ((x_2[0], middle), (middle, x_2[1]))]  # fmt: skip
    assert one * sum(halves) == pytest.approx(one * there, abs=1e-13)


@few
@given(ahead, places, places, ahead)
def test_perpendicular_rectangles_are_reciprocal(x_1: Any, y_1: Any, y_2: Any, z_2: Any) -> None:
    there = catalogue.perpendicular_rectangles(x_1=x_1, y_1=y_1, y_2=y_2, z_2=z_2)
    back = catalogue.perpendicular_rectangles(x_1=z_2, y_1=y_2, y_2=y_1, z_2=x_1)
    assert length(x_1) * length(y_1) * there == pytest.approx(length(z_2) * length(y_2) * back, abs=1e-13)


@few
@given(ahead, ahead, st.floats(0.01, 3.1))
def test_strips_at_an_angle_are_segments(u_1: Any, u_2: Any, angle: float) -> None:
    way = np.array([math.cos(angle), math.sin(angle)])
    strips = catalogue.strips_at_angle(u_1=u_1, u_2=u_2, angle=angle)
    ends = {"start_1": [u_1[0], 0.0], "end_1": [u_1[1], 0.0], "start_2": u_2[1] * way, "end_2": u_2[0] * way}
    assert catalogue.segments(**ends) == pytest.approx(strips, rel=1e-11, abs=1e-15)
    back = catalogue.strips_at_angle(u_1=u_2, u_2=u_1, angle=angle)
    assert length(u_1) * strips == pytest.approx(length(u_2) * back, rel=1e-11, abs=1e-15)


@few
@given(sizes, sizes, sizes, st.floats(0.01, 3.1))
def test_hinged_rectangles_are_reciprocal(a: float, b: float, c: float, angle: float) -> None:
    there = catalogue.hinged_rectangles(width_1=a, width_2=b, length=c, angle=angle)
    back = catalogue.hinged_rectangles(width_1=b, width_2=a, length=c, angle=angle)
    assert a * there == pytest.approx(b * back, abs=1e-12 * max(a, b))
    square = catalogue.hinged_rectangles(width_1=a, width_2=b, length=c, angle=math.pi / 2)
    known = catalogue.perpendicular_rectangles_with_common_edge(width_1=a, width_2=b, length=c)
    assert square == pytest.approx(known, abs=1e-12 * max(1, (max(a, b, c) / a) ** 2))


@few
@given(sizes, sizes, sizes)
def test_strings_around_cylinders(a: float, b: float, gap: float) -> None:
    # Crossed strings are the inner tangents with the arcs that they wrap, uncrossed the outer ones; both halves alike.
    d = a + b + gap
    inner = math.sqrt(d**2 - (a + b) ** 2) + (a + b) * math.asin((a + b) / d)
    outer = math.sqrt(d**2 - (a - b) ** 2) + (a - b) * math.asin((a - b) / d)
    strings = catalogue.crossed_strings(crossed=(inner, inner), uncrossed=(outer, outer), width=2 * math.pi * a)
    cylinders = catalogue.parallel_cylinders(radius_1=a, radius_2=b, distance=d)
    assert strings == pytest.approx(cylinders, abs=1e-14 * d / a)


# Limits, where formulas as printed lose all their digits.


@pytest.mark.parametrize("far", [1e2, 1e4, 1e7])
def test_far_apart_only_area_and_angle_count(far: float) -> None:
    # cos cos A_2 / (pi r^2); the next term is smaller by the square of size over distance.
    near = {"rel": 10 / far**2 + 1e-12}
    at = catalogue
    assert at.equal_parallel_rectangles(width=1, length=2, gap=far) * math.pi * far**2 == pytest.approx(2, **near)
    assert at.coaxial_squares(edge_1=1, edge_2=2, gap=far) * math.pi * far**2 == pytest.approx(4, **near)
    assert at.coaxial_disks(radius_1=1, radius_2=2, gap=far) * far**2 == pytest.approx(4, **near)
    assert at.point_to_parallel_disk(radius=1, distance=1, offset=far) * far**4 == pytest.approx(1, **near)
    assert at.sphere_to_disk(disk_radius=1, distance=far) * 4 * far**2 == pytest.approx(1, **near)
    assert at.sphere_to_rectangle(width=1, length=1, distance=far) * 4 * math.pi * far**2 == pytest.approx(1, **near)
    assert at.cylinder_side_to_base(radius=1, height=far) * 2 * far == pytest.approx(1, **near)
    assert at.cylinder_ring_to_disk(radius=1, distance=far) * far**3 == pytest.approx(1, **near)
    assert at.equal_parallel_strips(width=1, gap=far) * 2 * far == pytest.approx(1, rel=1 / far)
    assert at.parallel_cylinders(radius_1=1, radius_2=1, distance=far) * math.pi * far == pytest.approx(1, **near)
    assert at.plane_to_tube_row(diameter=1, pitch=far) * 2 * far == pytest.approx(math.pi, rel=1 / far)
    aside = at.parallel_rectangles(x_1=(0, 1), y_1=(0, 1), x_2=(far, far + 1), y_2=(0, 1), gap=far)
    assert aside * 4 * math.pi * far**2 == pytest.approx(1, **near)
    across = at.perpendicular_rectangles(x_1=(far, far + 1), y_1=(0, 1), y_2=(0, 1), z_2=(far, far + 1))
    assert across * 4 * math.pi * far**2 == pytest.approx(1, rel=3 / far + 1e-12)


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9])
def test_close_together_all_arrives(gap: float) -> None:
    # Of equal surfaces perimeter x gap / 2 over the area is lost, in the first place.
    at = catalogue
    close = {"abs": 10 * gap**2 * max(1, -math.log(gap)) + 1e-15}
    assert 1 - at.equal_parallel_rectangles(width=1, length=2, gap=gap) == pytest.approx(1.5 * gap, **close)
    assert 1 - at.coaxial_disks(radius_1=1, radius_2=1, gap=gap) == pytest.approx(gap, **close)
    assert 1 - at.equal_parallel_strips(width=1, gap=gap) == pytest.approx(gap, **close)
    assert at.cylinder_base_to_side(radius=1, height=gap) == pytest.approx(gap, rel=gap)
    assert at.cylinder_side_to_itself(radius=1, height=gap) == pytest.approx(gap / 2, rel=gap)
    assert at.outer_cylinder_to_inner(inner_radius=1, outer_radius=1 + gap, length=1) == pytest.approx(1, abs=2 * gap)
    assert at.coaxial_disks(radius_1=1, radius_2=2, gap=gap) == pytest.approx(1, abs=gap**2)


def test_limits_that_have_names() -> None:
    at, long = catalogue, 1e8
    strip = at.strips_with_common_edge(width_1=1, width_2=0.5, angle=1.0)
    assert at.hinged_rectangles(width_1=1, width_2=0.5, length=1e4, angle=1.0) == pytest.approx(strip, rel=1e-4)
    facing = at.equal_parallel_strips(width=1, gap=1)
    assert at.equal_parallel_rectangles(width=1, length=long, gap=1) == pytest.approx(facing, rel=1e-7)
    assert at.outer_cylinder_to_inner(inner_radius=1, outer_radius=3, length=long) == pytest.approx(1 / 3, rel=1e-7)
    assert at.outer_cylinder_to_itself(inner_radius=1, outer_radius=3, length=long) == pytest.approx(2 / 3, rel=1e-7)
    # A thin wire within: what remains is the inside of one cylinder.
    wire = at.outer_cylinder_to_itself(inner_radius=1e-9, outer_radius=1, length=2)
    assert wire == pytest.approx(at.cylinder_side_to_itself(radius=1, height=2), abs=1e-8)
    assert at.frustum_side_to_itself(base_radius=1, top_radius=1, height=2) == pytest.approx(
        at.cylinder_side_to_itself(radius=1, height=2), rel=1e-15
    )
    # A sphere that touches the element covers half of what it sees when it is level, all when it is above.
    assert at.point_to_sphere(radius=1, distance=1, tilt=[0, math.pi / 2, math.pi]) == pytest.approx([1, 0.5, 0])
    assert at.tilted_plane_to_ground(tilt=[0, math.pi / 2, math.pi]) == pytest.approx([0, 0.5, 1])
    assert at.cap_to_base(radius=1, height=[1, 2]) == pytest.approx([0.5, 0])
    # Disks in one sphere that are parallel are coaxial disks.
    assert at.disks_in_a_sphere(sphere_radius=1, distance_1=0.6, distance_2=0.8) == pytest.approx(
        at.coaxial_disks(radius_1=0.8, radius_2=0.6, gap=1.4), rel=1e-14
    )


@pytest.mark.parametrize("tilt", [math.pi / 6, 5 * math.pi / 6])
def test_a_sphere_sinks_below_the_horizon_without_a_step(tilt: float) -> None:
    # Half angle 60 degrees: the sphere meets the horizon at 30 and is gone at 150 degrees.
    around = catalogue.point_to_sphere(radius=math.sqrt(3), distance=2.0, tilt=tilt + np.array([-1e-9, 0, 1e-9]))
    assert np.ptp(around) < 2e-9


def test_both_ways_to_far_rectangles_agree() -> None:
    # Across the distance at which the corner sum gives way to points.
    reach = 4 * math.sqrt(2)
    for offset in (0.999 * reach, 1.001 * reach):
        box = {"x_1": (0, 1), "y_1": (0, 1), "x_2": (0, 1), "y_2": (0, 1), "gap": offset}
        same = catalogue.equal_parallel_rectangles(width=1, length=1, gap=offset)
        assert catalogue.parallel_rectangles(**box) == pytest.approx(same, rel=1e-12)
