"""``radiosity render``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from radiosity.cli import options, output, picture, source
from radiosity.cli.failure import bad_argument
from radiosity.cli.solve import Effort, solve_target

Outputs = Annotated[
    list[Path], typer.Option("--output", "-o", metavar="FILE", help="Where to save: .png or .exr; may be repeated.")
]
_Pixels = Annotated[int, typer.Option(min=1, max=1 << 15, help="Pixels.")]


def render(
    file: options.SceneFile,
    outputs: Outputs,
    width: _Pixels = 800,
    height: _Pixels = 600,
    samples: Annotated[int, typer.Option(min=1, max=1 << 16, help="Rays per pixel.")] = 16,
    camera: Annotated[str | None, typer.Option(metavar="NAME|INDEX", help="A camera of the scene.")] = None,
    look_from: Annotated[str | None, typer.Option(metavar="X,Y,Z", help="Viewpoint in metres.")] = None,
    look_at: Annotated[str | None, typer.Option(metavar="X,Y,Z", help="Point in the middle of the picture.")] = None,
    fov: Annotated[float | None, typer.Option(help="Full vertical angle of view in degrees.")] = None,
    exposure: Annotated[str, typer.Option(metavar="EV|auto", help="Stops, for .png.")] = "auto",
    false_colours: Annotated[bool, typer.Option("--false-colours", help="A colour scale, for .png.")] = False,
    show: Annotated[picture.Quantity, typer.Option(help="What to show.")] = "radiosity",
    mode: Annotated[picture.Mode, typer.Option(help="Interpolated, or one colour per patch.")] = "smooth",
    accuracy: options.Accuracy = 0.01,
    max_edge: options.MaxEdge = None,
    patches: options.PatchCount = None,
    as_is: options.AsIs = False,
    unit: options.Unit = None,
    two_sided: options.TwoSided = None,
    threads: options.Threads = None,
    seed: options.Seed = 0,
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
) -> None:
    """Draw a lit model; a scene that is not lit yet is solved first."""
    from radiosity.files import LitModel

    output.check_outputs(outputs, picture.SUFFIXES, file)
    if fov is not None and not 0 < fov < 180:
        raise bad_argument(f"--fov {fov:g}: give an angle between 0 and 180 degrees")
    tone = picture.Tone(picture.read_exposure(exposure), false_colours)
    meshing, effort = source.Meshing(max_edge, patches, as_is), Effort(accuracy, threads=threads, seed=seed)
    source.use_threads(threads)
    lit = source.open_lit(file, unit)
    solution = None
    if lit is None:
        scene = source.open_unlit(file, unit=unit, two_sided=two_sided)
        # Before the long work, so that a wrong name does not come after it.
        picture.choose_camera(scene.cameras, camera, look_from, look_at, fov)
        solution = solve_target(file, source.cut_or_leave(file, scene, meshing), effort, quiet=quiet)
        lit = LitModel.of(solution)
    eye = picture.aim(lit, picture.choose_camera(lit.cameras, camera, look_from, look_at, fov), fov)
    image = picture.render(lit, picture.View(width, height, samples, show, mode, eye, threads), quiet=quiet)
    scale = picture.save(image, lit.bands, outputs, tone)
    if as_json:
        output.print_json({"scene": file, "outputs": outputs, "false_colours": scale, "report": lit.report})
    elif not quiet:
        for path in outputs:
            print(f"wrote {path}")
        if scale is not None:
            print(f"colours from {scale[0]:.4g} to {scale[1]:.4g}")
    if solution is not None:
        output.demand_accuracy(file, solution.report)
