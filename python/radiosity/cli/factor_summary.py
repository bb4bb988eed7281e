"""What ``radiosity factors`` says of form factors."""

from __future__ import annotations

import shutil
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from radiosity.cli import output

if TYPE_CHECKING:
    from radiosity import Finding, FormFactors, Scene, SurfaceFactors
    from radiosity.diagnosis import Place

MOST_SHOWN = 20
"""A table of factors between surfaces has so many lines at most."""


@dataclass(frozen=True)
class Summary:
    """What is said of form factors, as JSON or as lines."""

    factors: FormFactors
    surfaces: SurfaceFactors | None
    entries: int
    closure: tuple[float, float, float]
    """Least, mean by area and greatest row sum."""
    farthest: Place
    enclosure: bool
    findings: list[Finding]
    file: str

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        least, mean, greatest = self.closure
        content: dict[str, Any] = {
            "patches": len(self.factors.patches),
            "rows": self.factors.shape[0],
            "entries": self.entries,
            "report": self.factors.report.to_dict(),
            "closure_min": least,
            "closure_mean": mean,
            "closure_max": greatest,
            "farthest_from_closure": asdict(self.farthest),
            "enclosure": self.enclosure,
            "findings": output.findings_out(self.findings),
        }
        if self.surfaces is not None:
            s = self.surfaces
            content["surfaces"] = {"names": s.names, "area": s.area.tolist(), "F": s.F.tolist()}
        return content

    def show(self) -> None:
        """For people."""
        n, rows = len(self.factors.patches), self.factors.shape[0]
        sides = f" with {rows:,} sides" if rows != n else ""
        print(f"{self.file}: {n:,} patches{sides}, {self.entries:,} form factors above zero")
        print(self.factors.report)
        least, mean, greatest = self.closure
        print(f"{'row sums':<18}{least:.6f} to {greatest:.6f}, mean by area {mean:.6f}")
        sum_there = self.farthest.row_sum
        off = f" ({abs(sum_there - 1):.2g} off)" if self.enclosure else ""
        print(f"{'farthest from 1':<18}{self.farthest}: {sum_there:.6f}{off}")
        if not self.enclosure:
            print(f"{'enclosure':<18}no, so that row sums are not held against 1 (--enclosure does it)")
        if self.surfaces is not None:
            self._show_surfaces(str(self.surfaces))
        output.show_findings(self.findings)

    def _show_surfaces(self, table: str) -> None:
        """The factors between surfaces where there is room for them."""
        lines = table.splitlines()
        if len(lines) <= MOST_SHOWN and len(lines[0]) <= shutil.get_terminal_size().columns:
            print(f"\n{table}\n")
        else:
            print(f"{'surfaces':<18}{len(lines) - 1:,}, too many to be shown here")


def summarise(file: str, f: FormFactors, surfaces: SurfaceFactors | None, enclosure: bool | None) -> Summary:
    """What is to be said; ``surfaces`` if factors between them were wanted, ``enclosure`` if the user knows."""
    from radiosity import diagnosis

    closure = f.closure()
    sums = float(closure.min()), diagnosis.mean_closure(f), float(closure.max())
    closed = diagnosis.is_enclosure(f) if enclosure is None else enclosure
    findings = diagnosis.of(f, enclosure=enclosure) + _unused_hints(f.patches.scene)
    entries = f.count()
    return Summary(f, surfaces, entries, sums, diagnosis.farthest(f), closed, findings, file)


def _unused_hints(scene: Scene) -> list[Finding]:
    """What the file asks of the computation that is left to the options."""
    from radiosity import Finding

    found = []
    if "tolerance" in scene.hints:
        eps = scene.hints["tolerance"]
        message = f"eps={eps:g} says when View3D stops refining, not how wrong a factor may be: see --tolerance"
        found.append(Finding("note", "unused-hint", "", message))
    if scene.hints.get("emissivity"):
        message = "emit=1 asks for factors with reflections; these are without"
        found.append(Finding("note", "unused-hint", "", message))
    if "row" in scene.hints or "column" in scene.hints:
        found.append(Finding("note", "unused-hint", "", "row= and col= are not used: all factors are measured"))
    return found
