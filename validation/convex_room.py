"""Interreflection between the rectangles of an upright box, or some of them, by small panels of constant radiosity.

What they send straight away is exact, and so is the form factor from a point to a panel; panels get smaller toward the
edges, where irradiance changes fast. The error is of second order in their size, and a solution on larger panels takes
most of it off. The last gather is from still smaller ones, as a point near an edge sees those across it one by one.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, partial

import numpy as np
import numpy.typing as npt
from exact_light import from_lamp, mean_by_gauss, mean_over

import radiosity

Floats = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]


class ConvexRoom:
    """Irradiance on surfaces that are one upright rectangle each and hide nothing from each other.

    Args:
        scene: of which all surfaces are such rectangles.
        from_lights: (k, bands) at points with normals, of lights without area.
        reflecting: the surfaces that panels are cut from, if several of the scene are one.
        panels: along each edge of a rectangle; with half as many, to tell the error, and with more for the last gather.
    """

    def __init__(
        self,
        scene: radiosity.Scene,
        from_lights: Callable[[Floats, Floats], Floats] | None = None,
        reflecting: list[radiosity.Surface] | None = None,
        panels: int = 16,
    ) -> None:
        self.from_lights, self.bands = from_lights, len(scene.bands)
        self.corners, self.normal = _rectangles(scene.surfaces)
        self.emission = _spectra([s.emission for s in scene.surfaces], self.bands)
        cut = partial(Panels, reflecting or scene.surfaces, self.bands)
        self.grids, self.last = (cut(panels), cut(panels // 2)), cut(2 * panels)

    def direct_at(self, points: Floats, surface: Indices) -> Floats:
        """(k, bands) what lamps send straight away; exact."""
        return self.direct_at_normals(points, self.normal[surface])

    def direct_at_normals(self, points: Floats, normal: Floats) -> Floats:
        """The same at points with normals."""
        found = np.zeros((len(points), self.bands))
        for k in np.flatnonzero(self.emission.any(axis=1)):
            found += from_lamp(points, normal, self.corners[k], [])[:, None] * self.emission[k]
        return found if self.from_lights is None else found + self.from_lights(points, normal)

    def irradiance_at(self, points: Floats, surface: Indices) -> Floats:
        """(k, bands) all light."""
        return self.direct_at(points, surface) + self.indirect_at(points, surface)

    def means(self, patches: radiosity.Patches) -> Floats:
        """(n, bands) of all light over patches."""
        return mean_over(patches, self.direct_at) + mean_by_gauss(patches, self.indirect_at)

    def indirect_at(self, points: Floats, surface: Indices) -> Floats:
        """(k, bands) what panels reflect."""
        return _seen(self.last, self._sent, points, self.normal[surface])

    @cached_property
    def _sent(self) -> Floats:
        """(panels of the last gather, bands) by extrapolation from two grids (Richardson), at Gauss points."""
        fine, coarse = self.grids
        points, normal = self.last.points()
        light = [_seen(grid, grid.solved(self.direct_at_normals), points, normal) for grid in (fine, coarse)]
        arriving = self.direct_at_normals(points, normal) + light[0] + (light[0] - light[1]) / 3
        mean = arriving.reshape(-1, 4, self.bands).mean(axis=1)
        return np.repeat(self.last.reflectance, self.last.count**2, axis=0) * mean


def _seen(grid: Panels, sent: Floats, points: Floats, normal: Floats) -> Floats:
    """(k, bands) at points with normals, of what all panels of a grid send."""
    found = np.zeros((len(points), sent.shape[1]))
    for first in range(0, len(points), 500):
        part = slice(first, first + 500)
        found[part] = grid.factors(points[part], normal[part]) @ sent
    return found


class Panels:
    """Rectangles cut into small panels, closer at the edges, that reflect evenly."""

    def __init__(self, surfaces: list[radiosity.Surface], bands: int, count: int) -> None:
        self.corners, self.normal = _rectangles(surfaces)
        self.reflectance, self.count = _spectra([s.reflectance for s in surfaces], bands), count
        self.edges: Floats = 0.5 * (1 - np.cos(np.pi * np.linspace(0, 1, count + 1)))

    def points(self) -> tuple[Floats, Floats]:
        """(4 a panel, 3) Gauss points, one after the other, and the normals there."""
        middle, half = 0.5 * (self.edges[:-1] + self.edges[1:]), 0.5 * np.diff(self.edges)
        at = middle + np.array([[-1], [1]]) / np.sqrt(3) * half
        s, t = (g.ravel()[:, None] for g in np.meshgrid(at, at, indexing="ij"))
        points = np.array([a + s * (b - a) + t * (d - a) for a, b, _, d in self.corners])
        n = self.count
        each = points.reshape(-1, 2, n, 2, n, 3).transpose(0, 2, 4, 1, 3, 5).reshape(-1, 3)
        return each, np.repeat(self.normal, 4 * n * n, axis=0)

    def solved(self, direct: Callable[[Floats, Floats], Floats]) -> Floats:
        """(all panels, bands) what they reflect of ``direct``, irradiance at points with normals, and of each other."""
        n, edges = self.count, self.edges
        x, w = np.polynomial.legendre.leggauss(3)
        at = (edges[:-1, None] + 0.5 * np.diff(edges)[:, None] * (x + 1)).ravel()
        s, t = (g.ravel()[:, None] for g in np.meshgrid(at, at, indexing="ij"))

        def mean(values: Floats) -> Floats:
            return np.einsum("p,q,ipjqb->ijb", w / 2, w / 2, values.reshape(n, 3, n, 3, -1)).reshape(n * n, -1)

        light, rows = [], []
        for (a, b, _, d), normal in zip(self.corners, self.normal, strict=True):
            points, up = a + s * (b - a) + t * (d - a), np.tile(normal, (len(s), 1))
            light.append(mean(direct(points, up)))
            rows.append(mean(self.factors(points, up)))
        H, F = np.concatenate(light), np.concatenate(rows)
        rho = np.repeat(self.reflectance, n * n, axis=0)
        each = [np.linalg.solve(np.eye(len(F)) - r[:, None] * F, r * h) for r, h in zip(rho.T, H.T, strict=True)]
        return np.stack(each, axis=1)

    def factors(self, points: Floats, normal: Floats) -> Floats:
        """(k, all panels) form factors from points, upright normals."""
        found = np.zeros((len(points), len(self.corners), self.count**2))
        ways, of = np.unique(np.round(normal), axis=0, return_inverse=True)
        for way, up in enumerate(ways):
            at = np.flatnonzero(of.ravel() == way)
            for k in range(len(self.corners)):
                found[at, k] = self._to_panels(points[at], up, k)
        return found.reshape(len(points), -1)

    def _to_panels(self, points: Floats, normal: Floats, k: int) -> Floats:
        """From points that face one way to the panels of one rectangle: Howell B-3 and B-8, by differences."""
        a, b, _, d = self.corners[k]
        distance = np.maximum((points - a) @ self.normal[k], 0)[:, None, None]
        if normal @ self.normal[k] > 0.5:
            return np.zeros((len(points), self.count**2))
        u, v = ((a + self.edges[:, None] * (end - a)) for end in (b, d))
        unit_u, unit_v = ((end - a) / np.linalg.norm(end - a) for end in (b, d))
        x, y = (w @ unit - (points @ unit)[:, None] for w, unit in ((u, unit_u), (v, unit_v)))
        if abs(normal @ self.normal[k]) > 0.5:
            up_to = _parallel(x[:, :, None], y[:, None, :], distance)
        elif abs(normal @ unit_u) > 0.5:
            up_to = _perpendicular(np.maximum(x * (normal @ unit_u), 0)[:, :, None], y[:, None, :], distance)
        else:
            up_to = _perpendicular(np.maximum(y * (normal @ unit_v), 0)[:, None, :], x[:, :, None], distance)
        return np.abs(np.diff(np.diff(up_to, axis=1), axis=2)).reshape(len(points), -1)


def _rectangles(surfaces: list[radiosity.Surface]) -> tuple[Floats, Floats]:
    """Corners, (n, 4, 3), and unit normals, (n, 3)."""
    corners = np.array([np.asarray(s.vertices)[np.asarray(s.faces)[0]] for s in surfaces])
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0])
    return corners, normal / np.linalg.norm(normal, axis=1, keepdims=True)


def _spectra(values: list[npt.ArrayLike], bands: int) -> Floats:
    """(n, bands)."""
    return np.array([np.broadcast_to(np.asarray(v, float), (bands,)) for v in values])


def _parallel(x: Floats, y: Floats, distance: Floats) -> Floats:
    """From a point to a parallel rectangle with a corner on its normal, odd in both edges; Howell B-3."""
    p, q = np.hypot(x, distance), np.hypot(y, distance)
    return (x / p * np.arctan(y / p) + y / q * np.arctan(x / q)) / (2 * np.pi)


def _perpendicular(height: Floats, y: Floats, distance: Floats) -> Floats:
    """From a point to an upright rectangle with a corner at the foot, odd in y; Howell B-8."""
    slant = np.hypot(height, distance)
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.arctan(y / distance) - distance / slant * np.arctan(y / slant)
    return np.where(slant > 0, found, 0) / (2 * np.pi)
