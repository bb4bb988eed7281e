"""``radiosity render``."""

from __future__ import annotations

import sys
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from radiosity.cli import options, output, picture, source
from radiosity.cli.failure import ExitCode, Stop, bad_argument
from radiosity.cli.solve import Effort, solve_target

if TYPE_CHECKING:
    from radiosity import PathTraced
    from radiosity.files import LitModel
    from radiosity.picture import Gathered

Outputs = Annotated[
    list[Path], typer.Option("--output", "-o", metavar="FILE", help="Where to save: .png or .exr; may be repeated.")
]
_Pixels = Annotated[int, typer.Option(min=1, max=1 << 15, help="Pixels.")]
_Samples = Annotated[
    int | None,
    typer.Option(
        min=1,
        max=1 << 16,
        help="Rays per pixel (16), of --mode gather into the solution (32), or paths (64).",
        show_default=False,
    ),
]
_Mode = Annotated[
    picture.Mode,
    typer.Option(
        help="smooth: interpolated; patches: one colour per patch; gather: looks from every point that is seen at the "
        "lamps and into the solution once more, for sharp shadows; path: path tracing, which needs no solution; "
        "direct: what comes straight from lamps, likewise; whitted: that and an even ambient light."
    ),
]
_Accuracy = Annotated[
    float | None,
    typer.Option(
        help="Wanted relative error: of irradiance where a scene is solved first (0.01), RMS over area; with --mode "
        "path of the pixels, mean standard error.",
        show_default=False,
    ),
]

SOLVED_TO = 0.01
"""The accuracy that scenes are solved to before they are drawn."""


def render(
    file: options.SceneFile,
    outputs: Outputs,
    width: _Pixels = 800,
    height: _Pixels = 600,
    samples: _Samples = None,
    camera: Annotated[str | None, typer.Option(metavar="NAME|INDEX", help="A camera of the scene.")] = None,
    look_from: Annotated[str | None, typer.Option(metavar="X,Y,Z", help="Viewpoint in metres.")] = None,
    look_at: Annotated[str | None, typer.Option(metavar="X,Y,Z", help="Point in the middle of the picture.")] = None,
    fov: Annotated[float | None, typer.Option(help="Full vertical angle of view in degrees.")] = None,
    exposure: Annotated[str, typer.Option(metavar="EV|auto", help="Stops, for .png.")] = "auto",
    false_colours: Annotated[
        bool, typer.Option("--false-colours", help="A colour scale with a legend, for .png.")
    ] = False,
    show: Annotated[picture.Quantity, typer.Option(help="What to show.")] = "radiosity",
    mode: _Mode = "smooth",
    accuracy: _Accuracy = None,
    ambient: options.Ambient = None,
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
    """Draw a lit model; a scene that is not lit yet is solved first, except for path tracing and direct light."""
    from radiosity.files import LitModel
    from radiosity.picture import legend_of

    output.check_outputs(outputs, picture.SUFFIXES, file)
    if fov is not None and not 0 < fov < 180:
        raise bad_argument(f"--fov {fov:g}: give an angle between 0 and 180 degrees")
    picture.check_shown(mode, show)
    picture.check_ambient(mode, ambient)
    tone = picture.Tone(picture.read_exposure(exposure), false_colours, legend_of(show, mode))
    meshing = source.Meshing(max_edge, patches, as_is)
    source.use_threads(threads)
    lit = source.open_lit(file, unit)
    view = picture.View(width, height, samples, show, mode, None, threads, seed, None, ambient)
    done = _Done(file, outputs, as_json, quiet)
    if not view.needs_solution:
        scene = lit or source.open_unlit(file, unit=unit, two_sided=two_sided)
        eye = picture.aim(scene, picture.choose_camera(scene.cameras, camera, look_from, look_at, fov), fov)
        view = replace(view, camera=eye, accuracy=accuracy)
        with source.naming(file, getattr(scene, "name", "")):
            traced = picture.trace(scene, view, quiet=quiet) if mode == "path" else None
            if traced is None:
                image = picture.render(scene, view, quiet=quiet)
            else:
                image = traced.standard_error if show == "error" else traced.image
        done.say(lit, picture.save(image, scene.bands, outputs, tone), traced=traced)
        return
    solution = None
    if lit is None:
        scene = source.open_unlit(file, unit=unit, two_sided=two_sided)
        # Before the long work, so that a wrong name does not come after it.
        picture.choose_camera(scene.cameras, camera, look_from, look_at, fov)
        effort = Effort(SOLVED_TO if accuracy is None else accuracy, threads=threads, seed=seed)
        solution = solve_target(file, source.cut_or_leave(file, scene, meshing), effort, quiet=quiet)
        lit = LitModel.of(solution)
    elif mode == "gather" and lit.lights is None and not quiet:
        _warn_of_unknown_lights(file)
    eye = picture.aim(lit, picture.choose_camera(lit.cameras, camera, look_from, look_at, fov), fov)
    view = replace(view, camera=eye)
    gathered = picture.gather(solution or lit, view, quiet=quiet) if mode == "gather" else None
    image = picture.render(solution or lit, view, quiet=quiet) if gathered is None else gathered.image
    done.say(lit, picture.save(image, lit.bands, outputs, tone), gathered=gathered)
    if solution is not None:
        output.demand_accuracy(file, solution.report)


@dataclass(frozen=True)
class _Done:
    """What is said of pictures that are saved."""

    file: str
    outputs: list[Path]
    as_json: bool
    quiet: bool

    def say(
        self,
        lit: LitModel | None,
        scale: tuple[float, float] | None,
        *,
        traced: PathTraced | None = None,
        gathered: Gathered | None = None,
    ) -> None:
        """Tell what was written.

        Raises:
            Stop: a path-traced picture is not as accurate as asked.
        """
        if self.as_json:
            content = {"scene": self.file, "outputs": self.outputs, "false_colours": scale}
            report = None if lit is None else lit.report
            effort: dict[str, Any] = {} if traced is None else {"paths": asdict(traced.effort)}
            if gathered is not None:
                effort = {"gather": {"noise": gathered.noise, "rays": gathered.rays}}
            output.print_json({**content, "report": report, **effort})
        elif not self.quiet:
            for path in self.outputs:
                print(f"wrote {path}")
            if scale is not None:
                print(f"colours from {scale[0]:.4g} to {scale[1]:.4g}")
            if gathered is not None:
                print(f"{gathered.rays:,} rays, noise {gathered.noise:.2%} of the mean")
            if traced is not None:
                e = traced.effort
                error = f"{e.relative_error:.2%} mean relative standard error"
                print(f"{e.samples:,} paths a pixel, {e.rays:,} rays, {e.seconds:.1f} s, {error}")
        if traced is not None and not traced.effort.reached:
            e = traced.effort
            raise Stop(
                ExitCode.ACCURACY,
                f"{self.file}: the mean relative standard error is {e.relative_error:.2%}, not {e.accuracy:.2%}, after "
                f"{e.samples:,} paths a pixel; raise --samples",
            )


def _warn_of_unknown_lights(file: str) -> None:
    sys.stderr.write(
        f"{file}: this lit model does not say which lights without area there were; if there were any, their direct "
        "light is missing: solve the scene again\n"
    )
