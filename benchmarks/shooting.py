"""Shooting into large scenes: how many rays, how long, how much memory, and how wrong.

    python benchmarks/shooting.py [--scene city|crater] [--patches 1000000] [--accuracy 0.02] [--threads 2]

The reference is a solution of the same patches with other random numbers and a third of the error
asked for. Each solve runs in a process of its own, so that peak memory is its own; it holds scene,
patches and the ray hierarchy too. What cutting patches coarsely does to both is not seen.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

import radiosity
from machine import describe
from scale import peak_mib


def main() -> None:
    """Measure, or start the processes that do and print what they say."""
    args = arguments()
    if args.child is not None:
        print(json.dumps(measure(args, args.child)))
        return
    print(describe(), end="\n\n", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        rough = in_process(args, args.accuracy, 1, Path(folder) / "rough.npy")
        print(lines(rough), flush=True)
        if not args.no_reference:
            fine = in_process(args, args.accuracy / 3, 2, Path(folder) / "fine.npy")
            report_difference(rough, fine, Path(folder))


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Shooting into large scenes")
    parser.add_argument("--scene", choices=["city", "crater"], default="city")
    parser.add_argument("--patches", type=int, default=1_000_000)
    parser.add_argument("--accuracy", type=float, default=0.02)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--no-reference", action="store_true", help="leave out the long run")
    parser.add_argument("--child", help=argparse.SUPPRESS)
    return parser.parse_args()


def patches(scene: str, count: int) -> radiosity.Patches:
    """A city of 256 blocks cut into patches, or terrain as it is."""
    if scene == "crater":
        return radiosity.scenes.crater(count).patches(as_is=True)
    return radiosity.scenes.city(16).patches(count=count)


def in_process(args: argparse.Namespace, accuracy: float, seed: int, output: Path) -> dict[str, Any]:
    """Measure one solve in a process of its own."""
    flags = [f"--scene={args.scene}", f"--patches={args.patches}", f"--threads={args.threads}"]
    command = [sys.executable, __file__, *flags, f"--accuracy={accuracy}", f"--seed={seed}", f"--child={output}"]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"exit status {done.returncode}")
    result: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return result


def measure(args: argparse.Namespace, output: str) -> dict[str, Any]:
    """Make the scene, solve it, and leave areas and irradiance in a file."""
    start = perf_counter()
    surface = patches(args.scene, args.patches)
    made = perf_counter()
    solution = radiosity.solve(
        surface, solver="shooting", accuracy=args.accuracy, seed=args.seed, threads=args.threads, max_rays=1 << 20
    )
    solved = perf_counter()
    np.save(output, np.column_stack([surface.area, solution.irradiance]))
    report = solution.report.to_dict()
    return report | {"making": made - start, "solving": solved - made, "peak_mib": peak_mib()}


def lines(r: dict[str, Any]) -> str:
    """What a solve took and reached."""
    rays = (r["rays"] + r["shadow_rays"]) / 1e6
    return "\n".join(
        [
            f"patches          {r['patches']:,}",
            f"made in          {r['making']:.1f} s, solved in {r['solving']:.1f} s",
            f"rays             {rays:.0f} million, {rays / r['sampling_seconds']:.2f} million a second",
            f"peak memory      {r['peak_mib']:.0f} MiB",
            f"estimated error  {r['estimated_error']:.2%}: {r['sampling_error']:.2%} by rays, "
            f"{r['discretisation_error']:.2%} by patches; asked for {r['accuracy']:.2%}",
            f"imbalance        {r['imbalance']:.1e}",
        ]
    )


def report_difference(rough: dict[str, Any], fine: dict[str, Any], folder: Path) -> None:
    """Print how far the two are apart and how far they should be."""
    (area, *a), (_, *b) = (np.load(folder / name).T for name in ("rough.npy", "fine.npy"))
    square = np.average(np.mean((np.array(a) - np.array(b)) ** 2, axis=0), weights=area)
    difference = np.sqrt(square) / np.average(np.mean(b, axis=0), weights=area)
    expected = np.hypot(rough["sampling_error"], fine["sampling_error"])
    print(
        f"reference        {fine['rays'] / 1e6:.0f} million rays, estimated error by rays {fine['sampling_error']:.2%}"
    )
    print(f"difference       {difference:.2%}; the two errors by rays make {expected:.2%}")


if __name__ == "__main__":
    main()
