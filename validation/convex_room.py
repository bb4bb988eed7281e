"""Interreflection between the rectangles of an upright box, or some of them, by small panels of constant radiosity.

What they send straight away is exact, and so is the form factor from a point to a panel; panels get smaller toward the
edges, where irradiance changes fast. The last gather makes the error one of second order in their size.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

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
        panels: along each edge of a rectangle.
    """

    def __init__(
        self, scene: radiosity.Scene, from_lights: Callable[[Floats, Floats], Floats] | None = None, panels: int = 14
    ) -> None:
        self.scene, self.from_lights, self.panels = scene, from_lights, panels
        self.bands = len(scene.bands)
        self.corners = np.array([np.asarray(s.vertices)[np.asarray(s.faces)[0]] for s in scene.surfaces])
        self.reflectance, self.emission = (
            np.array([np.broadcast_to(v, (self.bands,)) for v in values])
            for values in ([s.reflectance for s in scene.surfaces], [s.emission for s in scene.surfaces])
        )
        normal = np.cross(self.corners[:, 1] - self.corners[:, 0], self.corners[:, 3] - self.corners[:, 0])
        self.area = np.linalg.norm(normal, axis=1)
        self.normal = normal / self.area[:, None]

    def direct_at(self, points: Floats, surface: Indices) -> Floats:
        """(k, bands) what lamps send straight away; exact."""
        normal = self.normal[surface]
        found = np.zeros((len(points), self.bands))
        for k in np.flatnonzero(self.emission.any(axis=1)):
            away = surface != k
            seen = from_lamp(points[away], normal[away], self.corners[k], [])
            found[away] += seen[:, None] * self.emission[k]
        return found if self.from_lights is None else found + self.from_lights(points, normal)

    def irradiance_at(self, points: Floats, surface: Indices) -> Floats:
        """(k, bands) all light."""
        return self.direct_at(points, surface) + self.indirect_at(points, surface)

    def means(self, patches: radiosity.Patches) -> Floats:
        """(n, bands) of all light over patches."""
        return mean_over(patches, self.direct_at) + mean_by_gauss(patches, self.indirect_at)

    def indirect_at(self, points: Floats, surface: Indices) -> Floats:
        """(k, bands) what panels reflect."""
        found = np.zeros((len(points), self.bands))
        for first in range(0, len(points), 2000):
            part = slice(first, first + 2000)
            found[part] = self._factors(points[part], surface[part]) @ self._radiosity
        return found

    @cached_property
    def _reflecting(self) -> list[int]:
        return [int(k) for k in np.flatnonzero(self.reflectance.any(axis=1))]

    @cached_property
    def _edges(self) -> Floats:
        """Where panels meet, from 0 to 1, closer at both ends."""
        even = np.linspace(0, 1, self.panels + 1)
        graded = 0.5 * (1 - np.cos(np.pi * even))
        return graded

    @cached_property
    def _radiosity(self) -> Floats:
        """(all panels, bands) what they reflect."""
        n, edges = self.panels, self._edges
        x, w = np.polynomial.legendre.leggauss(3)
        at = (edges[:-1, None] + 0.5 * np.diff(edges)[:, None] * (x + 1)).ravel()
        s, t = (g.ravel()[:, None] for g in np.meshgrid(at, at, indexing="ij"))
        direct, rows = [], []
        for k in self._reflecting:
            a, b, _, d = self.corners[k]
            points, surface = a + s * (b - a) + t * (d - a), np.full(len(s), k)

            def mean(values: Floats) -> Floats:
                return np.einsum("p,q,ipjqb->ijb", w / 2, w / 2, values.reshape(n, 3, n, 3, -1)).reshape(n * n, -1)

            direct.append(mean(self.direct_at(points, surface)))
            rows.append(mean(self._factors(points, surface)))
        H, F = np.concatenate(direct), np.concatenate(rows)
        rho = np.repeat(self.reflectance[self._reflecting], n * n, axis=0)
        solve = np.linalg.solve
        return np.stack(
            [solve(np.eye(len(F)) - rho[:, [b]] * F, rho[:, b] * H[:, b]) for b in range(self.bands)], axis=1
        )

    def _factors(self, points: Floats, surface: Indices) -> Floats:
        """(k, all panels) form factors from points on surfaces."""
        found = np.zeros((len(points), len(self._reflecting), self.panels**2))
        for j, k in enumerate(self._reflecting):
            for own in np.unique(surface):
                at = np.flatnonzero(surface == own)
                if own != k:
                    found[at, j] = self._to_panels(points[at], self.normal[own], k)
        return found.reshape(len(points), -1)

    def _to_panels(self, points: Floats, normal: Floats, k: int) -> Floats:
        """From points that face one way to the panels of one rectangle: Howell B-3 and B-8, by differences."""
        a, b, _, d = self.corners[k]
        distance = np.maximum((points - a) @ self.normal[k], 0)[:, None, None]
        if np.allclose(distance, 0):
            return np.zeros((len(points), self.panels**2))
        u, v = ((a + self._edges[:, None] * (end - a)) for end in (b, d))
        unit_u, unit_v = ((end - a) / np.linalg.norm(end - a) for end in (b, d))
        x, y = (w @ unit - (points @ unit)[:, None] for w, unit in ((u, unit_u), (v, unit_v)))
        if abs(normal @ self.normal[k]) > 0.5:
            up_to = _parallel(x[:, :, None], y[:, None, :], distance)
        elif abs(normal @ unit_u) > 0.5:
            up_to = _perpendicular(np.maximum(x * (normal @ unit_u), 0)[:, :, None], y[:, None, :], distance)
        else:
            up_to = _perpendicular(np.maximum(y * (normal @ unit_v), 0)[:, None, :], x[:, :, None], distance)
        return np.abs(np.diff(np.diff(up_to, axis=1), axis=2)).reshape(len(points), -1)


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
