"""Nusselt's analog: the form factor from a point as the covered share of a disk (Nusselt 1928).

A polygon is projected onto the unit hemisphere above the point and from there straight down onto its base. The share of
the base that is covered is the form factor: going to the hemisphere takes ``cos / r^2`` of the polygon's area, going
down another cosine, and the base has the area pi.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from radiosity import _native
from radiosity.checks import whole
from radiosity.teaching.figures import INK, PALETTE, STYLE, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = npt.NDArray[np.float64]

TARGET, SPHERE, BASE = PALETTE[0], PALETTE[1], PALETTE[5]
"""Colours of the polygon, of its projection onto the hemisphere and of that onto the base."""


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
    point: npt.ArrayLike, normal: npt.ArrayLike, polygon: npt.ArrayLike, *, azimuth: float = -60, elevation: float = 18
) -> Figure:
    """The point, its hemisphere, the polygon and both projections; and the base from above with what is covered.

    Args:
        point, normal, polygon: as of :func:`nusselt_outline`.
        azimuth, elevation: where the view is from, degrees about the normal and above the base.

    Raises:
        ValueError: as of :func:`nusselt_outline`, or nothing is above the horizon.
        ImportError: matplotlib is not installed.
    """
    from matplotlib import rc_context  # noqa: PLC0415

    outline = nusselt_outline(point, normal, polygon, 64)
    if not len(outline):
        raise ValueError("the polygon is wholly below the horizon of the point: there is nothing to project")
    corners = (np.asarray(polygon, dtype=np.float64) - np.asarray(point, dtype=np.float64)) @ frame(normal).T
    factor = nusselt_form_factor(point, normal, polygon)
    with rc_context(STYLE):
        figure = new_figure(11, 5.6)
        _draw_space(figure.add_axes((0.0, 0.0, 0.58, 0.9), projection="3d"), corners, outline, azimuth, elevation)
        _draw_base(figure.add_axes((0.6, 0.1, 0.37, 0.72)), outline, factor)
        figure.suptitle(f"Nusselt's analog: the form factor is the covered share of the base, F = {factor:.4f}", y=0.96)
    return figure


def _draw_space(axes: Any, corners: Floats, outline: Floats, azimuth: float, elevation: float) -> None:
    """Everything in the frame of the normal; the hemisphere shrinks until it is below the polygon."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # noqa: PLC0415

    size = _fitting_radius(corners)
    corners = corners / size
    axes.computed_zorder = False  # what lies before what is known here, and matplotlib guesses by means

    def polygon(points: Floats, colour: str, alpha: float, order: int, edge: str | None = None) -> None:
        face = Poly3DCollection([points], facecolor=colour, alpha=alpha, zorder=order)
        axes.add_collection3d(face)
        closed = np.vstack([points, points[:1]])
        axes.plot(*closed.T, color=edge or colour, linewidth=1.4, zorder=order + 0.5)

    angle = np.linspace(0, 2 * np.pi, 181)
    rim = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)
    polygon(rim, "#F2F2F2", 1.0, 1, INK)
    down = outline * [1, 1, 0]
    polygon(down, BASE, 0.75, 2)
    _draw_globe(axes, azimuth, elevation)
    seen = _corners_seen(outline)
    for ray, foot in zip(seen, seen * [1, 1, 0], strict=True):
        axes.plot(*np.stack([ray, foot]).T, color=BASE, linewidth=0.9, linestyle=":", zorder=4)
    polygon(outline, SPHERE, 0.6, 5)
    above = _above_horizon(corners)
    for corner in above:
        axes.plot(*np.stack([np.zeros(3), corner]).T, color=TARGET, linewidth=0.8, linestyle="--", zorder=6)
    polygon(above, TARGET, 0.45, 7)
    axes.plot([0], [0], [0], "o", color=INK, markersize=5, zorder=8)
    high = max(1.0, float(above[:, 2].max()))
    axes.plot([0, 0], [0, 0], [0, 0.45], color=INK, linewidth=1.6, zorder=8)
    axes.plot([0], [0], [0.47], "^", color=INK, markersize=6, zorder=8)
    axes.text(0.04, 0, 0.42, "n", fontsize=12, fontstyle="italic", zorder=9)
    _look(axes, np.vstack([rim, above, [[0, 0, high]]]), azimuth, elevation)


def _draw_globe(axes: Any, azimuth: float, elevation: float) -> None:
    """Circles of the hemisphere, those behind fainter."""
    eye = np.deg2rad([azimuth, elevation])
    toward = np.array([np.cos(eye[0]) * np.cos(eye[1]), np.sin(eye[0]) * np.cos(eye[1]), np.sin(eye[1])])
    up, around = np.linspace(0, np.pi / 2, 46), np.linspace(0, 2 * np.pi, 181)
    arcs = [np.stack([np.cos(a) * np.cos(up), np.sin(a) * np.cos(up), np.sin(up)], 1) for a in around[:-1:15]]
    arcs += [
        np.stack([np.cos(h) * np.cos(around), np.cos(h) * np.sin(around), np.full_like(around, np.sin(h))], 1)
        for h in np.deg2rad([30, 60])
    ]
    for arc in arcs:
        before = (arc @ toward > 0)[:, None]
        for side, alpha in ((before, 0.45), (~before, 0.16)):
            axes.plot(*np.where(side, arc, np.nan).T, color=INK, linewidth=0.6, alpha=alpha, zorder=3)


def _look(axes: Any, points: Floats, azimuth: float, elevation: float) -> None:
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = (low + high) / 2, (high - low).max() / 2
    axes.set_box_aspect((1, 1, 1), zoom=1.45)
    for k, limit in enumerate((axes.set_xlim, axes.set_ylim, axes.set_zlim)):
        limit(middle[k] - half, middle[k] + half)
    axes.view_init(elev=elevation, azim=azimuth)
    axes.set_axis_off()


def _draw_base(axes: Any, outline: Floats, factor: float) -> None:
    """The base from above."""
    angle = np.linspace(0, 2 * np.pi, 361)
    axes.fill(np.cos(angle), np.sin(angle), facecolor="#F2F2F2", edgecolor=INK, linewidth=1.2)
    axes.fill(outline[:, 0], outline[:, 1], facecolor=BASE, alpha=0.75, edgecolor=BASE, linewidth=1.4)
    axes.plot([0], [0], "o", color=INK, markersize=5)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_title("the base from above", fontsize=12)
    axes.text(0.5, -0.06, f"covered area {np.pi * factor:.4f} of $\\pi$", transform=axes.transAxes, ha="center")


def _corners_seen(outline: Floats) -> Floats:
    """The corners of an outline of 64 points an edge."""
    return outline[::64]


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
    above = _above_horizon(corners)
    share = np.linspace(0, 1, 33)
    a, b = above[:, None], np.roll(above, -1, axis=0)[:, None]
    edges = (a + share[:, None] * (b - a)).reshape(-1, 3)
    middle = above.mean(axis=0)
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
