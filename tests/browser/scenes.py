"""Scenes of the tests in a browser, and what a pixel of them must be, from the solution's numbers alone."""

from __future__ import annotations

from functools import cache

import numpy as np
import numpy.typing as npt

import radiosity
from radiosity.files import LitModel
from radiosity.viewer.lit import Lit

Floats = npt.NDArray[np.float64]


@cache
def cornell() -> radiosity.Solution:
    return radiosity.solve(radiosity.scenes.cornell_box().patches(count=1500), accuracy=0.05)


def lit(solution: radiosity.Solution) -> Lit:
    return Lit(LitModel.of(solution), title="A test")


def developed(radiance: Floats, stops: float) -> Floats:
    """(..., 3) 0 ... 255: Narkowicz's curve, then sRGB."""
    x = radiance * 2.0**stops
    y = np.clip((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14), 0, 1)
    return 255 * encoded(y)


def encoded(linear: Floats) -> Floats:
    """IEC 61966-2-1, 0 ... 1."""
    return np.asarray(np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055))


class Seen:
    """What the first camera of a scene sees at the centres of every so many pixels of a picture of (height, width).

    Attributes:
        grid: rows and columns of these pixels.
        x, y: (k,) columns and rows.
        point, normal: (k, 3).
        patch: (k,) -1 where there is nothing.
    """

    def __init__(self, solution: radiosity.Solution, size: tuple[int, ...], every: int) -> None:
        height, width = size[:2]
        patches = solution.patches
        camera = patches.scene.cameras[0]
        forward = np.array(camera.forward) / np.linalg.norm(camera.forward)
        right = np.cross(forward, camera.up)
        right /= np.linalg.norm(right)
        down = np.cross(forward, right)
        columns, rows = np.arange(every // 2, width, every), np.arange(every // 2, height, every)
        self.grid = len(rows), len(columns)
        self.x, self.y = (a.ravel() for a in np.meshgrid(columns, rows))
        pixel = 2 * np.tan(0.5 * camera.vertical_fov) / height
        across, along = (pixel * (self.x + 0.5 - width / 2))[:, None], (pixel * (self.y + 0.5 - height / 2))[:, None]
        direction = forward + across * right + along * down
        direction /= np.linalg.norm(direction, axis=1)[:, None]
        eye = np.broadcast_to(np.array(camera.position), direction.shape).copy()
        self.patch, distance, _ = patches._enclosure.looks(eye, np.ascontiguousarray(direction))
        self.point = eye + np.where(self.patch < 0, 0, distance)[:, None] * direction
        self.normal = patches.normal[self.patch]

    def radiance(self, solution: radiosity.Solution, irradiance: Floats | None = None) -> Floats:
        """(k, bands) B / pi with B = E + rho H, W/m2/sr; black where there is nothing."""
        if irradiance is None:
            irradiance = solution.irradiance_at(self.point, self.normal)
        radiosity_ = solution.emission[self.patch] + solution.reflectance[self.patch] * irradiance
        return np.where((self.patch < 0)[:, None], 0.0, radiosity_) / np.pi

    def inner(self, solution: radiosity.Solution) -> npt.NDArray[np.bool_]:
        """(k,) whether the pixel and those around it see one surface: not on an edge of the picture of a surface."""
        surface = np.where(self.patch < 0, -1, solution.patches.surface[self.patch].astype(np.int64))
        grid = surface.reshape(self.grid)
        same = np.ones_like(grid, dtype=bool)
        for shift in (-1, 1):
            for axis in (0, 1):
                same &= np.roll(grid, shift, axis) == grid
        same[[0, -1]] = same[:, [0, -1]] = False
        return np.asarray(same.ravel() & (surface >= 0))


@cache
def two_lamps() -> radiosity.Solution:
    """A closed box with a block in it, a warm lamp on the ceiling and a cold one on a wall."""
    warm, cold = (60.0, 40.0, 15.0), (4.0, 10.0, 24.0)

    def quad(
        name: str, corners: list[list[float]], reflectance: object = 0.6, emission: object = 0.0
    ) -> radiosity.Surface:
        return radiosity.Surface(np.array(corners), np.array([[0, 1, 2, 3]]), reflectance, emission, name)

    walls = [
        quad("floor", [[0, 0, 0], [0, 0, 3], [4, 0, 3], [4, 0, 0]], (0.5, 0.4, 0.3)),
        quad("ceiling", [[0, 2, 0], [4, 2, 0], [4, 2, 3], [0, 2, 3]], 0.8),
        quad("left", [[0, 0, 0], [0, 2, 0], [0, 2, 3], [0, 0, 3]], (0.6, 0.1, 0.1)),
        quad("right", [[4, 0, 0], [4, 0, 3], [4, 2, 3], [4, 2, 0]], (0.1, 0.5, 0.2)),
        quad("back", [[0, 0, 0], [4, 0, 0], [4, 2, 0], [0, 2, 0]]),
        quad("front", [[0, 0, 3], [0, 2, 3], [4, 2, 3], [4, 0, 3]]),
        quad("warm lamp", [[1, 1.99, 1], [2, 1.99, 1], [2, 1.99, 2], [1, 1.99, 2]], 0.5, warm),
        quad("cold lamp", [[3.99, 0.5, 1], [3.99, 0.5, 2], [3.99, 1.5, 2], [3.99, 1.5, 1]], 0.5, cold),
    ]
    camera = radiosity.Camera.look_at((2.0, 1.0, 2.9), (2.0, 0.9, 0.0), vertical_fov=1.0)
    scene = radiosity.Scene(walls, cameras=[camera], name="Two lamps", bands=["R", "G", "B"])
    return radiosity.solve(scene.patches(count=900), accuracy=0.05)
