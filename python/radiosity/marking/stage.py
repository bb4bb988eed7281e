"""A scene to be looked at from outside: faces that turn their backs to the viewer, and outer walls, are left out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from radiosity import _native
from radiosity.marking.kinds import TURNED, Mark, marks
from radiosity.patches import Patches
from radiosity.scene import Camera, Scene
from radiosity.sight import look_around

if TYPE_CHECKING:
    from radiosity.scene import Finding

Floats = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]
Flags = npt.NDArray[np.bool_]

IN_FRONT = 3e-5
"""How far marked faces are drawn before others in one place, relative to their distance from the eye."""

_OUTSIDE, _INSIDE = 0.9, 0.5
"""Of an outer wall, more than the first escapes from one side, and less than the second from the other."""


@dataclass
class Stage:
    """Faces with what is marked on them.

    Attributes:
        scene: where they come from.
        polygons: (n, 4, 3) corners of faces that can be drawn, obstructions last.
        surface: (n,) their surface, -1 for an obstruction.
        normal: (n, 3) unit normals.
        shown_from: (n, 2) whether a face is shown to who is before it, and behind it.
        tint: (n,) index of the mark that colours it, -1 for none.
        marks: one for each finding.
        up: unit vector.
    """

    scene: Scene
    polygons: Floats
    surface: Indices
    normal: Floats
    shown_from: Flags
    tint: Indices
    marks: list[Mark]
    up: Floats

    @classmethod
    def of(cls, scene: Scene, findings: list[Finding]) -> Stage:
        """Whatever of a scene can be drawn, even where it is unsound.

        Raises:
            ValueError: there is nothing.
        """
        polygons = [_polygons(surface) for surface in scene.surfaces]
        first_face = np.cumsum([0, *(len(p) for p in polygons)])
        everything = np.concatenate([np.zeros((0, 4, 3)), *polygons])
        found = marks(scene, findings, everything, first_face)
        surface = np.repeat(np.arange(len(polygons)), np.diff(first_face))
        tint = np.full(len(everything), -1)
        for index, mark in reversed(list(enumerate(found))):
            tint[mark.faces] = index
        blocks = np.concatenate([np.zeros((0, 4, 3)), *(_polygons(o) for o in scene.obstructions)])
        everything = np.concatenate([everything, blocks])
        surface, tint = (np.concatenate([v, np.full(len(blocks), -1)]) for v in (surface, tint))
        keep = np.isfinite(everything).all(axis=(1, 2))
        if not keep.any():
            raise ValueError(f"{scene.name}: there is no face to draw; add surfaces with triangles or quads")
        everything, surface, tint = everything[keep], surface[keep], tint[keep]
        cross = np.cross(everything[:, 2] - everything[:, 0], everything[:, 3] - everything[:, 1])
        normal = cross / np.maximum(np.linalg.norm(cross, axis=1), 1e-300)[:, None]
        sided = np.array([s.two_sided for s in scene.surfaces] + [True])[surface]
        shown = _shown_from(everything, sided)
        turned = np.array([mark.finding.code in TURNED for mark in found] + [False])[tint]
        shown[turned] = True
        return cls(scene, everything, surface, normal, shown, tint, found, _up(scene, normal, surface))

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Two extreme corners."""
        corners = self.polygons.reshape(-1, 3)
        return corners.min(axis=0), corners.max(axis=0)

    def faces_for(self, eye: Floats) -> Indices:
        """The faces that are shown to an eye."""
        before = np.einsum("nk,nk->n", eye - self.polygons.mean(axis=1), self.normal) > 0
        return np.flatnonzero(np.where(before, self.shown_from[:, 0], self.shown_from[:, 1]))


@dataclass
class View:
    """A stage as a camera sees it: perspective, with the faces that are shown to its eye."""

    stage: Stage
    camera: Camera

    def __post_init__(self) -> None:
        self.eye = np.asarray(self.camera.position, dtype=np.float64)
        forward = np.asarray(self.camera.forward, dtype=np.float64)
        right = np.cross(forward, self.camera.up)
        right /= np.linalg.norm(right)
        self.axes = np.stack([right, np.cross(right, forward), forward])
        self.faces = self.stage.faces_for(self.eye)
        polygons = self.stage.polygons[self.faces]
        # Of two faces in one place, the marked one is to be seen.
        marked = self.stage.tint[self.faces] >= 0
        polygons[marked] += IN_FRONT * (self.eye - polygons[marked])
        self._enclosure = _native.Enclosure(_native_patches(polygons))

    def project(self, points: Floats, width: int, height: int) -> Floats:
        """(n, 3) pixel right, pixel down, depth; what is not before the camera has depth 0 or less."""
        x, y, depth = ((points - self.eye) @ self.axes.T).T
        scale = 0.5 * height / np.tan(0.5 * self.camera.vertical_fov)
        ahead = np.where(depth > 0, depth, np.nan)
        return np.stack([0.5 * width + scale * x / ahead, 0.5 * height - scale * y / ahead, depth], axis=1)

    def sees(self, points: Floats) -> Flags:
        """(n,) whether nothing that is shown stands before a point, wherever it is in the picture."""
        _, distance, _ = self._enclosure.looks(np.broadcast_to(self.eye, points.shape).copy(), points - self.eye)
        return np.asarray(distance > 1 - 2e-3)

    def first_hits(self, width: int, height: int) -> tuple[Indices, Floats]:
        """(height, width) face of the stage that each pixel shows, -1 for none, and its distance."""
        tangent = np.tan(0.5 * self.camera.vertical_fov)
        x = (np.arange(width) + 0.5 - 0.5 * width) * 2 * tangent / height
        y = (0.5 * height - np.arange(height) - 0.5) * 2 * tangent / height
        right, up, forward = self.axes
        directions = (x[None, :, None] * right + y[:, None, None] * up + forward).reshape(-1, 3)
        polygon, distance, _ = self._enclosure.looks(np.broadcast_to(self.eye, directions.shape).copy(), directions)
        face = np.where(polygon >= 0, self.faces[polygon], -1) if len(self.faces) else polygon
        return face.reshape(height, width), distance.reshape(height, width)


def _polygons(surface: object) -> Floats:
    """(n, 4, 3) corners of the faces of a surface; not finite where they refer to no vertex."""
    vertices = np.asarray(surface.vertices, np.float64).reshape(-1, 3)  # type: ignore[attr-defined]
    faces = np.asarray(surface.faces, np.int64)  # type: ignore[attr-defined]
    if not len(faces):
        return np.zeros((0, 4, 3))
    faces = faces if faces.shape[1] == 4 else np.concatenate([faces, faces[:, 2:]], axis=1)
    nowhere = np.concatenate([vertices, np.full((1, 3), np.nan)])
    return np.asarray(nowhere[np.where((faces >= 0) & (faces < len(vertices)), faces, len(vertices))])


def _native_patches(polygons: Floats, two_sided: Flags | None = None) -> _native.Patches:
    n = len(polygons)
    sides = np.zeros(n, bool) if two_sided is None else two_sided
    return _native.Patches(
        np.ascontiguousarray(polygons),
        np.zeros(n, np.uint32),
        np.arange(n, dtype=np.uint32),
        np.ascontiguousarray(sides),
    )


def _shown_from(polygons: Floats, two_sided: Flags) -> Flags:
    """(n, 2) whether faces are shown to who is before and behind them: not the outside of an outer two-sided wall."""
    shown = np.stack([np.ones(len(polygons), bool), two_sided], axis=1)
    if two_sided.any():
        # Both sides count as lit here, so that only what escapes tells the outside.
        patches = Patches(Scene([]), _native_patches(polygons, np.ones(len(polygons), bool)))
        escaped = look_around(patches).escaped
        for side in (0, 1):
            outer = two_sided & (escaped[:, side] > _OUTSIDE) & (escaped[:, 1 - side] < _INSIDE)
            shown[outer, side] = False
    return shown


def _axis(k: int) -> Floats:
    return np.array([float(k == axis) for axis in range(3)])


def _up(scene: Scene, normal: Floats, surface: Indices) -> Floats:
    """What is up: as cameras say, or across the floor, or along y as in most files."""
    for camera in scene.cameras:
        up = np.asarray(camera.up, dtype=np.float64)
        if np.isfinite(up).all() and np.abs(up).max() > 0:
            return _axis(int(np.argmax(np.abs(up)))) * float(np.sign(up[np.argmax(np.abs(up))]))
    for index, found in enumerate(scene.surfaces):
        if any(word in found.name.lower() for word in ("floor", "ground", "boden")) and (surface == index).any():
            return _axis(int(np.argmax(np.abs(normal[surface == index]).sum(axis=0))))
    return np.array([0.0, 1.0, 0.0])
