"""Form factors of chosen pairs of an occluded scene, independent of this engine; needs NumPy, SciPy and Numba.

    python -m peers.exact SCENE OUT.npz [--pairs 2000] [--error 5e-8] [--relative 1e-3] [--seed 1]

From a point the factor to the visible part of a polygon is exact: every polygon in between is cut to the near side of
the receiver's plane, its cone is subtracted from the receiver, and Lambert's formula gives the factor of what is left.
The mean over the emitter is quasi-Monte Carlo: scrambled Sobol points in independent replicates, whose scatter is the
standard error; points are doubled until the error asked for is reached. ``brute_force`` is a second way that shares
nothing with it but the list of polygons.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray
from scipy.stats import qmc

from factor_scenes import Scene, scene

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

REPLICATES = 8
FEWEST, MOST = 6, 17  # powers of two: points of one replicate
CORNERS = 16  # of a piece of the receiver
PIECES = 512


@dataclass(frozen=True)
class Estimate:
    """Factors and what is known of them."""

    factor: Array  # (k,)
    error: Array  # (k,) standard error
    points: Ints  # (k,) points on the emitter, all replicates together


def main() -> None:
    """Compute the factors of a sample of pairs and write them."""
    parser = argparse.ArgumentParser(description="Exact form factors of a sample of pairs")
    parser.add_argument("scene")
    parser.add_argument("out")
    parser.add_argument("--pairs", type=int, default=2000)
    parser.add_argument("--error", type=float, default=5e-8, help="standard error that is always good enough")
    parser.add_argument("--relative", type=float, default=1e-3, help="good enough too, up to 10 times the error")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    of = scene(args.scene)
    pairs = sample(of, args.pairs, args.seed)
    found = factors(of, pairs, args.error, args.seed, relative=args.relative)
    np.savez(args.out, pairs=pairs, factor=found.factor, error=found.error)


def sample(of: Scene, count: int, seed: int) -> Ints:
    """Pairs that face one another: half at random, half among those with a corner in common, (k, 2)."""
    rng = np.random.default_rng(seed)
    touching = rng.permutation(facing(of, neighbours(of)))[: count // 2]
    anywhere = rng.integers(len(of.faces), size=(40 * count, 2))
    anywhere = facing(of, anywhere[anywhere[:, 0] != anywhere[:, 1]])[: count - len(touching)]
    return np.concatenate([touching, anywhere])


def neighbours(of: Scene) -> Ints:
    """All pairs (i, j) with a vertex in common, (k, 2)."""
    by_vertex: dict[int, list[int]] = {}
    for face, corners in enumerate(of.faces.tolist()):
        for vertex in corners:
            by_vertex.setdefault(vertex, []).append(face)
    return np.array(sorted({(i, j) for faces in by_vertex.values() for i in faces for j in faces if i != j}))


def facing(of: Scene, pairs: Ints) -> Ints:
    """The pairs of which each has a corner in front of the other's plane."""
    p, n = of.polygons, of.normals
    i, j = pairs.T
    front_j = np.einsum("kcx,kx->kc", p[j] - p[i][:, :1], n[i]).max(axis=1)
    front_i = np.einsum("kcx,kx->kc", p[i] - p[j][:, :1], n[j]).max(axis=1)
    return pairs[(front_i > 1e-9) & (front_j > 1e-9)]


def factors(
    of: Scene, pairs: Ints, error: float, seed: int, *, relative: float = 0.0, occluded: bool = True
) -> Estimate:
    """F from the first to the second of every pair.

    Args:
        of: the scene.
        pairs: (k, 2).
        error: a standard error of every F that is good enough.
        seed: of the points.
        relative: a standard error over F that is good enough too, as long as it is no more than 10 ``error``.
        occluded: whether polygons hide one another.
    """
    p, n = of.polygons, of.normals
    blockers = [between(p, n, i, j) if occluded else np.zeros(0, np.int64) for i, j in pairs]
    starts = np.concatenate([[0], np.cumsum([len(b) for b in blockers])]).astype(np.int64)
    blockers = np.concatenate([*blockers, np.zeros(0, np.int64)])
    points = [sobol(power, seed) for power in range(FEWEST, MOST + 1)]
    values = np.full((len(pairs), REPLICATES), np.nan)
    used = np.zeros(len(pairs), np.int64)
    todo = np.arange(len(pairs))
    for unit in points:
        values[todo] = replicates(p, n, pairs[todo], blockers, starts[todo], starts[todo + 1], unit)
        used[todo] = unit.shape[0] * unit.shape[1]
        wanted = np.clip(relative * values[todo].mean(axis=1), error, 10 * error)
        todo = todo[standard_error(values[todo]) > wanted]
        if not len(todo):
            break
    return Estimate(values.mean(axis=1), standard_error(values), used)


def standard_error(values: Array) -> Array:
    """Of the mean of independent replicates, (k,)."""
    return values.std(axis=1, ddof=1) / np.sqrt(values.shape[1])


def sobol(power: int, seed: int) -> Array:
    """Scrambled Sobol points of the unit square, (replicates, 2^power, 2)."""
    seeds = [1000 * seed + r for r in range(REPLICATES)]
    return np.stack([qmc.Sobol(2, scramble=True, rng=s).random_base2(power) for s in seeds])


def between(p: Array, n: Array, i: int, j: int) -> Ints:
    """Polygons that may hide part of j from i: in front of both planes and not beside the hull of the two."""
    tiny = 1e-9 * np.ptp(p[[i, j]].reshape(-1, 3), axis=0).max()
    keep = np.ones(len(p), bool)
    keep[[i, j]] = False
    for k in (i, j):
        keep &= ((p - p[k, 0]) @ n[k]).max(axis=1) > tiny
    left = np.flatnonzero(keep)
    for axis in separating_axes(p[i], p[j]):
        hull = p[[i, j]].reshape(-1, 3) @ axis
        heights = p[left] @ axis
        left = left[(heights.max(axis=1) > hull.min() + tiny) & (heights.min(axis=1) < hull.max() - tiny)]
    return left


def separating_axes(a: Array, b: Array) -> Array:
    """The coordinate axes, and directions across the line that joins the two polygons."""
    line = b.mean(axis=0) - a.mean(axis=0)
    u = np.cross(line, np.eye(3)[np.argmin(np.abs(line))])
    u, v = u / np.linalg.norm(u), np.cross(line, u) / np.linalg.norm(np.cross(line, u))
    turn = np.arange(12) * np.pi / 12
    return np.concatenate([np.eye(3), np.cos(turn)[:, None] * u + np.sin(turn)[:, None] * v])


@njit(parallel=True, cache=True)
def replicates(p, n, pairs, blockers, start, stop, unit):
    """Mean factor of every pair in every replicate, (k, replicates)."""
    out = np.empty((len(pairs), unit.shape[0]))
    for k in prange(len(pairs)):
        i, j = pairs[k]
        pieces = np.empty((2, PIECES, CORNERS, 3))
        for r in range(unit.shape[0]):
            total = 0.0
            for s in range(unit.shape[1]):
                x = on_polygon(p[i], unit[r, s, 0], unit[r, s, 1])
                total += from_point(x, n[i], p, n, j, blockers[start[k] : stop[k]], pieces)
            out[k, r] = total / unit.shape[1]
    return out


@njit(cache=True)
def on_polygon(q, s, t):
    """A point of a triangle or plane convex quadrilateral, uniform for uniform s and t."""
    second = 1
    if len(q) == 4:
        first = area(q[0], q[1], q[2])
        share = first / (first + area(q[0], q[2], q[3]))
        if s < share:
            s = s / share
        else:
            s = (s - share) / (1 - share)
            second = 2
    root = np.sqrt(s)
    return (1 - root) * q[0] + root * (1 - t) * q[second] + root * t * q[second + 1]


@njit(cache=True)
def area(a, b, c):
    """Area of a triangle."""
    return 0.5 * np.sqrt((np.cross(b - a, c - a) ** 2).sum())


@njit(cache=True)
def from_point(x, normal, p, n, j, blockers, pieces):
    """Factor from a point to the visible part of polygon j."""
    if np.dot(x - p[j, 0], n[j]) <= 0:
        return 0.0
    counts = np.zeros((2, PIECES), np.int64)
    seen = np.empty((CORNERS, 3))
    for c in range(p.shape[1]):
        seen[c] = p[j, c] - x
    counts[0, 0] = clip(seen, p.shape[1], normal, 0.0, pieces[0, 0])
    number, now = 1, 0
    scratch = np.empty((3, CORNERS, 3))
    planes = np.empty((CORNERS, 3))
    if counts[0, 0] < 3:
        return 0.0
    for k in blockers:
        # Only what lies between x and the plane of j hides it.
        for c in range(p.shape[1]):
            seen[c] = p[k, c] - x
        corners = clip(seen, p.shape[1], n[j], np.dot(x - p[j, 0], n[j]), scratch[0])
        sides = cone(scratch[0], corners, planes)
        if sides < 3:
            continue
        kept = 0
        for m in range(number):
            kept = subtract(
                pieces[now, m], counts[now, m], planes, sides, pieces[1 - now], counts[1 - now], kept, scratch
            )
        number, now = kept, 1 - now
        if number == 0:
            return 0.0
    total = 0.0
    for m in range(number):
        total += abs(lambert(pieces[now, m], counts[now, m], normal))
    return total


@njit(cache=True)
def cone(corners, count, planes):
    """Inward normals of the planes through the eye and the edges of a convex polygon; none if seen edge on."""
    if count < 3:
        return 0
    centre = np.zeros(3)
    for c in range(count):
        centre += corners[c] / count
    sides = 0
    largest = 0.0
    for c in range(count):
        a, b = corners[c], corners[(c + 1) % count]
        side = np.cross(a, b)
        length = np.sqrt(np.dot(side, side))
        if length <= 1e-14 * np.sqrt(np.dot(a, a) * np.dot(b, b)):
            continue
        side /= length
        height = np.dot(side, centre)
        largest = max(largest, abs(height))
        planes[sides] = side if height > 0 else -side
        sides += 1
    return sides if largest > 1e-13 * np.sqrt(np.dot(centre, centre)) else 0


@njit(cache=True)
def subtract(piece, count, planes, sides, out, counts, kept, scratch):
    """Append the convex parts of a piece outside a cone to ``out``; returns how many pieces are there."""
    for s in range(sides):
        outside = True
        for c in range(count):
            if np.dot(planes[s], piece[c]) > 1e-15 * np.sqrt(np.dot(piece[c], piece[c])):
                outside = False
        if outside:
            out[kept, :count] = piece[:count]
            counts[kept] = count
            return kept + 1
    rest = scratch[1]
    rest[:count] = piece[:count]
    for s in range(sides):
        if kept >= PIECES - 1 or count >= CORNERS - 2:
            raise ValueError("a view in more pieces than there is room for; raise PIECES and CORNERS")
        left = clip(rest, count, -planes[s], 0.0, out[kept])
        if left >= 3:
            counts[kept] = left
            kept += 1
        count = clip(rest, count, planes[s], 0.0, scratch[2])
        rest[:count] = scratch[2, :count]
        if count < 3:
            break
    return kept


@njit(cache=True)
def clip(polygon, count, normal, offset, out):
    """The part of a polygon where normal . v + offset >= 0; returns its number of corners (Sutherland and Hodgman)."""
    made = 0
    inside = False
    for c in range(count):
        a, b = polygon[c], polygon[(c + 1) % count]
        ha, hb = np.dot(normal, a) + offset, np.dot(normal, b) + offset
        if ha >= 0:
            out[made] = a
            made += 1
            inside = inside or ha > 0
        if ha * hb < 0:
            out[made] = a + (ha / (ha - hb)) * (b - a)
            made += 1
    return made if inside else 0


@njit(cache=True)
def lambert(polygon, count, normal):
    """Factor from a point with this normal to a polygon given relative to it (Lambert 1760)."""
    total = 0.0
    for c in range(count):
        a, b = polygon[c], polygon[(c + 1) % count]
        side = np.cross(a, b)
        length = np.sqrt(np.dot(side, side))
        if length > 0:
            total += np.dot(normal, side) / length * np.arctan2(length, np.dot(a, b))
    return total / (2 * np.pi)


def brute_force(of: Scene, pair: Ints, points: int, seed: int) -> tuple[float, float]:
    """F and its standard error from random pairs of points, a segment tested against all other polygons."""
    p, n = of.polygons, of.normals
    i, j = pair
    rng = np.random.default_rng(seed)
    x, y = uniform(p[i], points, rng), uniform(p[j], points, rng)
    d = y - x
    r2 = (d**2).sum(axis=1)
    kernel = np.maximum(d @ n[i], 0) * np.maximum(-d @ n[j], 0) / (np.pi * r2**2) * of.areas[j]
    live = np.flatnonzero(kernel > 0)
    for k in between(p, n, i, j):
        live = live[~crosses(x[live], d[live], p[k], n[k])]
    seen = np.zeros(points)
    seen[live] = kernel[live]
    return float(seen.mean()), float(seen.std() / np.sqrt(points))


def uniform(q: Array, count: int, rng: np.random.Generator) -> Array:
    """Random points of a polygon, (count, 3)."""
    return placed(q, rng.random((count, 2)))


@njit(cache=True)
def placed(q, unit):
    """Points of a polygon from points of the unit square, (count, 3)."""
    out = np.empty((len(unit), 3))
    for k in range(len(unit)):
        out[k] = on_polygon(q, unit[k, 0], unit[k, 1])
    return out


def crosses(x: Array, d: Array, q: Array, normal: Array) -> NDArray[np.bool_]:
    """Whether the segments x to x + d cross a convex polygon, (k,)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        t = ((q[0] - x) @ normal) / (d @ normal)
    hit = (t > 0) & (t < 1)
    at = x + np.where(hit, t, 0)[:, None] * d
    for a, b in zip(q, np.roll(q, -1, axis=0), strict=True):
        hit &= np.cross(b - a, at - a) @ normal >= 0
    return hit


if __name__ == "__main__":
    main()
