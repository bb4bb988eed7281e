"""The first box of radiosity: an empty cube, red on the left and blue on the right.

Goral, Torrance, Greenberg and Battaile 1984, *Modeling the interaction of light between diffuse surfaces*, introduced
radiosity to computer graphics with the inside of a cube seen through one of its sides, without anything in it because
form factors were found analytically and could not tell what is hidden. Its sides were cut into 7 x 7 patches, and
radiosities were interpolated bilinearly within them. A red left and a blue right wall among white ones lend it their
colour. Its size, its paints and its lamp here are chosen, not measured.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from radiosity.scene import Camera, Scene, Surface

Floats = npt.NDArray[np.float64]
Colour = tuple[float, float, float]

WHITE: Colour = (0.75, 0.75, 0.75)
RED: Colour = (0.70, 0.10, 0.08)
BLUE: Colour = (0.12, 0.16, 0.62)
DAYLIGHT: Colour = (10.0, 10.0, 10.0)

EYE = 1.5
"""Metres from the front to the viewer, for a cube of one metre."""


def goral_box(cells: int = 7, *, emission: Colour = DAYLIGHT) -> Scene:
    """An empty cube lit by its open front, red on the left, blue on the right: after Goral et al., 1984.

    The front, through which one looks, is the lamp: it shines evenly into the cube, as a wide diffuse light before it
    would, and reflects nothing, as what leaves by it does not return. One looks through its back. So the six sides are
    closed. ``scene.patches(as_is=True)`` are the patches of the paper, 49 a side, and mode "smooth" is its shading.

    Args:
        cells: faces along each edge; 6 cells^2 in all.
        emission: radiant exitance of the front, W/m2.

    Raises:
        ValueError: there is not even one cell.
    """
    if cells < 1:
        raise ValueError(f"cells must be at least 1, not {cells}")
    x, y, z = np.eye(3)
    # y points up and z into the cube, as in the later Cornell box, so that x points left.
    sides = {
        "floor": (0 * x, z, x, WHITE),
        "ceiling": (y, x, z, WHITE),
        "left wall": (x, z, y, RED),
        "right wall": (0 * x, y, z, BLUE),
        "back wall": (z, y, x, WHITE),
        "front": (0 * x, x, y, (0.0, 0.0, 0.0)),
    }
    surfaces = [
        _side(name, corner, u, v, cells, paint, emission if name == "front" else (0.0, 0.0, 0.0))
        for name, (corner, u, v, paint) in sides.items()
    ]
    # A hundredth more than the front.
    camera = Camera.look_at((0.5, 0.5, -EYE), (0.5, 0.5, 0.5), vertical_fov=2 * math.atan(0.505 / EYE))
    return Scene(surfaces, cameras=[camera], name="Goral box", bands=["R", "G", "B"])


def _side(name: str, corner: Floats, u: Floats, v: Floats, cells: int, paint: Colour, emission: Colour) -> Surface:
    """A unit square that looks along u x v, in equal cells."""
    at = np.linspace(0, 1, cells + 1)
    vertices = corner + at[:, None, None] * v + at[None, :, None] * u
    first = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).reshape(-1, 1)
    faces = first + np.array([0, 1, cells + 2, cells + 1])
    return Surface(vertices.reshape(-1, 3), faces, paint, emission, name)
