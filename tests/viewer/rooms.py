"""A room with lamps of every kind."""

from __future__ import annotations

import numpy as np
from known import square

import radiosity


def lamp_room() -> radiosity.Scene:
    """Two lamps above a floor, a sheet with two sides between, and lights without area."""
    floor = radiosity.Surface(square(4.0), [[0, 1, 2, 3]], [0.5, 0.6, 0.7], 0.0, "floor")
    up = np.array([[0, 1, 2, 3]])
    sheet = radiosity.Surface(square(1.0, 1.0), up, 0.4, 0.0, "sheet", two_sided=True)
    lamps = [
        radiosity.Surface(square(0.5, 2.0), up[:, ::-1], 0.2, [4.0, 2.0, 1.0], "warm", material="warm"),
        radiosity.Surface(np.add(square(0.5, 2.0), [1, 0, 0]), up[:, ::-1], 0.2, [1.0, 2.0, 4.0], "cold"),
        radiosity.Surface(np.add(square(0.5, 0.5), [1, 1, 0]), up, 0.2, 0.5, "screen", two_sided=True),
    ]
    lights = [
        radiosity.PointLight([0, 1, 1.5], [3.0, 2.0, 1.0], "bulb"),
        radiosity.DirectionalLight([0, 1, -1], 0.7, "sun"),
    ]
    return radiosity.Scene([floor, sheet, *lamps], lights, name="lamp room")
