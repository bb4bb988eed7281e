"""From where to look, so that as many marks as possible are seen in as few views as possible."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from radiosity.marking.kinds import Mark
from radiosity.marking.stage import Stage, View
from radiosity.scene import Camera

if TYPE_CHECKING:
    from collections.abc import Iterator

Floats = npt.NDArray[np.float64]

FOV = math.radians(32)
"""Vertical angle of view of views from outside."""

ASPECT = 4 / 3

MOST_OVERVIEWS, MOST_PANELS = 2, 4

LEAST_PIXELS = 9.0
"""What is smaller in a picture of 1000 pixels gets a view of its own."""

MANY_FACES = 50_000
"""Scenes with more faces are looked at from fewer sides."""

Panel = tuple[View, list[Mark], str]
"""A view, the marks that are seen in it, and what it is called."""


def choose(stage: Stage) -> list[Panel]:
    """One view or more: of the whole scene, and close to what would be too small in it."""
    placed = [mark for mark in stage.marks if len(mark.anchors)]
    best = _best(_candidates(stage), placed)
    own = next(_own_cameras(stage), None)
    if own is not None and len(_seen(own, placed)) == len(placed):
        best = own
    panels = [(best, _seen(best, placed), "")]
    left = [mark for mark in placed if mark not in panels[0][1]]
    while left and len(panels) < MOST_OVERVIEWS:
        view = _best(_candidates(stage), left)
        seen = _seen(view, left)
        if not seen:
            break
        panels.append((view, _seen(view, placed), ""))
        left = [mark for mark in left if mark not in seen]
    return panels + _close_ups(panels)[: MOST_PANELS - len(panels)]


def visible_anchors(view: View, mark: Mark) -> Floats:
    """(k, 3) anchors of a mark that are in the picture, and not hidden."""
    pixels = view.project(mark.anchors, 400, 300)
    within = (pixels[:, 2] > 0) & (abs(pixels[:, 0] - 200) < 190) & (abs(pixels[:, 1] - 150) < 140)
    return np.asarray(mark.anchors[within & view.sees(mark.anchors)])


def _breadth(view: View, mark: Mark) -> float:
    """How broad a mark is where it is narrowest, relative to the picture: nothing if it is seen edge-on."""
    corners = np.concatenate([mark.edges, mark.outlines]).reshape(-1, 3)
    pixels = view.project(corners, 4, 3)[:, :2]
    pixels = pixels[np.isfinite(pixels).all(axis=1)]
    if len(pixels) < 3:
        return 0.0
    spread = np.linalg.eigvalsh(np.cov(pixels.T))
    return float(np.sqrt(max(spread[0], 0.0)) / 3)


def _seen(view: View, marks: list[Mark]) -> list[Mark]:
    return [mark for mark in marks if len(visible_anchors(view, mark))]


def _best(candidates: Iterator[View], marks: list[Mark]) -> View:
    """The view in which most marks are seen; of equal ones, that which shows most of them and of the scene."""

    def score(view: View) -> tuple[int, float]:
        shown, _ = view.first_hits(48, 36)
        tint = np.where(shown >= 0, view.stage.tint[shown], -1)
        surfaces = len(np.unique(view.stage.surface[shown[shown >= 0]]))
        above = float(view.axes[2] @ view.stage.up < 0)
        # Who looks into a room sees the backs of walls that are turned, and what they would hide from behind.
        faces = np.unique(shown[tint >= 0])
        backs = view.stage.normal[faces] @ view.axes[2] > 0
        behind = 1.5 * float(backs.any())
        behind += 2.0 * sum(_breadth(view, mark) for mark in marks)
        share = behind + 0.5 * above + sum(len(visible_anchors(view, mark)) / len(mark.anchors) for mark in marks)
        return len(_seen(view, marks)), share + 0.1 * surfaces + 2.0 * len(np.unique(tint[tint >= 0]))

    return max(candidates, key=score)


def _candidates(stage: Stage) -> Iterator[View]:
    """From above the corners, then from below and from the sides."""
    few = len(stage.polygons) > MANY_FACES
    for elevation, start in ((28, 40), (-24, 40), (10, 0)):
        for turn in range(4):
            yield View(stage, _from_outside(stage, math.radians(start + 90 * turn + 7), math.radians(elevation)))
        if few:
            break


def _own_cameras(stage: Stage) -> Iterator[View]:
    for camera in stage.scene.cameras:
        vectors = np.array([camera.position, camera.forward, camera.up], dtype=np.float64)
        usable = np.isfinite(vectors).all() and np.linalg.norm(np.cross(vectors[1], vectors[2])) > 1e-6
        if usable and 0 < camera.vertical_fov < math.pi:
            yield View(stage, camera)


def _from_outside(stage: Stage, azimuth: float, elevation: float) -> Camera:
    """A camera that has the whole scene in its picture."""
    low, high = stage.bounds
    centre, up = 0.5 * (low + high), stage.up
    side = np.eye(3)[(int(np.argmax(abs(up))) + 1) % 3]
    across = np.cross(up, side)
    away = math.cos(elevation) * (math.cos(azimuth) * side + math.sin(azimuth) * across) + math.sin(elevation) * up
    right = np.cross(up, away)
    right /= np.linalg.norm(right)
    above = np.cross(away, right)
    corners = np.array([[(low, high)[k >> axis & 1][axis] for axis in range(3)] for k in range(8)]) - centre
    tangent = math.tan(0.5 * FOV) * 0.92
    needed = corners @ away + np.maximum(abs(corners @ right) / (tangent * ASPECT), abs(corners @ above) / tangent)
    distance = max(float(needed.max()), 1e-9)
    return Camera.look_at(_triple(centre + distance * away), _triple(centre), _triple(up), FOV)


def _close_ups(panels: list[Panel]) -> list[Panel]:
    """A view close to each mark that is too small to be made out, errors and warnings first."""
    found, done = [], set()
    for view, seen, _ in panels:
        for mark in seen:
            if mark.number in done or mark.size <= 0:
                continue
            place = visible_anchors(view, mark)[0]
            ahead, above = (
                view.project(place[None] + step, 1333, 1000)[0] for step in (0 * place, mark.size * view.axes[1])
            )
            if abs(ahead[1] - above[1]) < LEAST_PIXELS:
                done.add(mark.number)
                found.append((mark, _near(view, mark, place)))
    # Gaps come first: nobody sees them otherwise.
    found.sort(key=lambda pair: (pair[0].finding.code != "narrow-gap", pair[0].number))
    return [(view, [mark], f"{mark.number} close up") for mark, view in found]


def _near(view: View, mark: Mark, place: Floats) -> View:
    """The same line of sight, from as near as the size of a mark asks for."""
    scene = float(np.linalg.norm(np.subtract(*view.stage.bounds)))
    # Closer than this, single precision would show.
    size = max(mark.size, 2e-5 * scene)
    away = (view.eye - place) / np.linalg.norm(view.eye - place)
    distance = min(12 * size / math.tan(0.5 * FOV), float(np.linalg.norm(view.eye - place)))
    camera = replace(view.camera, position=_triple(place + distance * away), forward=_triple(-away), vertical_fov=FOV)
    return View(view.stage, camera)


def _triple(v: Floats) -> tuple[float, float, float]:
    return float(v[0]), float(v[1]), float(v[2])
