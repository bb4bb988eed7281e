"""``radiosity factors``."""

from __future__ import annotations

import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from radiosity.cli import compare, factor_summary, interrupt, options, output, source
from radiosity.cli.failure import ExitCode, Stop, bad_argument
from radiosity.cli.progress import Bar

if TYPE_CHECKING:
    from radiosity import FormFactors, Patches, SurfaceFactors

SUFFIXES = (".npz", ".csv", ".exchange")

FACES_ARE_PATCHES = (".stl", ".ply", ".vs3")
"""Files whose faces are the patches that their authors want factors between."""

By = Literal["patch", "surface"]

Outputs = Annotated[
    list[Path] | None,
    typer.Option(
        "--output",
        "-o",
        metavar="FILE",
        help="Where to save: .npz, .csv, or .exchange, which is measured onto and resumed; may be repeated.",
    ),
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


USUAL_PATCHES = 1000
"""Patches that a model is cut into where nothing is said: a million factors."""


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

    Models are cut into about 1,000 patches unless you say otherwise; faces of .stl, .ply and .vs3 files are patches.

    A saved .npz opens with scipy.sparse.load_npz; numpy.load shows area, centre, normal, surface, face and closure too.
    With --by surface its arrays are names, area and F.

    An .exchange holds factors between patches and grows while they are measured, so that they need not fit the memory.
    If that is cut off, the same command goes on from there. See radiosity solve --exchange.
    """
    from radiosity.exchange_files import is_exchange

    targets = outputs or []
    output.check_outputs(targets, SUFFIXES, file)
    if compare_all and (targets or by or method != "auto"):
        raise bad_argument("--compare runs all methods and saves nothing: leave out --method, --by and --output")
    settings = Effort(method, tolerance, rays, resolution, hemicubes, points, memory, threads, seed).settings()
    source.use_threads(threads)
    meshing = _meshing(file, max_edge, patches, as_is, max_patches)
    scene = source.open_scene(file, unit=unit, two_sided=source.sides_of_factors(file, two_sided))
    if compare_all:
        most = max_patches or compare.MOST_PATCHES
        elements = source.cut(file, scene, meshing)
        compare.compare(file, elements, settings, max_patches=most, enclosure=enclosure, as_json=as_json, quiet=quiet)
        return
    onto = [target for target in targets if is_exchange(target)]
    f = measure(file, source.cut(file, scene, meshing), settings, onto=onto[0] if onto else None, quiet=quiet)
    surfaces = f.by_surface() if (by or _usual(file)) == "surface" else None
    _save(f, onto[1:])
    _save(surfaces or f, [target for target in targets if target not in onto])
    summary = factor_summary.summarise(file, f, surfaces, enclosure)
    if as_json:
        output.print_json({"scene": file, "outputs": targets, **summary.to_dict()})
    elif not quiet:
        summary.show()
        for target in targets:
            print(f"wrote {target}")
    _demand_tolerance(file, f, tolerance)


def _meshing(
    file: str, max_edge: float | None, count: int | None, as_is: bool, max_patches: int | None
) -> source.Meshing:
    """How to cut; where nothing is said, the faces of some files are the patches."""
    if max_edge is None and count is None and not as_is:
        as_is = _suffix(file) in FACES_ARE_PATCHES
        count = None if as_is else USUAL_PATCHES
    return source.Meshing(max_edge, count, as_is, max_patches)


def _usual(file: str) -> By:
    """What factors are wanted between: View3D's surfaces are what its users count by."""
    return "surface" if _suffix(file) == ".vs3" else "patch"


def _suffix(file: str) -> str:
    return Path(file).suffix.lower()


def measure(
    file: str, patches: Patches, settings: dict[str, Any], *, onto: Path | None = None, quiet: bool
) -> FormFactors:
    """Measure with a progress bar, onto a file if one is named.

    Raises:
        ResourceError: the form factors do not fit the memory. ValueError: the method takes no such settings.
    """
    import radiosity
    from radiosity.exchange_files import partial_name

    partial = None if onto is None else partial_name(onto)
    if partial is not None and partial.exists() and not quiet:
        print(f"radiosity: going on from {partial}", file=sys.stderr)
    naming, resumable = source.naming(file, patches.scene.name), interrupt.resumable(partial)
    with naming, resumable, Bar("measuring", quiet=quiet) as bar:
        return radiosity.form_factors(patches, **settings, checkpoint=onto, progress=bar)


def _save(factors: FormFactors | SurfaceFactors, targets: list[Path]) -> None:
    for target in targets:
        with interrupt.writing(), output.naming_file(target):
            factors.save(target)


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
