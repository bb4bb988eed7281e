"""What a few rays from both sides of every face find: cheap, and enough to tell which way faces should look."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from radiosity.patches import Patches

Floats = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]
Progress = Callable[[int, int], object]

CLOSE = 0.05
"""What is nearer than this part of the size of a face is right before it."""

FRONT, BACK = 0, 1
"""Columns of what both sides see."""

_RAYS_IN_ALL = 600_000
_LEAST_RAYS, _MOST_RAYS = 8, 512
_RAYS_AT_ONCE = 1 << 18
_OFF = 1e-6
"""How far off its face a ray starts, relative to the scene: several times what single precision rounds."""


@dataclass(frozen=True)
class Sight:
    """Shares of rays from both sides of each face, (n_faces, 2): front, back.

    Attributes:
        patches: the faces.
        lit: they find a side that takes part in the exchange of light.
        far: the same, but not right before the face.
        black: they find the back of a one-sided face, or an obstruction.
        escaped: they find nothing.
        close: they find something right before the face.
        buried: of all, those that start within a solid that stands on the face; they count for nothing else.
        exits: (k, 2, 3) point and direction of rays from fronts that escaped.
        exit_from: (k,) their faces.
    """

    patches: Patches
    lit: Floats
    far: Floats
    black: Floats
    escaped: Floats
    close: Floats
    buried: Floats
    exits: Floats
    exit_from: Indices


def look_around(
    patches: Patches, *, seed: int = 0, threads: int | None = None, progress: Progress | None = None
) -> Sight:
    """Look around from every face in directions distributed like diffuse light: 8 to 512 rays a side."""
    n = len(patches)
    rays = int(np.clip(_RAYS_IN_ALL // max(2 * n, 1), _LEAST_RAYS, _MOST_RAYS))
    at_once = max(1, _RAYS_AT_ONCE // (2 * rays))
    counts = np.zeros((6, n, 2))
    exits, owners = [np.zeros((0, 2, 3))], [np.zeros(0, np.intp)]
    random = np.random.default_rng(seed)
    for start in range(0, n, at_once):
        faces = np.arange(start, min(start + at_once, n))
        counts[:, faces], found, owner = _shoot(patches, faces, rays, random, threads)
        exits.append(found)
        owners.append(owner)
        if progress is not None:
            progress(int(faces[-1]) + 1, n)
    lit, far, black, escaped, close, buried = counts
    seen = np.maximum(lit + black + escaped, 1)
    return Sight(patches, lit / seen, far / seen, black / seen, escaped / seen, close / seen, buried / rays,
                 np.concatenate(exits), np.concatenate(owners))  # fmt: skip


def _shoot(
    patches: Patches, faces: Indices, rays: int, random: np.random.Generator, threads: int | None
) -> tuple[Floats, Floats, Indices]:
    """(6, faces, 2) counts of one batch, and the rays from fronts that escaped with their faces."""
    points, normals = _points(patches.polygons[faces], rays, random), patches.normal[faces]
    # Faces and rays, sides, coordinates.
    normals = np.repeat(np.stack([normals, -normals], axis=1), rays, axis=0)
    extent = float(np.ptp(patches.polygons.reshape(-1, 3), axis=0).max())
    origins = (points[:, None] + _OFF * extent * normals).reshape(-1, 3)
    directions = _hemisphere(normals.reshape(-1, 3), random)
    see = _Eye(patches, threads)
    lit, black, escaped, distance = see(origins, directions)
    reach = CLOSE * np.sqrt(np.repeat(patches.area[faces], 2 * rays))
    close = (distance < reach) & ~escaped
    buried = np.zeros(len(lit), bool)
    suspects = np.flatnonzero(black)
    buried[suspects] = _is_buried(see, origins[suspects], normals.reshape(-1, 3)[suspects])
    black &= ~buried
    kinds = np.stack([lit, lit & ~close, black, escaped, close, buried])
    counts = kinds.reshape(6, len(faces), rays, 2).sum(axis=2)
    out = np.flatnonzero(escaped & (np.arange(len(lit)) % 2 == FRONT))
    return counts, np.stack([origins[out], directions[out]], axis=1), faces[out // (2 * rays)]


def not_buried(patches: Patches, faces: Indices, *, seed: int = 0, threads: int | None = None) -> Floats:
    """(faces, 2) of what their fronts and backs see and is lit, the share that is not itself within a solid."""
    rays, random = 32, np.random.default_rng(seed)
    extent = float(np.ptp(patches.polygons.reshape(-1, 3), axis=0).max())
    see, shares = _Eye(patches, threads), []
    for normal in (patches.normal[faces], -patches.normal[faces]):
        normals = np.repeat(normal, rays, axis=0)
        origins = _points(patches.polygons[faces], rays, random) + _OFF * extent * normals
        directions = _hemisphere(normals, random)
        polygon, distance, is_front = patches._enclosure.looks(origins, directions, threads)
        lit = np.flatnonzero(see.is_lit(polygon, is_front))
        there = np.where(is_front[lit, None], 1, -1) * patches.normal[polygon[lit]]
        hit = origins[lit] + distance[lit, None] * directions[lit] + 3 * _OFF * extent * there
        sound = np.zeros(len(origins))
        sound[lit] = ~_is_buried(see, hit, there)
        found = np.bincount(lit // rays, minlength=len(faces))
        shares.append(sound.reshape(-1, rays).sum(axis=1) / np.maximum(found, 1))
    return np.stack(shares, axis=1)


class _Eye:
    """What rays find: a lit side, something black, nothing; and how far away it is."""

    def __init__(self, patches: Patches, threads: int | None) -> None:
        self._enclosure, self._threads = patches._enclosure, threads
        sided = np.concatenate([patches.two_sided, np.zeros(len(patches.obstructions) + 1, bool)])
        self._two_sided = sided

    def __call__(
        self, origins: Floats, directions: Floats
    ) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_], npt.NDArray[np.bool_], Floats]:
        polygon, distance, is_front = self._enclosure.looks(origins, directions, self._threads)
        escaped, lit = polygon < 0, self.is_lit(polygon, is_front)
        return lit, ~escaped & ~lit, escaped, distance

    def is_lit(self, polygon: npt.NDArray[np.int64], is_front: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
        """Whether what rays found is a side that takes part in the exchange of light."""
        return np.asarray((polygon >= 0) & (is_front | self._two_sided[polygon]))


def _is_buried(see: _Eye, origins: Floats, normals: Floats) -> npt.NDArray[np.bool_]:
    """(n,) whether points lie within a solid: straight up and to three sides they find backs only."""
    buried = np.ones(len(origins), bool)
    tangent, bitangent = _tangents(normals)
    for x, y, z in ((0.0, 0.0, 1.0), (0.8, 0.0, 0.6), (-0.4, 0.693, 0.6), (-0.4, -0.693, 0.6)):
        left = np.flatnonzero(buried)
        if len(left) == 0:
            break
        directions = x * tangent[left] + y * bitangent[left] + z * normals[left]
        buried[left] = see(origins[left], directions)[1]
    return buried


def _points(polygons: Floats, rays: int, random: np.random.Generator) -> Floats:
    """(n * rays, 3) points evenly on polygons, a little off their edges."""
    a, b, c, d = polygons.transpose(1, 0, 2)
    halves = np.stack([np.linalg.norm(np.cross(b - a, c - a), axis=1), np.linalg.norm(np.cross(c - a, d - a), axis=1)])
    share = np.repeat(halves[0] / np.maximum(halves.sum(axis=0), 1e-300), rays)
    pick, u, v = random.random((3, len(share)))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    first = (pick < share)[:, None]
    corner, second, third = (np.repeat(p, rays, axis=0) for p in (a, b, c))
    fourth = np.repeat(d, rays, axis=0)
    at = corner + u[:, None] * (np.where(first, second, third) - corner)
    at += v[:, None] * (np.where(first, third, fourth) - corner)
    middle = np.repeat(polygons.mean(axis=1), rays, axis=0)
    return np.asarray(at + 1e-4 * (middle - at))


def _hemisphere(normals: Floats, random: np.random.Generator) -> Floats:
    """(n, 3) unit vectors about normals with density cos / pi (Malley 1988)."""
    u, v = random.random((2, len(normals)))
    radius, angle = np.sqrt(u), 2 * np.pi * v
    tangent, bitangent = _tangents(normals)
    x, y, z = radius * np.cos(angle), radius * np.sin(angle), np.sqrt(np.maximum(1 - u, 1e-12))
    return np.asarray(x[:, None] * tangent + y[:, None] * bitangent + z[:, None] * normals)


def _tangents(normals: Floats) -> tuple[Floats, Floats]:
    """Two unit vectors across each normal (Duff et al. 2017)."""
    x, y, z = normals.T
    sign = np.copysign(1.0, z)
    a = -1 / (sign + z)
    b = x * y * a
    return (
        np.stack([1 + sign * x * x * a, sign * b, -sign * x], axis=1),
        np.stack([b, sign + y * y * a, -y], axis=1),
    )
