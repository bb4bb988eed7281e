"""``radiosity view``."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from radiosity.cli import interrupt, options, output, source
from radiosity.cli.failure import ExitCode, Stop, bad_argument
from radiosity.cli.solve import Effort, solve_target

if TYPE_CHECKING:
    from radiosity import Patches, Scene, Solution
    from radiosity.files import LitModel
    from radiosity.viewer.settings import Settings, Unit

Export = Annotated[
    Path | None,
    typer.Option("--export", metavar="PAGE.html", help="Write one file that needs no server instead of serving."),
]


def view(
    file: options.SceneFile,
    export: Export = None,
    layers: Annotated[bool, typer.Option("--layers", help="The light of each lamp, to switch and dim there.")] = False,
    accuracy: options.Accuracy = 0.02,
    max_edge: options.MaxEdge = None,
    patches: options.PatchCount = None,
    as_is: options.AsIs = False,
    max_patches: options.MaxPatches = None,
    unit: options.Unit = None,
    light_unit: Annotated[
        Literal["W/m2", "lux"] | None,
        typer.Option(help="What irradiance is in; lux for glTF scenes by default, else W/m2.", show_default=False),
    ] = None,
    two_sided: options.TwoSided = None,
    port: Annotated[
        int | None, typer.Option(min=1, max=65535, help="To serve at; a free one by default.", show_default=False)
    ] = None,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Only print the address.")] = False,
    threads: options.Threads = None,
    seed: options.Seed = 0,
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
) -> None:
    """Walk through a lit model or a scene in the browser; a scene is solved before your eyes."""
    from radiosity.viewer.page import MissingPageError, page
    from radiosity.viewer.settings import Settings

    if export is not None:
        output.check_outputs([export], (".html", ".htm"), file)
        if port is not None or no_browser:
            raise bad_argument("--export serves nothing: leave out --port and --no-browser")
    if not 0 < accuracy < math.inf:
        raise bad_argument(f"--accuracy must be a positive number such as 0.02, not {accuracy:g}")
    meshing = source.Meshing(max_edge, patches, as_is, max_patches)
    try:
        page()  # before any long work
    except MissingPageError as error:
        raise bad_argument(str(error)) from error
    source.use_threads(threads)
    lit = source.open_lit(file, unit)
    what: LitModel | Scene | Patches
    if lit is not None:
        what, title = lit, Path(file).stem
        if layers:
            raise bad_argument(f"{file}: a lit model has the light of all lamps together: for --layers, give the scene")
    else:
        scene = source.open_unlit(file, unit=unit, two_sided=two_sided)
        what, title = source.cut_or_leave(file, scene, meshing), scene.name or Path(file).stem
    settings = Settings(title, _unit(file, lit, light_unit), layers, accuracy, max_patches, threads, seed)
    if export is not None:
        _export(file, export, what, settings, as_json=as_json, quiet=quiet)
    else:
        _serve(file, what, settings, port, open_browser=not no_browser, as_json=as_json, quiet=quiet)


def _unit(file: str, lit: LitModel | None, wanted: Unit | None) -> Unit:
    from radiosity.viewer.settings import PHOTOMETRIC

    is_photometric = lit is None and source.builtin_name(file) is None and Path(file).suffix.lower() in PHOTOMETRIC
    return wanted or ("lux" if is_photometric else "W/m2")


def _export(
    file: str, path: Path, what: LitModel | Scene | Patches, settings: Settings, *, as_json: bool, quiet: bool
) -> None:
    from radiosity.files import LitModel
    from radiosity.viewer.page import export
    from radiosity.viewer.showing import lit_of

    solution: Solution | None = None
    if isinstance(what, LitModel):
        lit = lit_of(what, settings)
    else:
        effort = Effort(
            settings.accuracy, threads=settings.threads, seed=settings.seed, max_patches=settings.max_patches
        )
        solution = solve_target(file, what, effort, quiet=quiet)
        lit = lit_of(solution, settings)
    with interrupt.writing(), output.naming_file(path):
        export(path, lit)
    if as_json:
        lamps = [lamp.name for lamp in lit.lamps] if settings.is_layered else []
        output.print_json({"scene": file, "outputs": [path], "layers": lamps, "report": lit.model.report})
    elif not quiet:
        print(f"wrote {path} ({path.stat().st_size / 1e6:.1f} MB)")
    if solution is not None:
        output.demand_accuracy(file, solution.report)


def _serve(
    file: str,
    what: LitModel | Scene | Patches,
    settings: Settings,
    port: int | None,
    *,
    open_browser: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    from radiosity.viewer.showing import serve

    def say(address: str) -> None:
        if as_json:
            output.print_json({"scene": file, "address": address})
        else:
            print(address if quiet else f"{settings.title} is at {address}\nCtrl-C ends it.")
        # Whoever reads our output from a pipe waits for it.
        sys.stdout.flush()

    def warn(sentence: str) -> None:
        print(f"radiosity: {sentence}", file=sys.stderr)

    try:
        with source.naming(file, settings.title):
            serve(what, settings, port=port, open_browser=open_browser, say=say, warn=warn)
    except OSError as error:
        raise Stop(ExitCode.ARGUMENTS, error.strerror or str(error)) from error
