"""Make the references of single pairs in ``validation/references``; a few minutes, needs NumPy, SciPy and Numba.

    python -m peers.pair_references [--only rough room] [--error 2e-7] [--out FOLDER]

Prints how far the values are from those of ``exact.brute_force``, which is a second method.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from factor_scenes import Scene, scene
from peers import exact
from peers.reference import REPOSITORY

Ints = exact.Ints

REFERENCES = REPOSITORY / "validation" / "references"
SCANNED = 6000  # pairs looked at with few points, to know which are partly hidden
ROUGH = {"touching, partly hidden": 50, "touching, in sight": 40, "partly hidden": 70, "in sight": 30, "hidden": 10}
ROOM = {"partly hidden": 100}
HARD = "touching, hard"
HARD_PAIRS = (  # of the rough crater: the touching pairs on which View3D 3.2 is off the most
    *((53, 55), (56, 121), (196, 199), (225, 290), (286, 350), (500, 562), (599, 665), (608, 610), (610, 675)),
    *((665, 729), (670, 672), (742, 807), (834, 899), (859, 925), (883, 944), (888, 950), (947, 1012), (1081, 1145)),
    *((1178, 1240), (1185, 1187), (1199, 1261), (1236, 1238), (1245, 1307), (1255, 1257), (1307, 1372), (1529, 1593)),
    *((1640, 1704), (1686, 1688), (1753, 1817), (1921, 1987)),
)


def main() -> None:
    """Choose the pairs, compute them and write the files."""
    parser = argparse.ArgumentParser(description="References of single pairs")
    parser.add_argument("--only", nargs="+", choices=("rough", "room"), default=["rough", "room"])
    parser.add_argument("--error", type=float, default=2e-7)
    parser.add_argument("--out", type=Path, default=REFERENCES)
    args = parser.parse_args()
    if "rough" in args.only:
        write(args.out / "rough_crater_pairs.npz", scene("rough-2048"), ROUGH, args.error, hard=HARD_PAIRS)
    if "room" in args.only:
        write(args.out / "room_with_box_pairs.npz", scene("room"), ROOM, args.error)


def write(path: Path, of: Scene, wanted: dict[str, int], error: float, hard: tuple[tuple[int, int], ...] = ()) -> None:
    """Compute the wanted number of pairs of each kind, and the hard ones, and write them."""
    pairs, kind = choose(of, wanted)
    new = np.array([p for p in hard if not (pairs == p).all(axis=1).any()], np.int64).reshape(-1, 2)
    pairs, kind = np.concatenate([pairs, new]), kind + [HARD] * len(new)
    found = exact.factors(of, pairs, error, seed=7)
    free = exact.factors(of, pairs, error, seed=8, occluded=False)
    np.savez_compressed(
        path,
        vertices=of.vertices,
        faces=of.faces,
        pairs=pairs,
        factor=found.factor,
        standard_error=found.error,
        unoccluded=free.factor,
        kind=np.array(kind),
    )
    print(f"{path.name}: {len(pairs)} pairs, largest standard error {found.error.max():.1e}", flush=True)
    compare(of, pairs, np.array(kind), found)


def choose(of: Scene, wanted: dict[str, int]) -> tuple[Ints, list[str]]:
    """Pairs at random of each kind, by a scan with few points."""
    pairs = np.unique(exact.sample(of, SCANNED, seed=3), axis=0)
    pairs = np.random.default_rng(3).permutation(pairs)
    seen = exact.factors(of, pairs, 1.0, seed=3).factor
    free = exact.factors(of, pairs, 1.0, seed=3, occluded=False).factor
    touching = np.array([bool(set(of.faces[i]) & set(of.faces[j])) for i, j in pairs])
    hidden = 1 - seen / np.maximum(free, 1e-30)
    partly, all_of_it = (hidden > 0.02) & (hidden < 0.98), hidden > 1 - 1e-9
    masks = {
        "touching, partly hidden": touching & partly,
        "touching, in sight": touching & (hidden < 1e-9),
        "partly hidden": ~touching & partly,
        "in sight": ~touching & (hidden < 1e-9),
        "hidden": all_of_it,
    }
    large = free > 2e-5
    chosen = {kind: np.flatnonzero(masks[kind] & large)[:count] for kind, count in wanted.items()}
    kinds = [kind for kind, index in chosen.items() for _ in index]
    return pairs[np.concatenate(list(chosen.values()))], kinds


def compare(of: Scene, pairs: Ints, kind: np.ndarray, found: exact.Estimate, points: int = 400_000) -> None:
    """Print how brute force agrees where its variance is finite, that is between polygons apart."""
    apart = [k for k, name in enumerate(kind) if not name.startswith("touching")]
    scores = []
    for k in apart:
        mean, error = exact.brute_force(of, pairs[k], points, seed=k)
        scores.append((mean - found.factor[k]) / np.hypot(max(error, 1e-12), found.error[k]))
    z = np.array(scores)
    print(f"  brute force on {len(z)} pairs apart: rms z {np.sqrt((z**2).mean()):.2f}, largest {abs(z).max():.2f}")


if __name__ == "__main__":
    main()
