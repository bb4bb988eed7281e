"""``radiosity factors --compare``: all methods on one scene, side by side."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from radiosity.cli import output, source
from radiosity.cli.failure import ExitCode, Stop
from radiosity.cli.progress import Bar

if TYPE_CHECKING:
    from radiosity import FormFactors, Patches
    from radiosity.factors import Method

MOST_PATCHES = 3000
"""More than these are not compared unless asked for: every pair is integrated several times."""

TIGHTER = 100
"""How much smaller the tolerance of the reference is."""

WIDTH = 80
"""Columns that the table may take in any case."""

_COUNTS = {"nusselt": ("points",), "hemicube": ("resolution", "hemicubes"), "monte_carlo": ("rays",)}


@dataclass(frozen=True)
class Row:
    """How one method did.

    ``off_closure`` is the greatest distance of a row sum from 1, ``row_sum_difference`` from the reference's. ``rms``
    and ``worst`` are differences of form factors from the reference, ``rms`` over those that either has above zero.
    """

    method: str
    settings: str
    seconds: float
    memory_bytes: int
    estimated_error: float
    off_closure: float
    row_sum_difference: float
    rms: float
    worst: float
    disagreement: float


def compare(
    file: str,
    patches: Patches,
    settings: dict[str, Any],
    *,
    max_patches: int = MOST_PATCHES,
    enclosure: bool | None,
    as_json: bool,
    quiet: bool,
) -> None:
    """Run all methods and show what they took and how far they are from the best of them.

    Raises:
        Stop: there are more patches than ``max_patches``. ResourceError: one method does not fit the memory.
    """
    from radiosity import diagnosis
    from radiosity.factors import SINGLE_METHODS

    if len(patches) > max_patches:
        raise Stop(
            ExitCode.RESOURCES,
            f"{file}: to compare all methods on {len(patches):,} patches takes long: cut less finely, or allow it with "
            f"--max-patches {len(patches)}",
        )
    tolerance = _tolerance(settings)
    found = {method: _measured(file, patches, _settings_of(method, settings), quiet) for method in SINGLE_METHODS}
    is_open = not found["auto"].report.pairs_partly_hidden
    tight = {"method": "contour" if is_open else "auto", "tolerance": tolerance / TIGHTER}
    reference = _measured(file, patches, _common(settings) | tight, quiet, "reference")
    name = f"{reference.report.method} to {tolerance / TIGHTER:.0e}"
    rows = [_row(f, reference, settings) for f in found.values()]
    closed = diagnosis.is_enclosure(reference) if enclosure is None else enclosure
    if as_json:
        about = {"name": name, **reference.report.to_dict()}
        content = {"scene": file, "patches": len(patches), "enclosure": closed, "reference": about}
        output.print_json({**content, "methods": [asdict(row) for row in rows]})
    elif not quiet:
        _show(file, patches, rows, reference, name, closed=closed)


def _tolerance(settings: dict[str, Any]) -> float:
    from radiosity.factors import DEFAULT_TOLERANCE

    return settings["tolerance"] or DEFAULT_TOLERANCE


def _common(settings: dict[str, Any]) -> dict[str, Any]:
    """What every method takes."""
    return {name: settings[name] for name in ("memory_limit", "threads", "seed")}


def _settings_of(method: Method, settings: dict[str, Any]) -> dict[str, Any]:
    """What one method takes: the counts of its own or the tolerance."""
    own = _COUNTS.get(method, ("tolerance",))
    return {"method": method, **_common(settings), **{name: settings[name] for name in own}}


def _measured(file: str, patches: Patches, settings: dict[str, Any], quiet: bool, label: str = "") -> FormFactors:
    import radiosity

    with source.naming(file, patches.scene.name), Bar(label or settings["method"], quiet=quiet) as bar:
        return radiosity.form_factors(patches, **settings, progress=bar)


def _row(f: FormFactors, reference: FormFactors, settings: dict[str, Any]) -> Row:
    import numpy as np

    difference = abs((f.to_scipy_sparse() - reference.to_scipy_sparse()).data)
    closure = f.closure()
    return Row(
        method=f.report.method,
        settings=_words(f, settings),
        seconds=f.report.seconds,
        memory_bytes=f.report.memory_bytes,
        estimated_error=f.report.estimated_error,
        off_closure=float(np.max(abs(closure - 1))),
        row_sum_difference=float(np.max(abs(closure - reference.closure()))),
        rms=float(np.sqrt(np.mean(difference**2))) if len(difference) else 0.0,
        worst=float(difference.max(initial=0.0)),
        disagreement=f.report.disagreement,
    )


def _words(f: FormFactors, settings: dict[str, Any]) -> str:
    """The settings of a method in words."""
    from radiosity.factors import DEFAULT_RESOLUTION

    report = f.report
    if report.method == "monte_carlo":
        return f"{report.samples:,} rays"
    if report.method == "nusselt":
        return f"{report.samples:,} points"
    if report.method == "hemicube":
        pixels = f"{settings['resolution'] or DEFAULT_RESOLUTION:,} px"
        return f"{report.samples:,} x {pixels}" if report.samples > 1 else pixels
    return f"to {report.tolerance:.0e}"


def _show(file: str, patches: Patches, rows: list[Row], reference: FormFactors, name: str, *, closed: bool) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, pad_edge=False, padding=(0, 1, 0, 0))
    for heading in ("method", "settings"):
        table.add_column(heading, no_wrap=True)
    for heading in ("time", "memory", "sums", "ends", "estimate", "rms", "worst"):
        table.add_column(heading, justify="right", no_wrap=True)
    for row in rows:
        off = row.off_closure if closed else row.row_sum_difference
        numbers = (off, row.disagreement, row.estimated_error, row.rms, row.worst)
        cells = [f"{number:.1e}" if number else "0" for number in numbers]
        table.add_row(row.method, row.settings, f"{row.seconds:.2f} s", _size(row.memory_bytes), *cells)
    console = Console(highlight=False, soft_wrap=True)
    console.width = max(console.width, WIDTH)
    print(f"{file}: {len(patches):,} patches\n")
    console.print(table)
    against = "1" if closed else "the reference's"
    print(f"\nsums        worst distance of a row sum from {against}")
    print("ends        greatest difference of what both ends of a pair measured")
    print("estimate    greatest error of a form factor as the method itself estimates it")
    print("rms, worst  difference of form factors from the reference")
    print(f"reference   {name}: {reference.report.seconds:.2f} s")
    if reference.report.unresolved:
        print(f"            {reference.report.unresolved:,} of its pairs are less exact than that")


def _size(count: int) -> str:
    """Bytes in a readable unit."""
    return f"{count / 1e6:.1f} MB" if count >= 1e5 else f"{count / 1e3:.1f} kB"
