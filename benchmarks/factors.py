"""View factors beside other programs: time, memory and error on the same scenes, one process each.

    python benchmarks/factors.py [--scene cube-600 room ...] [--only radiosity view3d ...] [--limit SECONDS]
    python benchmarks/factors.py --tolerance 1e-3 1e-4 --json out/factors.json
    python benchmarks/factors.py --rays 4096            # this engine by rays

A program that is not installed is reported and the others still run; one that takes longer than the limit is ended and
reported as over it.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from factor_scenes import SCENES, Scene, scene
from ladder import table
from machine import describe
from peers.reference import REPOSITORY

HERE = Path(__file__).resolve().parent
PEERS_PYTHON = HERE / ".peers" / "bin" / "python"
SAMPLES = HERE / ".peers" / "factors"  # exact values of pairs, computed once
REFERENCES = {"rough-2048": "rough_crater_pairs.npz", "room": "room_with_box_pairs.npz"}
OURS = "radiosity"
SMALL = 1e-5  # relative errors are taken of factors from here up, if the truth is itself measured
BLOCK = 500  # rows compared at a time

Array = NDArray[np.floating]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Tool:
    """A program and the ways in which it is run."""

    name: str
    python: Path
    module: str
    settings: tuple[tuple[str, ...], ...] = ((),)


PEERS = (
    Tool("view3d", Path(sys.executable), "peers.peer_view3d", (("--eps=1e-4",),)),
    Tool("pyviewfactor", PEERS_PYTHON, "peers.peer_pyviewfactor"),
    Tool("raystrack", PEERS_PYTHON, "peers.peer_raystrack", (("--rays=16384",),)),
)


@dataclass(frozen=True)
class Row:
    """One program on one scene."""

    scene: str
    tool: str
    settings: str
    seconds: float
    process_seconds: float  # with start-up, files and whatever is compiled on the way
    megabytes: float
    rms: float  # of F - truth
    relative: float  # worst |F - truth| / truth
    row_sum: float  # worst |row sum - 1|; of open scenes the most by which a row exceeds 1
    kinds: dict[str, tuple[float, float]]  # rms and worst relative error of the reference pairs, by kind


@dataclass(frozen=True)
class Truth:
    """What F is held to: all of it, or the values of some pairs."""

    everything: Array | None
    pairs: Ints
    values: Array


class UnavailableError(Exception):
    """Why a program gave no numbers."""


def main() -> None:
    """Run the programs on the scenes and print a table for each."""
    args = arguments()
    machine = describe()
    print(machine, end="\n\n", flush=True)
    rows: list[Row] = []
    reasons: list[dict[str, str]] = []
    for name in args.scene:
        found = list(measure(name, args, reasons))
        rows += found
        print(f"{name}\n\n{results(found)}\n", flush=True)
        if any(row.kinds for row in found):
            print(f"{name}, reference pairs: rms error and worst relative error\n\n{by_kind(found)}\n", flush=True)
        for reason in (r for r in reasons if r["scene"] == name):
            print(f"{reason['tool']}: {reason['reason']}", flush=True)
        print(flush=True)
    print(describe())
    if args.json:
        args.json.parent.mkdir(parents=True, exist_ok=True)
        record = {"machine": machine, "rows": [asdict(r) for r in rows], "not_available": reasons}
        args.json.write_text(json.dumps(record, indent=1) + "\n")


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="View factors beside other programs")
    names = [OURS, *(tool.name for tool in PEERS)]
    parser.add_argument("--scene", nargs="+", choices=SCENES, default=list(SCENES), metavar="NAME")
    parser.add_argument("--only", nargs="+", choices=names, default=names, metavar="TOOL")
    parser.add_argument("--limit", type=float, default=180, help="seconds a program may take")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--tolerance", type=float, nargs="+", default=[1e-3, 1e-4], help="of this engine")
    parser.add_argument("--rays", type=int, nargs="+", help="of this engine, instead of tolerances")
    parser.add_argument("--json", type=Path, help="also write the numbers to this file")
    args = parser.parse_args()
    ways = [f"--rays={r}" for r in args.rays] if args.rays else [f"--tolerance={t}" for t in args.tolerance]
    engine = Tool(OURS, Path(sys.executable), "engine_factors", tuple((way,) for way in ways))
    args.tools = [tool for tool in (engine, *PEERS) if tool.name in args.only]
    return args


def measure(name: str, args: argparse.Namespace, reasons: list[dict[str, str]]) -> Iterator[Row]:
    """Every program in every way on one scene; why not, goes to ``reasons``."""
    of = scene(name)
    truth = truth_of(of)
    for tool in args.tools:
        for way in tool.settings:
            print(f"{name}: {tool.name} {' '.join(way)}", file=sys.stderr, flush=True)
            try:
                yield run(tool, way, of, truth, args)
            except UnavailableError as reason:
                words = " ".join([tool.name, *way])
                reasons.append({"scene": name, "tool": words, "reason": str(reason)})


def truth_of(of: Scene) -> Truth:
    """The closed form, or exact values of a sample of pairs, which are computed at first and kept."""
    if of.truth is not None:
        return Truth(of.truth(), np.zeros((0, 2), np.int64), np.zeros(0))
    path = SAMPLES / f"{of.name}.npz"
    if not path.exists() and PEERS_PYTHON.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        print(f"{of.name}: exact values of a sample of pairs, once", file=sys.stderr, flush=True)
        subprocess.run([PEERS_PYTHON, "-m", "peers.exact", of.name, path], cwd=HERE, check=True)
    if not path.exists():
        raise SystemExit("the truth of this scene needs benchmarks/peers/setup.sh view-factors first")
    with np.load(path) as arrays:
        return Truth(None, arrays["pairs"], arrays["factor"])


def run(tool: Tool, way: tuple[str, ...], of: Scene, truth: Truth, args: argparse.Namespace) -> Row:
    """One program in a process of its own, and the errors of what it wrote."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder, "factors.npy")
        command = [str(tool.python), "-m", tool.module, of.name, str(out), f"--threads={args.threads}", *way]
        start = perf_counter()
        said = said_by(command, args.limit)
        process_seconds = perf_counter() - start
        factors = np.load(out, mmap_mode="r")
        rms, relative = errors(factors, truth)
        return Row(
            scene=of.name,
            tool=tool.name,
            settings=said["settings"],
            seconds=said["seconds"],
            process_seconds=process_seconds,
            megabytes=said["peak"] / 2**20,
            rms=rms,
            relative=relative,
            row_sum=row_sum(factors, of.closed),
            kinds=reference_errors(factors, of.name),
        )


def said_by(command: list[str], limit: float) -> dict:
    """The JSON line of a program; past the limit it is ended with all that it started."""
    options = {"cwd": HERE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    try:
        process = subprocess.Popen(command, start_new_session=True, **options)
    except FileNotFoundError:
        raise UnavailableError("not available: run benchmarks/peers/setup.sh view-factors first") from None
    try:
        output, errors_said = process.communicate(timeout=limit)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        raise UnavailableError(f"over {limit:g} s") from None
    lines = [json.loads(s) for s in output.splitlines() if s.startswith("{")]
    if process.returncode != 0 or not lines:
        last = next((s.strip() for s in reversed(errors_said.splitlines()) if s.strip()), "")
        raise UnavailableError(f"not available: {last or f'exit status {process.returncode}'}")
    return lines[-1]


def errors(factors: Array, truth: Truth) -> tuple[float, float]:
    """RMS error and worst relative error."""
    if truth.everything is None:
        return errors_of(factors[tuple(truth.pairs.T)], truth.values, SMALL)
    square, count, worst = 0.0, 0, 0.0
    for rows in blocks(len(factors)):
        known = np.isfinite(truth.everything[rows])
        rms, relative = errors_of(factors[rows][known], truth.everything[rows][known], 0.0)
        square += rms**2 * known.sum()
        count += known.sum()
        worst = max(worst, relative)
    return float(np.sqrt(square / count)), worst


def errors_of(found: Array, true: Array, small: float) -> tuple[float, float]:
    """RMS error, and worst relative error of factors above ``small``."""
    if not true.size:
        return 0.0, 0.0
    error = np.asarray(found, float) - true
    counted = true > small
    relative = np.abs(error[counted]) / true[counted]
    return float(np.sqrt((error**2).mean())), float(relative.max(initial=0))


def row_sum(factors: Array, closed: bool) -> float:
    """Worst row sum."""
    off = np.concatenate([factors[rows].sum(axis=1, dtype=float) - 1 for rows in blocks(len(factors))])
    return float(np.abs(off).max() if closed else max(off.max(), 0))


def blocks(n: int) -> list[slice]:
    """Rows, a number at a time."""
    return [slice(k, k + BLOCK) for k in range(0, n, BLOCK)]


def reference_errors(factors: Array, name: str) -> dict[str, tuple[float, float]]:
    """RMS error and worst relative error of the reference pairs of each kind."""
    if name not in REFERENCES:
        return {}
    with np.load(REPOSITORY / "validation" / "references" / REFERENCES[name]) as arrays:
        pairs, values, kind = arrays["pairs"], arrays["factor"], arrays["kind"]
    found = factors[tuple(pairs.T)]
    return {str(k): errors_of(found[kind == k], values[kind == k], SMALL) for k in dict.fromkeys(kind.tolist())}


def results(rows: list[Row]) -> str:
    """The table of one scene."""
    header = ["tool", "settings", "seconds", "process s", "MiB", "rms error", "worst rel.", "row sum", "times ours"]
    body = [
        [
            row.tool,
            row.settings,
            f"{row.seconds:.3g}",
            f"{row.process_seconds:.3g}",
            f"{row.megabytes:.0f}",
            f"{row.rms:.1e}",
            f"{row.relative:.1e}",
            f"{row.row_sum:.1e}",
            ratio(row, rows),
        ]
        for row in rows
    ]
    return table(header, body)


def ratio(row: Row, rows: list[Row]) -> str:
    """Time over that of this engine's fastest setting that is at least as good in the rms."""
    good = [r.seconds for r in rows if r.tool == OURS and r.rms <= row.rms]
    return f"{row.seconds / min(good):.3g}" if good and row.tool != OURS else ""


def by_kind(rows: list[Row]) -> str:
    """The reference pairs, by kind."""
    kinds = list(rows[0].kinds)
    body = [[row.tool, row.settings, *(f"{row.kinds[k][0]:.1e}, {row.kinds[k][1]:.1e}" for k in kinds)] for row in rows]
    return table(["tool", "settings", *kinds], body)


if __name__ == "__main__":
    main()
