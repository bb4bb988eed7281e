"""What findings look like: a colour for each kind of fault, and what of it is drawn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from radiosity.teaching.figures import PALETTE

if TYPE_CHECKING:
    from radiosity.scene import Finding, Scene

Floats = npt.NDArray[np.float64]

_BLUE, _ORANGE, _GREEN, _PINK, _SKY, _RED, _YELLOW, _WINE, _TEAL = PALETTE[:9]

COLOURS = {
    "open-edges": _RED, "narrow-gap": _RED, "light-escapes": _RED,
    "mixed-winding": _BLUE, "turned-faces": _BLUE, "looking-outward": _BLUE, "back-in-sight": _SKY,
    "overlapping-faces": _ORANGE, "duplicate-faces": _ORANGE, "coincident-opposite": _ORANGE,
    "sliver-faces": _PINK, "zero-area-faces": _PINK, "non-planar-face": _PINK, "non-convex-face": _PINK,
    "open-rims": PALETTE[13], "non-manifold-edges": _GREEN,
    "buried-faces": _WINE, "blocked-lamp": _YELLOW, "high-reflectance": _YELLOW,
    "reflectance-range": _YELLOW, "emission-range": _YELLOW,
}  # fmt: skip
"""By code; what is not named here is teal."""

ALONG_EDGES = frozenset({"open-edges", "open-rims", "narrow-gap", "light-escapes", "non-manifold-edges"})
"""Codes of what is a matter of edges: the faces at them are not to blame."""

TURNED = frozenset({"mixed-winding", "turned-faces", "back-in-sight"})
"""Codes of faces that are drawn from behind as well."""

_MOST_ANCHORS = 24
_MOST_OUTLINED = 200


@dataclass(frozen=True, eq=False)
class Mark:
    """A finding as it is drawn.

    Attributes:
        number: in the legend.
        faces: indices of the faces of the scene that are tinted, counted through all surfaces.
        edges: (k, 2, 3) drawn as lines.
        outlines: (j, 2, 3) edges of tinted faces, drawn where nothing of them is seen.
        anchors: (m, 3) places that tell where it is; there are none where it is nowhere.
        size: metres that must be made out to see it.
    """

    number: int
    finding: Finding
    colour: str
    faces: npt.NDArray[np.intp]
    edges: Floats
    outlines: Floats
    anchors: Floats
    size: float


def marks(scene: Scene, findings: list[Finding], polygons: Floats, first_face: npt.NDArray[np.intp]) -> list[Mark]:
    """One for each finding, numbered from 1.

    Args:
        scene: where they were found.
        findings: in the order of the legend.
        polygons: (n, 4, 3) corners of all faces; not finite where a face is damaged.
        first_face: (surfaces + 1,) where the faces of each surface begin.
    """
    return [_mark(number, finding, polygons, first_face) for number, finding in enumerate(findings, 1)]


def _mark(number: int, finding: Finding, polygons: Floats, first_face: npt.NDArray[np.intp]) -> Mark:
    faces = _faces(finding, first_face)
    whole = np.isfinite(polygons[faces]).all(axis=(1, 2))
    faces = faces[whole]
    tinted = faces[:0] if finding.code in ALONG_EDGES else faces
    edges = finding.edges[np.isfinite(finding.edges).all(axis=(1, 2))]
    points = finding.points[np.isfinite(finding.points).all(axis=1)]
    if finding.code == "implausible-size":
        points = points[:0]
    if finding.code == "sliver-faces":
        edges = np.array([_longest(polygon) for polygon in polygons[tinted]]).reshape(-1, 2, 3)
    anchors = _anchors(finding, edges, polygons[tinted], points)
    shown = polygons[tinted[:_MOST_OUTLINED]]
    outlines = np.stack([shown, np.roll(shown, -1, axis=1)], axis=2).reshape(-1, 2, 3)
    return Mark(number, finding, COLOURS.get(finding.code, _TEAL), tinted, edges, outlines, anchors,
                _size(finding, edges, polygons[tinted], points))  # fmt: skip


def _longest(polygon: Floats) -> Floats:
    """(2, 3) the longest of the edges and diagonals of a face."""
    a, b, c, d = polygon
    return max(
        (np.array(pair) for pair in ((a, b), (b, c), (c, d), (a, c), (b, d))), key=lambda e: np.linalg.norm(e[1] - e[0])
    )


def _faces(finding: Finding, first_face: npt.NDArray[np.intp]) -> npt.NDArray[np.intp]:
    if finding.surface is None or finding.surface >= len(first_face) - 1:
        return np.zeros(0, np.intp)
    start, end = first_face[finding.surface : finding.surface + 2]
    if len(finding.faces) == 0:
        return np.arange(start, end)
    faces = start + finding.faces.astype(np.intp)
    return np.unique(faces[faces < end])


def _anchors(finding: Finding, edges: Floats, polygons: Floats, points: Floats) -> Floats:
    """Places that are looked for, those that tell most first."""
    if finding.code == "narrow-gap" and len(points):
        return points[:1]
    if finding.code in ALONG_EDGES or not len(polygons):
        along = [edges[:, 0] + t * (edges[:, 1] - edges[:, 0]) for t in (0.5, 0.2, 0.8)]
        found = np.concatenate([*along, points])
    else:
        middle = polygons.mean(axis=1)
        # A face may be hidden in its middle only.
        corners = [middle + 0.7 * (polygons[:, k] - middle) for k in range(4)]
        found = np.concatenate([middle, *corners])
    return np.asarray(found[:: max(1, len(found) // _MOST_ANCHORS)])


def _size(finding: Finding, edges: Floats, polygons: Floats, points: Floats) -> float:
    if finding.code == "narrow-gap" and len(points) > 1:
        return float(np.linalg.norm(points[1] - points[0]))
    if finding.code in {"sliver-faces", "zero-area-faces"} and len(polygons):
        a, b, c, d = polygons[0]
        longest = float(np.linalg.norm(np.diff(_longest(polygons[0]), axis=0)))
        return float(np.linalg.norm(np.cross(c - a, d - b))) / max(longest, 1e-300)
    corners = np.concatenate([edges.reshape(-1, 3), polygons.reshape(-1, 3)])
    return float(np.linalg.norm(np.ptp(corners, axis=0))) if len(corners) else 0.0
