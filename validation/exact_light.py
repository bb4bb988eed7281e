"""Direct light in closed form: what convex solids leave visible of a lamp, of a point light and of the sun.

What hides is convex, so the part of a lamp that it hides from a point is the lamp cut by planes through the point.
Faces of a convex solid that are turned to a point do not overlap as seen from there; their parts add up.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

import radiosity
from radiosity import catalogue

Floats = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]
OnSurface = Callable[[Floats, Indices], Floats]
"""(k, bands) at (k, 3) points on so many surfaces, (k,) their indices."""


def cut(polygons: Floats, normal: Floats, offset: Floats) -> Floats:
    """The parts of convex polygons, (k, m, 3), where normal . x >= offset, (k, 3) and (k,): (k, m + 1, 3) corners.

    Corners may be repeated; what is empty has all corners in one place. (Sutherland and Hodgman 1974.)
    """
    height = np.einsum("kmi,ki->km", polygons, normal) - offset[:, None]
    following, next_height = np.roll(polygons, -1, axis=1), np.roll(height, -1, axis=1)
    crosses = (height >= 0) != (next_height >= 0)
    share = np.where(crosses, height, 0) / np.where(crosses, height - next_height, 1)
    crossing = polygons + share[..., None] * (following - polygons)
    k, m = height.shape
    corners = np.stack([polygons, crossing], axis=2).reshape(k, 2 * m, 3)
    kept = np.stack([height >= 0, crosses], axis=2).reshape(k, 2 * m)
    order = np.argsort(~kept, axis=1, kind="stable")[:, : m + 1]
    corners, kept = np.take_along_axis(corners, order[..., None], axis=1), np.take_along_axis(kept, order, axis=1)
    return np.where(kept[..., None], corners, corners[:, :1])


def part_behind(polygons: Floats, hiding: Floats, *, eye: Floats | None = None, along: Floats | None = None) -> Floats:
    """What of convex polygons, (k, m, 3), lies in the cone from eyes, (k, 3), through a convex polygon, (j, 3).

    With ``along`` instead, (3,), what lies in the prism of parallel rays through it.
    """
    middle, edges = hiding.mean(axis=0), np.roll(hiding, -1, axis=0) - hiding
    for corner, edge in zip(hiding, edges, strict=True):
        ray = np.broadcast_to(along, (len(polygons), 3)) if eye is None else corner - eye
        normal = np.cross(ray, edge)
        normal = normal * np.sign(normal @ (middle - corner))[:, None]
        polygons = cut(polygons, normal, normal @ corner)
    return polygons


def from_lamp(points: Floats, normal: Floats, lamp: Floats, solids: list[list[Floats]]) -> Floats:
    """(k,) irradiance from what is visible of a lamp of unit exitance, (4, 3) and dark from behind.

    Every solid, a list of faces, lies wholly in front of the lamp, and no two hide the same part from any point. One
    face alone hides from both its sides.
    """
    facing = np.cross(lamp[1] - lamp[0], lamp[2] - lamp[0])
    lit = np.flatnonzero((points - lamp[0]) @ facing > 1e-12)
    out, where, up = np.zeros(len(points)), points[lit], normal[lit]
    seen = catalogue.point_to_polygon(polygon=lamp, position=where, normal=up)
    for face, is_alone in ((face, len(solid) == 1) for solid in solids for face in solid):
        height = (where - face[0]) @ np.cross(face[1] - face[0], face[2] - face[0])
        hides = (np.abs(height) if is_alone else height) > 1e-9
        if hides.any():
            eyes = where[hides]
            part = part_behind(np.broadcast_to(lamp, (len(eyes), *lamp.shape)), face, eye=eyes)
            seen[hides] -= catalogue.point_to_polygon(polygon=part, position=eyes, normal=up[hides])
    out[lit] = np.maximum(seen, 0)
    return out


def solid_angle(polygons: Floats, eye: Floats) -> Floats:
    """(k,) of convex polygons, (k, m, 3), from a point (Van Oosterom and Strackee 1983, triangle by triangle)."""
    rays = polygons - eye
    rays = rays / np.linalg.norm(rays, axis=-1, keepdims=True)
    a, total = rays[:, 0], np.zeros(len(polygons))
    for k in range(1, polygons.shape[1] - 1):
        b, c = rays[:, k], rays[:, k + 1]
        volume = np.einsum("ki,ki->k", a, np.cross(b, c))
        below = 1 + np.einsum("ki,ki->k", a, b) + np.einsum("ki,ki->k", b, c) + np.einsum("ki,ki->k", c, a)
        total += 2 * np.arctan2(volume, below)
    return np.abs(total)


def area_of(polygons: Floats) -> Floats:
    """(k,) of flat polygons, (k, m, 3)."""
    following = np.roll(polygons, -1, axis=1)
    return 0.5 * np.linalg.norm(np.cross(polygons - polygons[:, :1], following - polygons[:, :1]).sum(axis=1), axis=1)


GAUSS = np.polynomial.legendre.leggauss(3)


def mean_over(patches: radiosity.Patches, irradiance_at: OnSurface, tolerance: float = 2e-5, depth: int = 7) -> Floats:
    """(n, bands) means over patches, by Gauss points in cells that are cut in four where that makes a difference.

    Args:
        patches: what to average over.
        irradiance_at: the irradiance at points on surfaces.
        tolerance: what a cell may add to the mean of its patch by not being cut, relative to the mean of all.
        depth: how often a cell is cut at most.
    """
    patch = np.arange(len(patches))
    corner, size, of = np.zeros((len(patch), 2)), 1.0, patch
    before, share = _cell_means(patches, irradiance_at, of, corner, size)
    means = np.zeros((len(patch), before.shape[1]))
    level = np.average(before, axis=0, weights=patches.area).mean()
    for level_of_cut in range(depth):
        size /= 2
        of = np.repeat(of, 4)
        corner = (corner[:, None] + size * np.array([[0, 0], [0, 1], [1, 0], [1, 1]])).reshape(-1, 2)
        parts, part_share = _cell_means(patches, irradiance_at, of, corner, size)
        four = part_share.reshape(-1, 4)
        after = np.einsum("kp,kpb->kb", four, parts.reshape(len(four), 4, -1)) / four.sum(axis=1, keepdims=True)
        is_settled = np.abs(after - before).max(axis=1) * share < tolerance * level
        # What is narrow may lie between the first points.
        is_done = (is_settled & (level_of_cut > 0)) | (level_of_cut == depth - 1)
        np.add.at(means, of[::4][is_done], share[is_done, None] * after[is_done])
        rest = np.repeat(~is_done, 4)
        if not rest.any():
            break
        of, corner, before, share = of[rest], corner[rest], parts[rest], part_share[rest]
    return means


def mean_by_gauss(patches: radiosity.Patches, irradiance_at: OnSurface) -> Floats:
    """(n, bands) means over patches by nine points each, of what is smooth."""
    patch = np.arange(len(patches))
    return _cell_means(patches, irradiance_at, patch, np.zeros((len(patch), 2)), 1.0)[0]


def _cell_means(
    patches: radiosity.Patches, irradiance_at: OnSurface, of: Indices, corner: Floats, size: float
) -> tuple[Floats, Floats]:
    """Mean over each cell, (k, bands), and which share of its patch it is, (k,)."""
    x, w = 0.5 * (GAUSS[0] + 1), 0.5 * GAUSS[1]
    s, t = (corner[:, i, None] + size * g.ravel() for i, g in enumerate(np.meshgrid(x, x)))
    a, b, c, d = (p[:, None] for p in np.moveaxis(patches.polygons[of], 1, 0))
    s, t = s[..., None], t[..., None]
    points = (1 - s) * ((1 - t) * a + t * d) + s * ((1 - t) * b + t * c)
    along_s, along_t = (1 - t) * (b - a) + t * (c - d), (1 - s) * (d - a) + s * (c - b)
    weight = np.outer(w, w).ravel() * np.linalg.norm(np.cross(along_s, along_t), axis=-1) * size**2
    values = irradiance_at(points.reshape(-1, 3), np.repeat(patches.surface[of].astype(np.int64), points.shape[1]))
    values = values.reshape(len(of), points.shape[1], -1)
    area = weight.sum(axis=1)
    return np.einsum("kp,kpb->kb", weight, values) / area[:, None], area / patches.area[of]
