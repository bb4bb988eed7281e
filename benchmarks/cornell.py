"""Time to 5, 2 and 1 % relative RMS error on the Cornell reference, beside other renderers.

    python benchmarks/cornell.py [--rounds 2] [--threads 2] [--only radiosity bake] [--json FILE]
    python benchmarks/cornell.py --quick

Every tool runs in a process of its own, all in turn in each round, so that a drift of the machine
meets them alike. A tool that is not installed is reported and the others still run.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections import defaultdict
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import mean, median

from ladder import Rung, TimeToError, table, time_to_error
from machine import describe

HERE = Path(__file__).resolve().parent
PEERS_PYTHON = HERE / ".peers" / "bin" / "python"
LEVELS = (0.05, 0.02, 0.01)
OURS = "radiosity"

Ladder = list[Rung]


@dataclass(frozen=True)
class Tool:
    """A program that prints one JSON line per rung."""

    name: str
    python: Path
    module: tuple[str, ...]
    repetitions: int
    any_mesh: bool = True

    def command(self, args: argparse.Namespace, seed: int) -> list[str]:
        """The command line of one round."""
        repetitions = 1 if args.quick else self.repetitions
        options = {"repetitions": repetitions, "threads": args.threads, "seed": seed}
        flags = [f"--{name}={value}" for name, value in options.items()]
        return [str(self.python), "-m", *self.module, *flags]


TOOLS = (
    Tool(OURS, Path(sys.executable), ("engine",), 4),
    Tool(
        "mitsuba ortho",
        PEERS_PYTHON,
        ("peers.peer_mitsuba", "--method=ortho"),
        2,
        any_mesh=False,
    ),
    Tool("mitsuba trace", PEERS_PYTHON, ("peers.peer_mitsuba", "--method=trace"), 2),
    Tool("cycles bake", PEERS_PYTHON, ("peers.peer_cycles", "--k=4"), 2),
)


class UnavailableError(Exception):
    """Why a tool gave no numbers."""


def main() -> None:
    """Run the tools and print the tables."""
    args = arguments()
    machine = describe()
    print(machine, end="\n\n", flush=True)
    ladders, reasons = measure(args)
    print(measurements(ladders), end="\n\n")
    print(times(ladders), end="\n\n")
    print(ratios(ladders))
    for name, reason in reasons.items():
        print(f"\n{name}: not available: {reason}")
    print(f"\n{describe()}")
    if args.json:
        save(args.json, machine, ladders, reasons)


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Time to error on the Cornell reference")
    names = [tool.name.split()[-1] for tool in TOOLS]
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--only", nargs="+", choices=names, default=names, metavar="TOOL")
    parser.add_argument("--quick", action="store_true", help="one round, one repetition")
    parser.add_argument("--json", type=Path, help="also write the numbers to this file")
    args = parser.parse_args()
    args.rounds = 1 if args.quick else args.rounds
    args.tools = [t for t in TOOLS if t.name.split()[-1] in args.only]
    return args


def measure(args: argparse.Namespace) -> tuple[dict[str, Ladder], dict[str, str]]:
    """The pooled ladder of each tool, and why the others have none."""
    rounds: dict[str, list[Rung]] = defaultdict(list)
    reasons: dict[str, str] = {}
    for seed in range(1, args.rounds + 1):
        for tool in args.tools:
            if tool.name in reasons:
                continue
            print(f"round {seed} of {args.rounds}: {tool.name}", file=sys.stderr, flush=True)
            try:
                rounds[tool.name] += run(tool.command(args, seed))
            except UnavailableError as reason:
                reasons[tool.name] = str(reason)
    return {name: pool(rungs) for name, rungs in rounds.items() if name not in reasons}, reasons


def run(command: list[str]) -> list[Rung]:
    """Run one tool and read its JSON lines; its other output is ignored."""
    try:
        done = subprocess.run(command, cwd=HERE, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        raise UnavailableError("run benchmarks/peers/setup.sh first") from None
    rungs = [Rung(**json.loads(s)) for s in done.stdout.splitlines() if s.startswith("{")]
    if done.returncode != 0 or not rungs:
        raise UnavailableError(last_line(done.stderr) or f"exit status {done.returncode}")
    return rungs


def last_line(text: str) -> str:
    """The last line that is not blank, where Python puts the message of an exception."""
    return next((s.strip() for s in reversed(text.splitlines()) if s.strip()), "")


def pool(rungs: Iterable[Rung]) -> Ladder:
    """One rung per setting: the median of the rounds' times, the mean of their errors."""
    by_settings: dict[str, list[Rung]] = defaultdict(list)
    for rung in rungs:
        by_settings[rung.settings].append(rung)
    return [
        Rung(
            settings=settings,
            seconds=median(r.seconds for r in same),
            cpu_seconds=median(r.cpu_seconds for r in same),
            error=mean(r.error for r in same),
            estimated=_pooled(mean, (r.estimated for r in same)),
            solve_seconds=_pooled(median, (r.solve_seconds for r in same)),
        )
        for settings, same in by_settings.items()
    ]


def _pooled(average: Callable[[list[float]], float], values: Iterable[float | None]) -> float | None:
    known = [v for v in values if v is not None]
    return average(known) if known else None


def measurements(ladders: dict[str, Ladder]) -> str:
    """Every rung of every tool."""
    header = ["tool", "settings", "seconds", "CPU s", "solve s", "error %", "estimated %"]
    rows = [
        [
            name,
            rung.settings,
            f"{rung.seconds:.3f}",
            f"{rung.cpu_seconds:.3f}",
            "" if rung.solve_seconds is None else f"{rung.solve_seconds:.3f}",
            percent(rung.error),
            percent(rung.estimated),
        ]
        for name, ladder in ladders.items()
        for rung in ladder
    ]
    return table(header, rows)


def percent(value: float | None) -> str:
    """A relative error as a percentage, blank if there is none."""
    return "" if value is None else f"{100 * value:.2f}"


def times(ladders: dict[str, Ladder]) -> str:
    """Seconds at each level, interpolated for all, and for this engine also as asked for."""
    rows = [
        [name, meshes(name), *(cell(time_to_error(ladder, level)) for level in LEVELS)]
        for name, ladder in ladders.items()
    ]
    if OURS in ladders:
        asked_for = [cell(asked(ladders[OURS], level)) for level in LEVELS]
        rows.append([f"{OURS}, as asked", meshes(OURS), *asked_for])
    return table(["seconds to error", "meshes", *levels()], rows)


def meshes(name: str) -> str:
    """What the tool's method works on."""
    return "any" if name in general() else "flat rectangles"


def general() -> set[str]:
    """The tools whose method works on any mesh."""
    return {tool.name for tool in TOOLS if tool.any_mesh}


def levels() -> list[str]:
    """The headings of the columns."""
    return [f"{100 * level:g} %" for level in LEVELS]


def cell(time: TimeToError | None) -> str:
    """A time, or a dash where the error was not reached."""
    return "-" if time is None else str(time)


def asked(ladder: Ladder, level: float) -> TimeToError | None:
    """The time taken when this accuracy was asked for, if the true error kept the promise."""
    for rung in ladder:
        if rung.settings == f"accuracy {level:g}" and rung.error <= level:
            return TimeToError(rung.seconds)
    return None


def ratios(ladders: dict[str, Ladder]) -> str:
    """How many times longer the best peer takes than this engine."""
    peers = {name: ladder for name, ladder in ladders.items() if name != OURS}
    groups = {"best peer": peers.keys(), "best peer for any mesh": peers.keys() & general()}
    ways = {"interpolated": time_to_error, "as asked": asked}
    rows = [
        [f"{group} / {OURS}", way, *(ratio(ladders, names, level, ours) for level in LEVELS)]
        for group, names in groups.items()
        for way, ours in ways.items()
    ]
    return table(["ratio of times", "ours", *levels()], rows)


def ratio(
    ladders: dict[str, Ladder],
    names: Iterable[str],
    level: float,
    ours: Callable[[Ladder, float], TimeToError | None],
) -> str:
    """The ratio at one level, with a sign where one of the times is only an upper bound."""
    reached = [t for name in names if (t := time_to_error(ladders[name], level))]
    mine = ours(ladders.get(OURS, []), level)
    if mine is None or not reached:
        return "-"
    best = min(reached, key=lambda t: t.seconds)
    sign = {(False, True): ">= ", (True, False): "<= ", (True, True): "~ "}
    prefix = sign.get((best.bound, mine.bound), "")
    return f"{prefix}{best.seconds / mine.seconds:.2f}"


def save(path: Path, machine: str, ladders: dict[str, Ladder], reasons: dict[str, str]) -> None:
    """Write what was measured as JSON."""
    numbers = {name: [asdict(rung) for rung in ladder] for name, ladder in ladders.items()}
    record = {"machine": machine, "ladders": numbers, "not_available": reasons}
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(record, indent=1) + "\n")


if __name__ == "__main__":
    main()
