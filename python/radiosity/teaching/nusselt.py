"""Nusselt's analog: the form factor from a point as the covered share of a disk (Nusselt 1928).

A polygon is projected onto the unit hemisphere above the point and from there straight down onto its base. The share of
the base that is covered is the form factor: going to the hemisphere takes ``cos / r^2`` of the polygon's area, going
down another cosine, and the base has the area pi.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from radiosity import _native
from radiosity.checks import whole
from radiosity.teaching.figures import INK, PALETTE, new_figure, style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = npt.NDArray[np.float64]

TARGET, SPHERE, BASE = PALETTE[0], PALETTE[1], PALETTE[5]
"""Colours of the polygon, of its projection onto the hemisphere and of that onto the base."""

EDGE_POINTS = 64
"""Points of an edge of a projection that is drawn."""


def frame(normal: npt.ArrayLike) -> Floats:
    """(3, 3) rows: two tangents and the unit normal, a right-handed frame."""
    return _native.frame(_unit(normal))


def nusselt_outline(point: npt.ArrayLike, normal: npt.ArrayLike, polygon: npt.ArrayLike, steps: int = 32) -> Floats:
    """The outline of a polygon as projected onto the unit hemisphere above a point.

    Args:
        point: (3,) metres.
        normal: (3,) of the surface at the point, of any length.
        polygon: (n, 3) corners of a convex polygon. What is below the horizon is cut off.
        steps: points an edge, evenly along the great circle that it becomes.

    Returns:
        (k, 3) points of the hemisphere in the :func:`frame` of the normal; without the last coordinate they are the
        projection onto the base. Empty if nothing is above the horizon.

    Raises:
        ValueError: a normal without length, numbers that are not finite, fewer than three corners.
    """
    return _native.nusselt_outline(*_arguments(point, normal, polygon), whole(steps, "steps", 1, 1 << 16))


def nusselt_form_factor(point: npt.ArrayLike, normal: npt.ArrayLike, polygon: npt.ArrayLike) -> float:
    """The share of the base that a polygon covers: the form factor from the point to it, arguments as above."""
    return _native.nusselt_share(*_arguments(point, normal, polygon))


def draw_nusselt(
    point: npt.ArrayLike,
    normal: npt.ArrayLike,
    polygon: npt.ArrayLike,
    *,
    azimuth: float | None = None,
    elevation: float = 22,
) -> Figure:
    """The point, its hemisphere, the polygon and both projections; and the base from above with what is covered.

    Args:
        point, normal, polygon: as of :func:`nusselt_outline`.
        azimuth, elevation: where the view is from, degrees about the normal and above the base. By default one that
            shows much of the projection on the hemisphere, and does not fold it.

    Raises:
        ValueError: as of :func:`nusselt_outline`, or nothing is above the horizon.
        ImportError: matplotlib is not installed.
    """
    outline = nusselt_outline(point, normal, polygon, EDGE_POINTS)
    if not len(outline):
        raise ValueError("the polygon is wholly below the horizon of the point: there is nothing to project")
    corners = (np.asarray(polygon, dtype=np.float64) - np.asarray(point, dtype=np.float64)) @ frame(normal).T
    if azimuth is None:
        azimuth = _good_azimuth(outline, elevation)
    factor = nusselt_form_factor(point, normal, polygon)
    with style():
        figure = new_figure(11.5, 6)
        _draw_space(figure.add_axes((0.01, 0.11, 0.6, 0.78)), _above_horizon(corners), outline, azimuth, elevation)
        _draw_base(figure.add_axes((0.63, 0.12, 0.35, 0.68)), outline, factor)
        figure.suptitle(
            f"Nusselt's analog: the form factor is the covered share of the base, F = {factor:.4f}", y=0.95, fontsize=14
        )
    return figure


def _draw_space(axes: Any, corners: Floats, outline: Floats, azimuth: float, elevation: float) -> None:
    """Everything in the frame of the normal, in radii of the hemisphere, by parallel projection."""
    corners = corners / _fitting_radius(corners)
    right, up, toward = _view(azimuth, elevation)

    def line(points: Floats, colour: str = INK, style: str = "-", width: float = 1.0, alpha: float = 1.0) -> None:
        axes.plot(points @ right, points @ up, style, color=colour, linewidth=width, alpha=alpha)

    def fill(points: Floats, colour: str, alpha: float, edge: str, label: str | None = None) -> None:
        axes.fill(points @ right, points @ up, facecolor=colour, alpha=alpha, label=label, linewidth=0)
        line(np.vstack([points, points[:1]]), edge, width=1.5)

    around = np.linspace(0, 2 * np.pi, 361)
    fill(np.stack([np.cos(around), np.sin(around), 0 * around], axis=1), "#F2F2F2", 1.0, INK)
    fill(outline * [1, 1, 0], BASE, 0.8, BASE, "straight down on the base")
    for arc, is_behind in _globe(toward):
        line(arc, width=0.7, alpha=0.2 if is_behind else 0.45)
    line(_silhouette(right, up, toward), width=1.0, alpha=0.8)
    for on_sphere in outline[::EDGE_POINTS]:
        line(np.stack([on_sphere, on_sphere * [1, 1, 0]]), BASE, ":", 1.2)
    fill(outline, SPHERE, 0.65, SPHERE, "seen from the point, on the hemisphere")
    for corner in corners:
        line(np.stack([0 * corner, corner]), TARGET, "--", 0.9)
    fill(corners, TARGET, 0.4, TARGET, "the polygon")
    axes.plot([0], [0], "o", color=INK, markersize=5)
    axes.annotate("", (0, 0.42 * up[2]), (0, 0), arrowprops={"arrowstyle": "-|>", "color": INK, "linewidth": 1.5})
    axes.text(-0.05, 0.4 * up[2], "n", fontsize=13, fontstyle="italic", ha="right", va="center",
              bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.6})  # fmt: skip
    axes.set_aspect("equal", anchor="S")
    axes.margins(0.02)
    axes.set_axis_off()
    handles, labels = axes.get_legend_handles_labels()
    axes.figure.legend(
        handles[::-1], labels[::-1], loc="lower left", bbox_to_anchor=(0.02, 0.01), ncols=3, frameon=False
    )


def _view(azimuth: float, elevation: float) -> Floats:
    """(3, 3) rows: to the right, up and out of the picture, seen from an azimuth and elevation in degrees."""
    a, e = np.deg2rad([azimuth, elevation])
    return np.array(
        [
            [-np.sin(a), np.cos(a), 0],
            [-np.cos(a) * np.sin(e), -np.sin(a) * np.sin(e), np.cos(e)],
            [np.cos(a) * np.cos(e), np.sin(a) * np.cos(e), np.sin(e)],
        ]
    )


def _good_azimuth(outline: Floats, elevation: float) -> float:
    """Degrees: the view, from behind what is seen to beside it, in which its projection has the greatest area."""
    x, y, _ = outline.mean(axis=0)

    def area(azimuth: float) -> float:
        right, up, _ = _view(azimuth, elevation)
        u, v = outline @ right, outline @ up
        return float(abs(np.sum(u * np.roll(v, -1) - np.roll(u, -1) * v)))

    middle = float(np.rad2deg(np.arctan2(y, x)))
    return max((middle - turn for turn in (140, 95, 70)), key=area)


def _globe(toward: Floats) -> Iterator[tuple[Floats, bool]]:
    """Meridians and parallels of the hemisphere, and whether they are behind it."""
    up, around = np.linspace(0, np.pi / 2, 91), np.linspace(0, 2 * np.pi, 361)
    arcs = [np.stack([np.cos(a) * np.cos(up), np.sin(a) * np.cos(up), np.sin(up)], 1) for a in around[:-1:30]]
    arcs += [
        np.stack([np.cos(h) * np.cos(around), np.cos(h) * np.sin(around), np.full_like(around, np.sin(h))], 1)
        for h in np.deg2rad([30, 60])
    ]
    for arc in arcs:
        is_before = (arc @ toward > 0)[:, None]
        yield np.where(is_before, arc, np.nan), False
        yield np.where(is_before, np.nan, arc), True


def _silhouette(right: Floats, up: Floats, toward: Floats) -> Floats:
    """The rim of the hemisphere as it is seen: half a great circle across the direction of view."""
    angle = np.linspace(0, np.pi, 181)[:, None]
    return np.cos(angle) * right + np.sin(angle) * up if toward[2] >= 0 else np.cos(angle) * right - np.sin(angle) * up


def _draw_base(axes: Any, outline: Floats, factor: float) -> None:
    """The base from above."""
    angle = np.linspace(0, 2 * np.pi, 361)
    axes.fill(np.cos(angle), np.sin(angle), facecolor="#F2F2F2", edgecolor=INK, linewidth=1.2)
    axes.fill(outline[:, 0], outline[:, 1], facecolor=BASE, alpha=0.75, edgecolor=BASE, linewidth=1.4)
    axes.plot([0], [0], "o", color=INK, markersize=5)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_title("The base from above", fontsize=12)
    axes.text(0.5, -0.06, f"covered area {np.pi * factor:.4f} of $\\pi$", transform=axes.transAxes, ha="center")


def _above_horizon(corners: Floats) -> Floats:
    """The part of a convex polygon with z > 0."""
    kept = []
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if a[2] >= 0:
            kept.append(a)
        if a[2] * b[2] < 0:
            kept.append(a + a[2] / (a[2] - b[2]) * (b - a))
    return np.array(kept)


def _fitting_radius(corners: Floats) -> float:
    """A radius, m, of a hemisphere that keeps below the polygon: three quarters of the way to its nearest point."""
    share = np.linspace(0, 1, 33)
    a, b = corners[:, None], np.roll(corners, -1, axis=0)[:, None]
    edges = (a + share[:, None] * (b - a)).reshape(-1, 3)
    middle = corners.mean(axis=0)
    points = middle + share[:, None, None] * (edges - middle)
    return 0.75 * float(np.linalg.norm(points, axis=-1).min())


def _arguments(
    point: npt.ArrayLike, normal: npt.ArrayLike, polygon: npt.ArrayLike
) -> tuple[list[float], list[float], Floats]:
    place = np.asarray(point, dtype=np.float64)
    corners = np.ascontiguousarray(polygon, dtype=np.float64)
    if corners.ndim != 2 or corners.shape[1] != 3 or len(corners) < 3:
        raise ValueError(f"polygon must have shape (n, 3) with n of three or more, not {corners.shape}")
    if place.shape != (3,) or not (np.isfinite(place).all() and np.isfinite(corners).all()):
        raise ValueError("point must be three finite numbers, and so must every corner")
    return place.tolist(), _unit(normal), corners


def _unit(normal: npt.ArrayLike) -> list[float]:
    vector = np.asarray(normal, dtype=np.float64)
    length = float(np.linalg.norm(vector))
    if vector.shape != (3,) or not 0 < length < np.inf:
        raise ValueError("normal must be three finite numbers that are not all zero")
    return list(map(float, vector / length))
