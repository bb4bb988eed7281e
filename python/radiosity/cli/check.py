"""``radiosity check``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from radiosity.cli import interrupt, options, output, source
from radiosity.cli.failure import ExitCode, bad_argument
from radiosity.cli.progress import Bar

if TYPE_CHECKING:
    from radiosity import Finding, Scene

Picture = Annotated[
    Path | None,
    typer.Option(
        "--picture",
        metavar="FILE",
        help="Where to draw the scene with doubtful places marked: a .png. Needs matplotlib.",
    ),
]


def check(
    file: options.SceneFile,
    picture: Picture = None,
    unit: options.Unit = None,
    two_sided: options.TwoSided = None,
    enclosure: options.Enclosure = None,
    threads: options.Threads = None,
    seed: options.Seed = 0,
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
) -> None:
    """List what is wrong or doubtful about a scene; exit code 3 if it cannot be lit.

    Shapes, paint and lamps are looked at, and a few rays from every face tell which of them look the wrong way and
    where light escapes; above 200,000 faces there are no rays.
    """
    if picture is not None:
        _check_picture(picture, file)
    source.use_threads(threads)
    scene, summary, findings = _examine(file, unit, two_sided, enclosure, threads, seed, quiet)
    errors = sum(f.severity == "error" for f in findings)
    drawn = picture is not None and _draw(file, scene, findings, picture)
    if as_json:
        pictures = [picture] if drawn else []
        content = {"scene": file, "sound": not errors, "pictures": pictures}
        output.print_json(content | {"findings": output.findings_out(findings)})
    elif not quiet:
        _show(file, summary, findings)
        if drawn:
            print(f"wrote {picture}")
    if errors:
        raise typer.Exit(ExitCode.INPUT)


def _check_picture(picture: Path, file: str) -> None:
    """Refuse before any work what could not be drawn after it.

    Raises:
        Stop: the file cannot be written, or matplotlib is not installed.
    """
    output.check_outputs([picture], (".png",), file)
    from importlib.util import find_spec

    if find_spec("matplotlib") is None:
        raise bad_argument("--picture needs matplotlib: pip install 'radiosity[plots]'")


def _examine(
    file: str,
    unit: str | None,
    two_sided: bool | None,
    enclosure: bool | None,
    threads: int | None,
    seed: int,
    quiet: bool,
) -> tuple[Scene | None, str, list[Finding]]:
    """The scene, one line about it and all findings; what cannot even be read has a single one."""
    import numpy as np

    from radiosity import Finding, SceneError, diagnosis

    try:
        scene = source.open_scene(file, unit=unit, two_sided=two_sided)
        faces = sum(np.shape(s.faces)[0] for s in scene.surfaces)
        lights = f"{len(scene.lights)} lights, {len(scene.cameras)} cameras"
        obstructions = f"{len(scene.obstructions)} obstructions, " if scene.obstructions else ""
        summary = f"{len(scene.surfaces)} surfaces, {faces} faces, {obstructions}{lights}"
        with Bar("looking around", quiet=quiet) as bar:
            found = diagnosis.examine(scene, enclosure=enclosure, seed=seed, threads=threads, progress=bar)
        return scene, summary, found
    except SceneError as error:
        return None, "cannot be read", [Finding("error", "unreadable", "", str(error).removeprefix(f"{file}: "))]


def _draw(file: str, scene: Scene | None, findings: list[Finding], picture: Path) -> bool:
    """Draw the findings; where there is nothing to draw, say so and go on."""
    from radiosity import marking

    if scene is None or not any(len(surface.faces) for surface in scene.surfaces):  # type: ignore[arg-type]
        print(f"radiosity: {file}: there is nothing to draw, and {picture} was not written", file=sys.stderr)
        return False
    with interrupt.writing(), output.naming_file(picture):
        marking.draw(scene, findings, picture, title=Path(file).name)
    return True


def _show(file: str, summary: str, findings: list[Finding]) -> None:
    print(f"{file}: {summary}")
    output.show_findings(findings)
    if not findings:
        print("nothing to remark")
