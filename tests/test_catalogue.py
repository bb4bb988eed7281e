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
    ("perpendicular_rectangles_with_common_edge", {"width_1": 1, "width_2": 1, "length": 1}, 0.20004377607540316, 1e-15),
    ("perpendicular_rectangles_with_common_edge", {"width_1": 1, "width_2": 0.5, "length": 1}, 0.1461866791, 5e-11),
    ("perpendicular_rectangles_with_common_edge", {"width_1": 1, "width_2": 2, "length": 1}, 0.2328526028, 5e-11),
    ("point_to_parallel_rectangle", {"width": 1, "length": 1, "distance": 1}, 0.1385316060, 5e-11),
    ("point_to_perpendicular_rectangle", {"height": 1, "length": 1, "distance": 1}, 0.0557341970, 5e-11),
    ("coaxial_disks", {"radius_1": 1, "radius_2": 1, "gap": 1}, 0.3819660113, 5e-11),
    ("coaxial_disks", {"radius_1": 0.5, "radius_2": 1, "gap": 1}, 0.4688711259 / 1, 1.0),
    ("point_to_parallel_disk", {"radius": 1, "distance": 1}, 0.5, 1e-15),
    ("equal_parallel_strips", {"width": 1, "gap": 1}, 0.4142135624, 5e-11),
    ("strips_with_common_edge", {"width_1": 1, "width_2": 1, "angle": math.pi / 2}, 0.2928932188, 5e-11),
    ("strips_with_common_edge", {"width_1": 1, "width_2": 1, "angle": math.pi / 3}, 0.5, 1e-15),
    ("parallel_cylinders", {"radius_1": 1, "radius_2": 1, "distance": 3}, 0.1106959697, 5e-11),
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
    caught = integral(lambda t: np.cos(t), (touch, math.pi / 2))
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


@checks({"inner_radius": 1.0, "outer_radius": 1.5, "length": 0.5}, {"inner_radius": 0.5, "outer_radius": 2.0, "length": 9.0})
def outer_cylinder_to_inner(inner_radius: float, outer_radius: float, length: float) -> float:
    r, R = inner_radius, outer_radius

    def kernel(turn: np.ndarray, u: np.ndarray) -> np.ndarray:
        squares = r**2 + R**2 - 2 * r * R * np.cos(turn) + u**2
        cosines = (R - r * np.cos(turn)) * (R * np.cos(turn) - r)
        return 2 * (length - u) * r * cosines / (np.pi * squares**2)

    reach = math.acos(r / R)
    return integral(kernel, (-reach, reach), (0, length), n=160) / length


@checks({"inner_radius": 1.0, "outer_radius": 1.1, "length": 5.0}, {"inner_radius": 0.1, "outer_radius": 2.0, "length": 0.3})
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


@pytest.mark.parametrize("entry", CONFIGURATIONS, ids=lambda entry: entry.name)
def test_every_configuration_is_the_integral_of_its_definition(entry: Configuration) -> None:
    definition, places, tolerance = INTEGRALS[entry.name]
    for arguments in [dict(entry.example), *places]:
        assert entry.function(**arguments) == pytest.approx(definition(**arguments), rel=tolerance), arguments


@pytest.mark.parametrize("entry", CONFIGURATIONS, ids=lambda entry: entry.name)
def test_examples_have_the_values_that_they_state(entry: Configuration) -> None:
    assert entry.function(**entry.example) == pytest.approx(entry.value, rel=1e-12)


@pytest.mark.parametrize(("name", "arguments", "value", "tolerance"), TABLE, ids=lambda x: x if isinstance(x, str) else "")
def test_published_values(name: str, arguments: dict[str, Any], value: float, tolerance: float) -> None:
    assert getattr(catalogue, name)(**arguments) == pytest.approx(value, abs=tolerance)
