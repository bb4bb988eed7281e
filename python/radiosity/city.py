"""A city: blocks of buildings along streets, in the sun."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from radiosity.scene import Camera, DirectionalLight, Light, Scene, Surface

Floats = npt.NDArray[np.float64]

LOT = 28.0
"""Side of the square that a building stands on, metres."""
STREET = 18.0
"""Width of a street, metres."""
LOTS = 2
"""Buildings along the side of a block."""

ASPHALT = (0.09, 0.09, 0.10)
PAVEMENT = (0.30, 0.29, 0.27)
ROOF = (0.24, 0.22, 0.21)
WALLS = {
    "white walls": (0.72, 0.70, 0.66),
    "brick walls": (0.45, 0.24, 0.17),
    "sand walls": (0.58, 0.49, 0.36),
    "glass walls": (0.20, 0.27, 0.32),
}
SUNLIGHT = (950.0, 900.0, 800.0)
SKYLIGHT = (90.0, 130.0, 200.0)


@dataclass(frozen=True)
class _Buildings:
    """Footprints and heights: low and high corners (n, 2), heights (n,), the corners of their lots (n, 2)."""

    low: Floats
    high: Floats
    height: Floats
    lot: Floats


def city(
    blocks: int = 6,
    *,
    elevation: float = 40.0,
    azimuth: float = 30.0,
    sky: int = 0,
    tallest: float = 90.0,
    seed: int = 0,
) -> Scene:
    """Blocks of buildings along streets on level ground, lit by the sun and, if asked for, by the sky.

    Every building is a box on a lot of its own; the ground has no part under it. The scene is open above. Cut it into
    as many patches as you like: ``city().patches(count=1_000_000)``.

    Args:
        blocks: along each side; a block has four buildings.
        elevation: of the sun above the horizon, degrees.
        azimuth: where the sun stands, degrees from +x toward +z.
        sky: parallel lights that stand for an even sky; 0 leaves the sky black.
        tallest: height that no building exceeds, metres; most are far lower.
        seed: of the buildings. The same seed gives the same city.

    Raises:
        ValueError: a number is out of range.
    """
    if not 1 <= blocks <= 200:
        raise ValueError(f"blocks must be from 1 to 200, not {blocks}")
    if not 0 < elevation <= 90:
        raise ValueError(f"the sun must stand above the horizon, at most in the zenith, not at {elevation} degrees")
    if not 0 <= sky <= 1000:
        raise ValueError(f"sky must be from 0 to 1000 lights, not {sky}")
    if not tallest >= 8:
        raise ValueError(f"tallest must be at least 8 metres, not {tallest}")
    rng = np.random.default_rng(seed)
    buildings = _buildings(blocks, tallest, rng)
    paint = rng.integers(0, len(WALLS), len(buildings.height))
    surfaces = [
        _surface("streets", ASPHALT, _streets(blocks)),
        _surface("pavements", PAVEMENT, _pavements(buildings)),
        _surface("roofs", ROOF, _roofs(buildings)),
    ]
    walls = _walls(buildings)
    for k, (name, reflectance) in enumerate(WALLS.items()):
        if np.any(paint == k):
            surfaces.append(_surface(name, reflectance, walls[paint == k].reshape(-1, 4, 3)))
    lights: list[Light] = [DirectionalLight(_toward(elevation, azimuth), SUNLIGHT, "sun"), *_sky(sky)]
    return Scene(surfaces, lights=lights, cameras=_cameras(blocks, tallest), name="city", bands=["R", "G", "B"])


def _buildings(blocks: int, tallest: float, rng: np.random.Generator) -> _Buildings:
    """One building a lot: set back by a few metres, a few storeys high, now and then a tower."""
    pitch = LOTS * LOT + STREET
    line = (np.arange(blocks)[:, None] * pitch + STREET + np.arange(LOTS) * LOT).ravel()
    lot = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    low = lot + rng.uniform(1.5, 6.0, lot.shape)
    high = lot + LOT - rng.uniform(1.5, 6.0, lot.shape)
    storeys = np.ceil(np.exp(rng.normal(1.6, 0.7, len(lot))))
    height = np.clip(3.2 * storeys, 6.4, tallest)
    return _Buildings(low, high, height, lot)


def _level(low: Floats, high: Floats, height: Floats | float = 0.0) -> Floats:
    """Rectangles (n, 4, 3) that face up, between corners (n, 2) in x and z."""
    (x0, z0), (x1, z1) = low.T, high.T
    y = np.broadcast_to(np.asarray(height, dtype=float), x0.shape)
    corners = [(x0, y, z0), (x0, y, z1), (x1, y, z1), (x1, y, z0)]
    return np.stack([np.stack(corner, axis=-1) for corner in corners], axis=1)


def _streets(blocks: int) -> Floats:
    """Strips along x from end to end, and between them strips along z."""
    pitch, end = LOTS * LOT + STREET, blocks * (LOTS * LOT + STREET) + STREET
    start = np.arange(blocks + 1) * pitch
    along_x = _level(np.stack([0 * start, start], -1), np.stack([0 * start + end, start + STREET], -1))
    x, z = (v.ravel() for v in np.meshgrid(start, start[:-1] + STREET))
    along_z = _level(np.stack([x, z], -1), np.stack([x + STREET, z + LOTS * LOT], -1))
    return np.concatenate([along_x, along_z])


def _pavements(b: _Buildings) -> Floats:
    """What is left of each lot around its building: two strips from side to side, two between them."""
    end = b.lot + LOT
    x, z = 0, 1
    return np.concatenate(
        [
            _level(b.lot, np.stack([end[:, x], b.low[:, z]], -1)),
            _level(np.stack([b.lot[:, x], b.high[:, z]], -1), end),
            _level(np.stack([b.lot[:, x], b.low[:, z]], -1), np.stack([b.low[:, x], b.high[:, z]], -1)),
            _level(np.stack([b.high[:, x], b.low[:, z]], -1), np.stack([end[:, x], b.high[:, z]], -1)),
        ]
    )


def _roofs(b: _Buildings) -> Floats:
    return _level(b.low, b.high, b.height)


def _walls(b: _Buildings) -> Floats:
    """(n, 4, 4, 3): the four walls of each building, facing out."""
    base, top = _level(b.low, b.high), _level(b.low, b.high, b.height)
    walls = [np.stack([base[:, k], base[:, (k + 1) % 4], top[:, (k + 1) % 4], top[:, k]], axis=1) for k in range(4)]
    return np.stack(walls, axis=1)


def _surface(name: str, reflectance: tuple[float, float, float], quads: Floats) -> Surface:
    return Surface(quads.reshape(-1, 3), np.arange(4 * len(quads)).reshape(-1, 4), reflectance, 0.0, name)


def _toward(elevation: float, azimuth: float) -> tuple[float, float, float]:
    """The direction that light from there travels."""
    up, round_ = math.radians(elevation), math.radians(azimuth)
    return -math.cos(up) * math.cos(round_), -math.sin(up), -math.cos(up) * math.sin(round_)


def _sky(count: int) -> list[DirectionalLight]:
    """Lights over the hemisphere by the golden angle; each brings level ground an equal part of the sky's light."""
    k = np.arange(count)
    sine = np.sqrt((k + 0.5) / max(count, 1))  # even in the square: each brings the ground as much
    angle = k * math.pi * (3 - math.sqrt(5))
    cosine = np.sqrt(1 - sine**2)
    lights: list[DirectionalLight] = []
    for s, c, a in zip(sine, cosine, angle, strict=True):
        direction = (float(-s * math.cos(a)), float(-c), float(-s * math.sin(a)))
        lights.append(DirectionalLight(direction, [v / count / float(c) for v in SKYLIGHT], f"sky {len(lights)}"))
    return lights


def _cameras(blocks: int, tallest: float) -> list[Camera]:
    size = blocks * (LOTS * LOT + STREET) + STREET
    middle = (0.5 * size, 0.0, 0.5 * size)
    above = Camera.look_at((-0.35 * size, 0.55 * size + tallest, -0.15 * size), middle, name="above")
    street = (STREET + LOTS * LOT) * (blocks // 2) + 0.5 * STREET
    eye = (street, 6.0, 0.02 * size)
    return [above, Camera.look_at(eye, (street + 2.0, 9.0, 0.5 * size), vertical_fov=math.radians(60), name="street")]
