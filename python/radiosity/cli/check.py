"""``radiosity check``."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from radiosity.cli import options, output, source
from radiosity.cli.failure import ExitCode

if TYPE_CHECKING:
    from radiosity import Finding


def check(
    file: options.SceneFile,
    unit: options.Unit = None,
    two_sided: options.TwoSided = None,
    enclosure: options.Enclosure = None,
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
) -> None:
    """List what is wrong or doubtful about a scene; exit code 3 if it cannot be lit."""
    summary, findings = _examine(file, unit, two_sided, enclosure)
    errors = sum(f.severity == "error" for f in findings)
    if as_json:
        output.print_json({"scene": file, "sound": not errors, "findings": output.findings_out(findings)})
    elif not quiet:
        _show(file, summary, findings)
    if errors:
        raise typer.Exit(ExitCode.INPUT)


def _examine(file: str, unit: str | None, two_sided: bool | None, enclosure: bool | None) -> tuple[str, list[Finding]]:
    """One line about the scene and all findings; what cannot even be read has a single one."""
    import numpy as np

    from radiosity import Finding, SceneError

    try:
        scene = source.open_scene(file, unit=unit, two_sided=two_sided)
        faces = sum(np.shape(s.faces)[0] for s in scene.surfaces)
        lights = f"{len(scene.lights)} lights, {len(scene.cameras)} cameras"
        obstructions = f"{len(scene.obstructions)} obstructions, " if scene.obstructions else ""
        summary = f"{len(scene.surfaces)} surfaces, {faces} faces, {obstructions}{lights}"
        return summary, scene.findings(enclosure=enclosure)
    except SceneError as error:
        return "cannot be read", [Finding("error", "unreadable", "", str(error).removeprefix(f"{file}: "))]


def _show(file: str, summary: str, findings: list[Finding]) -> None:
    print(f"{file}: {summary}")
    output.show_findings(findings)
    if not findings:
        print("nothing to remark")
