"""White boards that glow in the colours of their backs: an interpretation of a sculpture in wood.

After John Ferren, *Construction in Wood, a Daylight Experiment* (1968): boards whose fronts, which the viewer sees, are
white, and whose backs, turned away from the viewer and towards a window, are painted in bright colours. All light on
the fronts has met the painted back of the neighbour. Goral, Torrance, Greenberg and Battaile 1984 introduced radiosity
to computer graphics with it. Its dimensions are not published; those here are chosen.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from radiosity.scene import Camera, Scene, Surface

Floats = npt.NDArray[np.float64]
Colour = tuple[float, float, float]

PAINTS: tuple[Colour, ...] = (
    (0.75, 0.06, 0.04),
    (0.80, 0.32, 0.03),
    (0.80, 0.68, 0.04),
    (0.10, 0.52, 0.10),
    (0.04, 0.34, 0.62),
    (0.20, 0.10, 0.55),
    (0.62, 0.08, 0.36),
)
"""Reflectances of the backs, from the left; repeated if there are more boards."""

WHITE = (0.80, 0.80, 0.80)
WALLS = (0.06, 0.06, 0.06)
DAYLIGHT = (270.0, 290.0, 310.0)

BEHIND, BESIDE, BEFORE = 3.0, 1.2, 3.2
"""Metres from the boards to the window, to the side walls, and to the wall behind the viewer."""

END = 25.0
"""Degrees that the last panel is turned further than the boards, so that the viewer hardly sees its front."""


def ferren(
    boards: int = 7,
    *,
    yaw: float = 40.0,
    width: float = 0.30,
    height: float = 1.80,
    thickness: float = 0.025,
    spacing: float = 0.22,
    stagger: float = 0.06,
    paints: Sequence[Colour] | None = None,
    daylight: Colour = DAYLIGHT,
) -> Scene:
    """Tall boards, white in front and painted behind, before a window: after John Ferren, 1968.

    They stand in a row in a dark room, turned about the vertical, so that each front faces the painted back of its
    neighbour on the right and no front sees the window. A last panel on the right, turned further, is there for the
    paint on its back, which the front beside it faces.

    Args:
        boards: 6 to 9 look like the sculpture; at least 2.
        yaw: degrees from facing the viewer, 30 to 60.
        width, height, thickness: of a board, metres.
        spacing: from each board to the next, metres.
        stagger: every other board stands this much further back, metres.
        paints: reflectances of the backs from the left; white ones make the whole piece neutral.
        daylight: radiant exitance of the window, W/m2.

    Raises:
        ValueError: fewer than two boards, an angle that turns the fronts to the window, or boards that touch.
    """
    if boards < 2:
        raise ValueError(f"boards must be at least 2, not {boards}")
    if not 30 <= yaw <= 60:
        raise ValueError(f"yaw must be from 30 to 60 degrees, so that no front sees the window, not {yaw:g}")
    if spacing * math.sin(math.radians(yaw)) - abs(stagger) * math.cos(math.radians(yaw)) <= 2 * thickness:
        raise ValueError("the boards touch: give a larger spacing, or less stagger or thickness")
    colours = paints or PAINTS
    middle = 0.5 * spacing * (boards - 1)
    surfaces = [
        surface
        for k in range(boards)
        for surface in _board(
            f"board {k + 1}", (spacing * k - middle, -stagger * (k % 2)), math.radians(yaw), width, height, thickness,
            colours[k % len(colours)],
        )
    ]  # fmt: skip
    surfaces += _board(
        "end", (spacing * boards - middle, -stagger), math.radians(yaw + END), width, height, thickness,
        colours[boards % len(colours)],
    )  # fmt: skip
    half = middle + 0.5 * width + BESIDE
    # Half of its width: what lies before the plane of the leftmost front would be seen by it.
    window = min(0.5 * spacing * boards, BEHIND / math.tan(math.radians(yaw)) - middle - 0.5 * width)
    surfaces += _room(half, height + 0.5, window=(window, height), daylight=daylight)
    eye = (0.0, 0.55 * height, 0.95 * BEFORE)
    camera = Camera.look_at(eye, (0.0, 0.5 * height, 0.0), vertical_fov=2 * math.atan(0.62 * height / eye[2]))
    return Scene(surfaces, cameras=[camera], name="Ferren", bands=["R", "G", "B"])


def _board(
    name: str, at: tuple[float, float], yaw: float, width: float, height: float, thickness: float, paint: Colour
) -> list[Surface]:
    """Front, back, and edges; ``at`` is where the middle of its front stands, (x, z)."""
    across = np.array([math.cos(yaw), 0.0, -math.sin(yaw)])
    normal = np.array([math.sin(yaw), 0.0, math.cos(yaw)])
    up = np.array([0.0, height, 0.0])
    foot = np.array([at[0], 0.0, at[1]]) - 0.5 * width * across
    front = np.array([foot, foot + width * across, foot + width * across + up, foot + up])
    back = front - thickness * normal
    box = np.concatenate([front, back])
    edges = np.array([[1, 5, 6, 2], [4, 0, 3, 7], [3, 2, 6, 7]])
    return [
        Surface(front, np.array([[0, 1, 2, 3]]), WHITE, 0.0, f"{name} front", material="white"),
        Surface(back, np.array([[1, 0, 3, 2]]), paint, 0.0, f"{name} back", material=f"{name} paint"),
        Surface(box, edges, WHITE, 0.0, f"{name} edges", material="white"),
    ]


def _room(half: float, top: float, *, window: tuple[float, float], daylight: Colour) -> list[Surface]:
    """A dark box around the boards, with a window behind them: half its width and its height, metres."""
    left, right, far, near = -half, half, -BEHIND, BEFORE

    def quad(name: str, corners: Sequence[Sequence[float]], emission: Colour = (0.0, 0.0, 0.0)) -> Surface:
        material = "window" if any(emission) else "dark"
        return Surface(np.array(corners), np.array([[0, 1, 2, 3]]), WALLS, emission, name, material=material)

    w, h = window
    return [
        quad("floor", [(left, 0, far), (left, 0, near), (right, 0, near), (right, 0, far)]),
        quad("ceiling", [(left, top, far), (right, top, far), (right, top, near), (left, top, near)]),
        quad("left wall", [(left, 0, far), (left, top, far), (left, top, near), (left, 0, near)]),
        quad("right wall", [(right, 0, far), (right, 0, near), (right, top, near), (right, top, far)]),
        quad("wall behind the viewer", [(left, 0, near), (left, top, near), (right, top, near), (right, 0, near)]),
        quad("window", [(-w, 0, far), (w, 0, far), (w, h, far), (-w, h, far)], daylight),
        quad("left of the window", [(left, 0, far), (-w, 0, far), (-w, h, far), (left, h, far)]),
        quad("right of the window", [(w, 0, far), (right, 0, far), (right, h, far), (w, h, far)]),
        quad("above the window", [(left, h, far), (right, h, far), (right, top, far), (left, top, far)]),
    ]
