"""Time to 5, 2 and 1 % error of a picture of the Cornell box, beside Mitsuba 3 and this engine's own path tracer.

    python benchmarks/pictures.py [--rounds 2] [--threads 2] [--only radiosity mitsuba] [--quick]

The reference is Mitsuba's, made on first use (some minutes) and kept in benchmarks/.peers. Every tool runs in a process
of its own, all in turn in each round, so that a drift of the machine meets them alike.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

from cornell import (
    HERE,
    LEVELS,
    PEERS_PYTHON,
    Ladder,
    Tool,
    cell,
    levels,
    measure,
    measurements,
)
from ladder import table, time_to_error
from machine import describe
from peers.view import REFERENCE

OURS = "radiosity gather"
SAMPLES = 32768

TOOLS = (
    Tool(OURS, Path(sys.executable), ("engine_picture", "--method=gather"), 2),
    Tool("radiosity smooth", Path(sys.executable), ("engine_picture", "--method=smooth"), 2),
    Tool("radiosity's path tracer", Path(sys.executable), ("engine_picture", "--method=path"), 1),
    Tool("mitsuba", PEERS_PYTHON, ("peers.peer_mitsuba_picture",), 1),
)


def main() -> None:
    """Run the tools and print the tables."""
    args = arguments()
    machine = describe()
    print(machine, end="\n\n", flush=True)
    if not REFERENCE.exists():
        make_reference()
    ladders, reasons = measure(args)
    print(measurements(ladders), end="\n\n")
    print(times(ladders))
    for name, reason in reasons.items():
        print(f"\n{name}: not available: {reason}")
    print(f"\n{describe()}")


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Time to error of a picture of the Cornell box")
    names = {"radiosity": TOOLS[:2], "path": TOOLS[2:3], "mitsuba": TOOLS[3:]}
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--only", nargs="+", choices=names, default=list(names), metavar="TOOL")
    parser.add_argument("--quick", action="store_true", help="one round, one repetition")
    args = parser.parse_args()
    args.rounds = 1 if args.quick else args.rounds
    args.tools = [tool for name in names if name in args.only for tool in names[name]]
    return args


def make_reference() -> None:
    """Have Mitsuba draw what all are held to."""
    print(f"drawing the reference with {SAMPLES:,} samples a pixel", file=sys.stderr, flush=True)
    command = [str(PEERS_PYTHON), "-m", "peers.peer_mitsuba_picture", f"--reference={SAMPLES}"]
    try:
        subprocess.run(command, cwd=HERE, check=True)
    except (FileNotFoundError, subprocess.CalledProcessError) as reason:
        raise SystemExit(f"the reference needs Mitsuba: run benchmarks/peers/setup.sh first ({reason})") from None


def times(ladders: dict[str, Ladder]) -> str:
    """Seconds at each level, and how many times longer than this engine."""
    reached = {name: [time_to_error(ladder, level) for level in LEVELS] for name, ladder in ladders.items()}
    rows = [["seconds to error", name, *map(cell, found)] for name, found in reached.items()]
    ours = reached.get(OURS, [None] * len(LEVELS))
    for name, found in reached.items():
        if name != OURS:
            ratios = [
                f"{t.seconds / own.seconds:.1f}" if t and own else "-" for t, own in zip(found, ours, strict=True)
            ]
            rows.append(["times ours", name, *ratios])
    return table(["", "tool", *levels()], rows)


if __name__ == "__main__":
    main()
