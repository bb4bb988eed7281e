"""Cratered terrain: a height field in the light of a low sun."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from radiosity.scene import Camera, DirectionalLight, Scene, Surface

Floats = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

SUNLIGHT = 1361.0
"""The solar constant, W/m2 (Kopp and Lean 2011)."""

DEPTH = 0.2
"""Depth of a fresh simple crater over its diameter (Pike 1977)."""
RIM = 0.04
"""Height of its rim over its diameter (Pike 1977)."""


def crater(
    facets: int = 20_000,
    *,
    craters: int = 60,
    roughness: float = 1.0,
    size: float = 600.0,
    elevation: float = 18.0,
    azimuth: float = 0.0,
    reflectance: npt.ArrayLike = 0.12,
    sunlight: npt.ArrayLike = SUNLIGHT,
    seed: int = 0,
) -> Scene:
    """A square of cratered ground in the light of a low sun: one surface of triangles, facing up.

    The largest crater lies in the middle; the numbers of the others follow the inverse square of their size. Between
    them the ground is rough at all scales. A million facets take about a second: ``crater(1_000_000)``. Take them as
    they are: ``scene.patches(as_is=True)``.

    Args:
        facets: about how many triangles; two to each square of a grid.
        craters: how many.
        roughness: of the ground, as a multiple of a plain's; 0 for smooth ground.
        size: side of the square, metres.
        elevation: of the sun above the horizon, degrees.
        azimuth: where the sun stands, degrees from +x toward +z.
        reflectance: of the ground, a number or one a band.
        sunlight: irradiance of what faces the sun, W/m2, a number or one a band.
        seed: of the ground. The same seed and number of facets give the same ground.

    Raises:
        ValueError: a number is out of range.
    """
    if not 2 <= facets <= 50_000_000:
        raise ValueError(f"facets must be from 2 to 50,000,000, not {facets}")
    if not 0 < elevation <= 90:
        raise ValueError(f"the sun must stand above the horizon, at most in the zenith, not at {elevation} degrees")
    if not (size > 0 and roughness >= 0 and craters >= 0):
        raise ValueError("size must be positive, and roughness and the number of craters not negative")
    cells = max(1, round(math.sqrt(facets / 2)))
    height = _height(cells, craters, roughness, size, np.random.default_rng(seed))
    vertices, faces = _mesh(height, size)
    up, round_ = math.radians(elevation), math.radians(azimuth)
    toward = (-math.cos(up) * math.cos(round_), -math.sin(up), -math.cos(up) * math.sin(round_))
    eye = (-0.1 * size, 0.45 * size, -0.12 * size)
    return Scene(
        [Surface(vertices, faces, reflectance, 0.0, "ground")],
        lights=[DirectionalLight(toward, sunlight, "sun")],
        cameras=[Camera.look_at(eye, (0.5 * size, -0.05 * size, 0.5 * size), name="above")],
        name="crater",
    )


def _height(cells: int, craters: int, roughness: float, size: float, rng: np.random.Generator) -> Floats:
    """(cells + 1, cells + 1) heights, metres."""
    line = np.linspace(0.0, size, cells + 1)
    height = np.zeros((cells + 1, cells + 1))
    radius = 0.25 * size * np.maximum((np.arange(craters) + 1.0) ** -0.5, 0.02)
    centre = rng.uniform(0.0, size, (craters, 2))
    centre[:1] = 0.5 * size
    # From large to small, as small ones last only where no large one came later.
    for (x, z), r in zip(centre, radius, strict=True):
        _dig(height, line, x, z, r)
    return height + roughness * _roughness(cells + 1, size, rng)


def _dig(height: Floats, line: Floats, x: float, z: float, radius: float) -> None:
    """Add one crater: a parabolic bowl, a rim, and ejecta that fall off with the cube of the distance."""
    near = slice(*np.searchsorted(line, [x - 3 * radius, x + 3 * radius]))
    far = slice(*np.searchsorted(line, [z - 3 * radius, z + 3 * radius]))
    distance = np.hypot(line[None, near] - x, line[far, None] - z) / radius
    diameter = 2 * radius
    bowl = diameter * ((DEPTH + RIM) * distance**2 - DEPTH)
    ejecta = diameter * RIM * (np.maximum(distance, 1.0) ** -3 - 3.0**-3) / (1 - 3.0**-3)
    height[far, near] += np.where(distance < 1, bowl, np.where(distance < 3, ejecta, 0.0))


def _roughness(count: int, size: float, rng: np.random.Generator) -> Floats:
    """Random heights with a power law spectrum, of a self-affine surface with Hurst exponent 0.8.

    Their standard deviation is 0.2 % of the size.
    """
    noise = np.fft.rfft2(rng.standard_normal((count, count)))
    frequency = np.hypot(np.fft.fftfreq(count)[:, None], np.fft.rfftfreq(count)[None, :])
    frequency[0, 0] = np.inf
    field: Floats = np.fft.irfft2(noise * frequency**-1.8, s=(count, count))
    spread = float(field.std())
    return field * (0.002 * size / spread) if spread > 0 else field


def _mesh(height: Floats, size: float) -> tuple[Floats, Indices]:
    """Vertices (n, 3), y up, and two triangles a square, the diagonals alternating."""
    rows, columns = height.shape
    x, z = np.meshgrid(np.linspace(0, size, columns), np.linspace(0, size, rows))
    vertices = np.stack([x, height, z], axis=-1).reshape(-1, 3)
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    odd = (np.add.outer(np.arange(rows - 1), np.arange(columns - 1)) % 2 == 1)[..., None]
    first = np.where(odd, np.stack([a, b, d], -1), np.stack([a, b, c], -1))
    second = np.where(odd, np.stack([b, c, d], -1), np.stack([a, c, d], -1))
    return vertices, np.stack([first, second], axis=2).reshape(-1, 3)
