"""What commands leave behind: files that are whole or not there, JSON, a last word about accuracy."""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from radiosity.cli import interrupt
from radiosity.cli.failure import ExitCode, Stop, bad_argument

if TYPE_CHECKING:
    from radiosity import Finding, Report, Solution

_REMEDIES = {
    "max_rays": "the most rays per patch were spent; raise --max-rays",
    "patch_size": "light varies too much within patches; give more with --patches or --max-edge",
    "time": "the time was up; raise --time-limit",
    "max_patches": "the mesh has as many patches as it may; raise --max-patches",
    "memory": "more samples would not fit the memory; raise --memory or give fewer patches",
    "tolerance": "blocks get no more exact; use --transport sampled, or fewer patches",
    "solver": "the solver did not converge; raise --max-iterations or use another --solver",
    "hemicubes": "the most hemicubes per patch were drawn; give more patches with --patches or use another --solver",
}

_STYLES = {"error": "bold red", "warning": "yellow", "note": "cyan"}


def check_outputs(paths: Sequence[Path], suffixes: Sequence[str], source: str = "") -> None:
    """Refuse before any work what could not be written after it.

    Raises:
        Stop: an unknown suffix, a folder that is not there or not writable, or a file that would overwrite its source.
    """
    for path in paths:
        if path.suffix.lower() not in suffixes:
            raise bad_argument(f"{path}: name a file that ends in {' or '.join(suffixes)}")
        if path.is_dir():
            raise bad_argument(f"{path}: this is a directory; name a file")
        if not path.parent.is_dir():
            raise bad_argument(f"{path}: the folder {path.parent} does not exist; create it or write elsewhere")
        if not os.access(path.parent, os.W_OK):
            raise bad_argument(f"{path}: the folder {path.parent} cannot be written to; write elsewhere")
        if source and path.exists() and Path(source).exists() and path.samefile(source):
            raise bad_argument(f"{path}: this would overwrite the file it is made from; name another one")


def save(solution: Solution, paths: Sequence[Path]) -> None:
    """Write a solution in every form asked for."""
    for path in paths:
        with interrupt.writing(), naming_file(path):
            solution.save(path)


@contextmanager
def naming_file(path: Path) -> Iterator[None]:
    """Have errors of the system name the file that the user knows, not a temporary one."""
    try:
        yield
    except OSError as error:
        reason = os.strerror(error.errno) if error.errno else str(error).removeprefix(f"{path}: ")
        raise OSError(error.errno, reason, str(path)) from error


def print_json(content: Mapping[str, Any]) -> None:
    """One JSON object on stdout; what is not finite becomes null."""
    print(json.dumps(_plain(content), indent=2, ensure_ascii=False, allow_nan=False))


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return str(value) if isinstance(value, Path) else value


def findings_out(findings: Sequence[Finding]) -> list[dict[str, Any]]:
    """Findings for JSON, with their places as lists."""
    arrays = ("faces", "edges", "points")
    return [asdict(finding) | {name: getattr(finding, name).tolist() for name in arrays} for finding in findings]


def show_findings(findings: Sequence[Finding]) -> None:
    """A line for each finding, its severity in colour."""
    from rich.console import Console
    from rich.text import Text

    console = Console(highlight=False, soft_wrap=True)
    for finding in findings:
        where = f"{finding.element}: " if finding.element else ""
        console.print(
            Text(finding.severity, _STYLES[finding.severity]), Text(f"[{finding.code}] {where}{finding.message}")
        )


def warn_of_findings(file: str, findings: Sequence[Finding]) -> None:
    """One line on stderr if the scene has anything doubtful about it."""
    doubtful = [f for f in findings if f.severity == "warning"]
    if doubtful:
        more = f" (and {len(doubtful) - 1} more)" if len(doubtful) > 1 else ""
        where = f"{doubtful[0].element}: " if doubtful[0].element else ""
        print(
            f"radiosity: {file}: {where}{doubtful[0].message}{more}; radiosity check {file} lists all", file=sys.stderr
        )


def demand_accuracy(file: str, report: Report) -> None:
    """End the command with its own exit code if the accuracy was not reached.

    Raises:
        Stop: it was not.
    """
    if not report.reached:
        remedy = _REMEDIES.get(report.limited_by, report.limited_by)
        raise Stop(
            ExitCode.ACCURACY,
            f"{file}: the estimated error is {report.estimated_error:.3g}, not {report.accuracy:.3g}: {remedy}",
        )
