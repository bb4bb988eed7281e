"""From measured (seconds, error) points to the time at which a tool reaches an error."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import exp, log


@dataclass(frozen=True)
class Rung:
    """What one setting of one tool took and reached."""

    settings: str
    seconds: float
    cpu_seconds: float  # of all threads; far below threads * seconds on a busy machine
    error: float  # true, relative RMS
    estimated: float | None = None  # what the tool itself said, if it says
    solve_seconds: float | None = None  # the part spent in the solver, if told apart


@dataclass(frozen=True)
class TimeToError:
    """Seconds to reach an error; ``bound`` says that even the cheapest setting was better."""

    seconds: float
    bound: bool = False

    def __str__(self) -> str:
        """Three figures, with a sign when it is only an upper bound."""
        return f"{'<= ' if self.bound else ''}{self.seconds:.3g}"


def time_to_error(rungs: Iterable[Rung], error: float) -> TimeToError | None:
    """Interpolate log-log between the rungs at which the error is first crossed.

    None if no rung is that good; nothing is extrapolated.

    >>> ladder = [Rung("a", 1, 2, 0.04), Rung("b", 4, 8, 0.02), Rung("c", 16, 32, 0.01)]
    >>> print(time_to_error(ladder, 0.02), time_to_error(ladder, 0.04 / 2**1.5))
    4 8
    >>> print(time_to_error(ladder, 0.05), time_to_error(ladder, 0.005))
    <= 1 None
    """
    before: Rung | None = None
    for rung in sorted(rungs, key=lambda r: r.seconds):
        if rung.error <= error:
            return _between(before, rung, error) if before else TimeToError(rung.seconds, True)
        before = rung
    return None


def _between(worse: Rung, better: Rung, error: float) -> TimeToError:
    share = log(worse.error / error) / log(worse.error / better.error)
    return TimeToError(exp(log(worse.seconds) + share * log(better.seconds / worse.seconds)))


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Text columns: the first two left-aligned, the others right-aligned.

    >>> print(table(["tool", "settings", "s"], [["a", "spp 4", "10.5"]]))
    tool  settings     s
    a     spp 4     10.5
    """
    lines = [list(header), *(list(r) for r in rows)]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    return "\n".join(
        "  ".join(
            cell.ljust(width) if k < 2 else cell.rjust(width)
            for k, (cell, width) in enumerate(zip(line, widths, strict=True))
        ).rstrip()
        for line in lines
    )
