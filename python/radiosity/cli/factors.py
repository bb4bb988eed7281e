"""``radiosity factors``."""

from __future__ import annotations

import shutil
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from radiosity.cli import compare, interrupt, options, output, source
from radiosity.cli.failure import ExitCode, Stop, bad_argument
from radiosity.cli.progress import Bar

if TYPE_CHECKING:
    from radiosity import Finding, FormFactors, Patches, Scene, SurfaceFactors
    from radiosity.diagnosis import Place

SUFFIXES = (".npz", ".csv")

FACES_ARE_PATCHES = (".stl", ".ply", ".vs3")
"""Files whose faces are the patches that their authors want factors between."""

MOST_SHOWN = 10
"""So many surfaces are shown as a table."""

By = Literal["patch", "surface"]

Outputs = Annotated[
    list[Path] | None,
    typer.Option("--output", "-o", metavar="FILE", help="Where to save: .npz or .csv; may be repeated."),
]
Method = Annotated[
    str, typer.Option(help="How they are found: auto, analytic, contour, nusselt, hemicube or monte_carlo.")
]
Tolerance = Annotated[
    float | None, typer.Option(metavar="T", help="Wanted error of a form factor; 1e-6 where nothing else is given.")
]
Rays = Annotated[int | None, typer.Option(min=1, metavar="N", help="Rays per patch, for monte_carlo.")]
Resolution = Annotated[
    int | None, typer.Option(min=1, metavar="R", help="Pixels along an edge of a hemicube, for hemicube.")
]
Hemicubes = Annotated[int | None, typer.Option(min=1, metavar="K", help="Hemicubes per patch, for hemicube.")]
Points = Annotated[int | None, typer.Option(min=1, metavar="N", help="Points per direction, for nusselt.")]
Between = Annotated[
    By | None,
    typer.Option("--by", help="Between patches or whole surfaces; surface for .vs3, else patch.", show_default=False),
]
AsIs = Annotated[
    bool, typer.Option("--as-is", help="One patch per face of the file; so by default for .stl, .ply and .vs3.")
]
TwoSided = Annotated[
    bool | None,
    typer.Option(
        "--two-sided/--one-sided",
        help="Whether backs take part, each a row of its own; as the file says by default, one-sided for .obj.",
        show_default=False,
    ),
]
Enclosure = Annotated[
    bool | None,
    typer.Option(
        "--enclosure/--no-enclosure",
        help="Whether rows should sum to 1; as the file says by default, or the row sums themselves.",
        show_default=False,
    ),
]
Compare = Annotated[bool, typer.Option("--compare", help="Run all methods and show them side by side; saves nothing.")]


@dataclass(frozen=True)
class Effort:
    """With what method, how accurately, and with what means."""

    method: str = "auto"
    tolerance: float | None = None
    rays: int | None = None
    resolution: int | None = None
    hemicubes: int | None = None
    points: int | None = None
    memory: str | None = None
    threads: int | None = None
    seed: int = 0

    def settings(self) -> dict[str, Any]:
        """Arguments of :func:`radiosity.form_factors`."""
        settings = asdict(self)
        memory = settings.pop("memory")
        return settings | {"memory_limit": None if memory is None else options.read_size(memory)}


def factors(
    file: options.SceneFile,
    outputs: Outputs = None,
    method: Method = "auto",
    tolerance: Tolerance = None,
    rays: Rays = None,
    resolution: Resolution = None,
    hemicubes: Hemicubes = None,
    points: Points = None,
    by: Between = None,
    compare_all: Compare = False,
    enclosure: Enclosure = None,
    max_edge: options.MaxEdge = None,
    patches: options.PatchCount = None,
    as_is: AsIs = False,
    max_patches: options.MaxPatches = None,
    memory: options.Memory = None,
    unit: options.Unit = None,
    two_sided: TwoSided = None,
    threads: options.Threads = None,
    seed: options.Seed = 0,
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
) -> None:
    """Measure the form factors between all patches of a scene, and say what they tell of its shapes.

    A saved .npz opens with scipy.sparse.load_npz; numpy.load shows area, centre, normal, surface, face and closure too.
    With --by surface its arrays are names, area and F.
    """
    targets = outputs or []
    output.check_outputs(targets, SUFFIXES, file)
    effort = Effort(method, tolerance, rays, resolution, hemicubes, points, memory, threads, seed)
    settings = effort.settings()
    source.use_threads(threads)
    if compare_all and (targets or method != "auto"):
        raise bad_argument("--compare runs all methods and saves nothing: leave out --method and --output")
    whole_faces = as_is or (max_edge is None and patches is None and Path(file).suffix.lower() in FACES_ARE_PATCHES)
    meshing = source.Meshing(max_edge, patches, whole_faces, max_patches)
    if compare_all:
        meshing = compare.within_reach(meshing)
    if two_sided is None and Path(file).suffix.lower() == ".obj":
        two_sided = False  # the format does not say, and backs double the rows
    scene = source.open_scene(file, unit=unit, two_sided=two_sided)
    elements = source.cut(file, scene, meshing)
    if compare_all:
        most = max_patches or compare.MOST_PATCHES
        compare.compare(file, elements, settings, max_patches=most, enclosure=enclosure, as_json=as_json, quiet=quiet)
        return
    f = measure(file, elements, settings, quiet=quiet)
    surfaces = f.by_surface() if (by or _usual(file)) == "surface" else None
    for target in targets:
        with interrupt.writing(), output.naming_file(target):
            (surfaces or f).save(target)
    told = _tell(file, f, surfaces, enclosure)
    if as_json:
        output.print_json({"scene": file, "outputs": targets, **told.to_dict()})
    elif not quiet:
        told.show()
        for target in targets:
            print(f"wrote {target}")
    _demand_tolerance(file, f, tolerance)


def measure(file: str, patches: Patches, settings: dict[str, Any], *, quiet: bool) -> FormFactors:
    """Measure with a progress bar.

    Raises:
        ResourceError: the form factors do not fit the memory. ValueError: the method takes no such settings.
    """
    import radiosity

    with source.naming(file, patches.scene.name), Bar("measuring", quiet=quiet) as bar:
        return radiosity.form_factors(patches, **settings, progress=bar)


def _usual(file: str) -> By:
    """What factors are wanted between: View3D's surfaces are what its users count by."""
    return "surface" if Path(file).suffix.lower() == ".vs3" else "patch"


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


@dataclass(frozen=True)
class Told:
    """What is said of form factors."""

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
        print(
            f"{'farthest from 1':<18}{self.farthest}: {self.farthest.row_sum:.6f} "
            f"({abs(self.farthest.row_sum - 1):.2g} off)"
        )
        if not self.enclosure:
            print(f"{'enclosure':<18}no, so that row sums are not held against 1 (--enclosure does it)")
        if self.surfaces is not None:
            lines = _matrix(self.surfaces)
            fits = len(lines[0]) <= shutil.get_terminal_size().columns and len(lines) <= MOST_SHOWN
            print("\n".join(["", *lines, ""]) if fits else f"{'surfaces':<18}{len(self.surfaces.names):,}")
        output.show_findings(self.findings)


def _tell(file: str, f: FormFactors, surfaces: SurfaceFactors | None, enclosure: bool | None) -> Told:
    from radiosity import diagnosis

    closure = f.closure()
    summary = float(closure.min()), diagnosis.mean_closure(f), float(closure.max())
    closed = diagnosis.is_enclosure(f) if enclosure is None else enclosure
    findings = diagnosis.of(f, enclosure=enclosure) + _unused_hints(f.patches.scene)
    entries = int(f.to_scipy_sparse().nnz)
    return Told(f, surfaces, entries, summary, diagnosis.farthest(f), closed, findings, file)


def _matrix(surfaces: SurfaceFactors) -> list[str]:
    """F between few surfaces as lines: from the one on the left to the one above."""
    names = surfaces.names
    left = max(map(len, ("from \\ to", *names)))
    widths = [max(len(name), 6) for name in (*names, "sum")]
    lines = [
        " ".join([f"{'from | to':<{left}}", *(f"{name:>{w}}" for name, w in zip((*names, "sum"), widths, strict=True))])
    ]
    for name, row, total in zip(names, surfaces.F, surfaces.closure(), strict=True):
        numbers = (f"{factor:>{w}.4f}" for factor, w in zip((*row, total), widths, strict=True))
        lines.append(" ".join([f"{name:<{left}}", *numbers]))
    return lines


def _demand_tolerance(file: str, f: FormFactors, tolerance: float | None) -> None:
    """End the command with its own exit code if a tolerance was asked for and not reached.

    Raises:
        Stop: it was not.
    """
    if tolerance is not None and f.report.estimated_error > tolerance:
        raise Stop(
            ExitCode.ACCURACY,
            f"{file}: the estimated error is {f.report.estimated_error:.1e}, not {tolerance:.1e}: "
            "choose another method or cut more finely",
        )
