"""``radiosity compare``."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatch
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

import typer

from radiosity.cli import demo, interrupt, options, output, picture, source
from radiosity.cli.failure import bad_argument
from radiosity.cli.progress import Bar
from radiosity.cli.render import SOLVED_TO
from radiosity.cli.solve import Effort, solve_target

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from radiosity import Scene, Solution
    from radiosity.comparison import Panel
    from radiosity.files import LitModel

FOLDER = Path("out")
"""Where the sheet goes where nobody says."""

SUBJECT = {"ferren": "board * front"}
"""Surfaces of built-in scenes that the figures are of."""

_Scene = Annotated[
    str,
    typer.Argument(
        metavar="SCENE",
        help="A scene file, a lit model, builtin:NAME, or just the NAME of a built-in scene (see radiosity scenes).",
    ),
]
_Panels = Annotated[
    str,
    typer.Option(
        "--panels",
        "--modes",
        metavar="MODE,...",
        help="What is shown, in this order: whitted, direct, patches, smooth, gather, path (see radiosity render).",
    ),
]
_Pixels = Annotated[int, typer.Option(min=1, max=1 << 13, help="Pixels of each panel.")]
_Samples = Annotated[
    int | None, typer.Option(min=1, max=1 << 16, help="Rays per pixel, as for render.", show_default=False)
]
_Accuracy = Annotated[
    float | None, typer.Option(help="Wanted error of irradiance, as for solve (0.01).", show_default=False)
]


def compare(
    file: _Scene,
    panels: _Panels = "whitted,direct,gather,path",
    sheet: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FILE", help="The .png with all panels (out/NAME-comparison.png)."),
    ] = None,
    each: Annotated[
        list[str] | None,
        typer.Option("--each", metavar=".exr|.png", help="Also save every panel by itself; may be repeated."),
    ] = None,
    width: _Pixels = 480,
    height: _Pixels = 480,
    samples: _Samples = None,
    columns: Annotated[int | None, typer.Option(min=1, help="Panels a row; all, up to four, by default.")] = None,
    camera: Annotated[str | None, typer.Option(metavar="NAME|INDEX", help="A camera of the scene.")] = None,
    exposure: Annotated[
        str, typer.Option(metavar="EV|auto", help="Stops, of all panels; auto: what suits the radiosity picture.")
    ] = "auto",
    ambient: options.Ambient = None,
    subject: Annotated[
        str | None,
        typer.Option("--of", metavar="SURFACES", help="Surfaces to give figures of, such as 'board * front'."),
    ] = None,
    accuracy: _Accuracy = None,
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
    """Draw one view by several methods side by side, equally exposed, and tell how they differ."""
    from radiosity import Scene

    file = _with_builtin(file)
    builtin = source.builtin_name(file) or ""
    modes = _modes(panels)
    picture.check_ambient(modes, ambient)
    outputs = _Outputs.of(file, sheet, each or [])
    stops = picture.read_exposure(exposure)
    meshing = source.Meshing(max_edge, patches, as_is)
    if builtin in demo.EVENLY and meshing.is_left_open:
        meshing = source.Meshing(count=demo.PATCHES)
    wanted = demo.ACCURACY.get(builtin, SOLVED_TO) if accuracy is None else accuracy
    source.use_threads(threads)
    lit: LitModel | Scene | Solution
    lit = source.open_lit(file, unit) or source.open_unlit(file, unit=unit, two_sided=two_sided)
    bands = list(lit.bands)
    eye = picture.aim(lit, picture.choose_camera(lit.cameras, camera, None, None, None), None)
    view = picture.View(width, height, samples, camera=eye, threads=threads, seed=seed, ambient=ambient)
    views = [replace(view, mode=mode) for mode in modes]
    places = _Places.of(lit, view, subject or SUBJECT.get(builtin))
    report = None
    if isinstance(lit, Scene) and any(view.needs_solution for view in views):
        effort = Effort(wanted, threads=threads, seed=seed)
        lit = solve_target(file, source.cut_or_leave(file, lit, meshing), effort, quiet=quiet)
        report = lit.report
    drawn = [_draw(file, lit, view, quiet=quiet) for view in views]
    used = outputs.save(drawn, bands, stops, columns)
    figures = _figures(drawn, bands, places)
    if as_json:
        told = None if report is None else report.to_dict()
        content = {"scene": file, "outputs": outputs.written(modes), "exposure": used, "panels": figures}
        output.print_json(content | {"report": told})
    elif not quiet:
        _show(figures)
        for path in outputs.written(modes):
            print(f"wrote {path}")
    if report is not None:
        output.demand_accuracy(file, report)


def _with_builtin(file: str) -> str:
    """FILE, or builtin:FILE where that is a built-in scene and there is no such file."""
    from radiosity.scenes import BUILTIN_SCENES

    return source.BUILTIN + file if file in BUILTIN_SCENES and not Path(file).exists() else file


def _modes(panels: str) -> list[picture.Mode]:
    """The modes named in a list with commas.

    Raises:
        Stop: there is no such mode, none at all, or one twice.
    """
    known = get_args(picture.Mode)
    modes = [part.strip() for part in panels.split(",")]
    for mode in modes:
        if mode not in known:
            raise bad_argument(f"--panels: there is no mode '{mode}'; choose some of {', '.join(known)}")
    if len(set(modes)) < len(modes):
        raise bad_argument("--panels: name every mode once")
    return modes  # type: ignore[return-value]  # it was looked up


@dataclass(frozen=True)
class _Outputs:
    """Where the sheet goes, and the suffixes of files of single panels beside it."""

    sheet: Path
    each: list[str]

    @classmethod
    def of(cls, file: str, sheet: Path | None, each: list[str]) -> _Outputs:
        """What the options ask for.

        Raises:
            Stop: it could not be written.
        """
        if find_spec("matplotlib") is None:
            raise bad_argument("radiosity compare needs matplotlib: pip install 'radiosity[plots]'")
        for suffix in each:
            if suffix not in picture.SUFFIXES:
                raise bad_argument(f"--each {suffix}: choose {' or '.join(picture.SUFFIXES)}")
        if sheet is None:
            with output.naming_file(FOLDER):
                FOLDER.mkdir(parents=True, exist_ok=True)
            sheet = FOLDER / f"{source.builtin_name(file) or Path(file).stem}-comparison.png"
        output.check_outputs([sheet], (".png",), file)
        return cls(sheet, each)

    def written(self, modes: Sequence[str]) -> list[Path]:
        """All files: the sheet, then every panel in each form."""
        return [self.sheet] + [path for mode in modes for path in self._single(mode)]

    def _single(self, mode: str) -> list[Path]:
        return [self.sheet.with_name(f"{self.sheet.stem}-{mode}{suffix}") for suffix in self.each]

    def save(
        self, panels: Sequence[Panel], bands: list[str], stops: float | Literal["auto"], columns: int | None
    ) -> float:
        """Write everything with one exposure, and tell which, in stops."""
        from radiosity.comparison import common_exposure, save_sheet

        used = common_exposure(panels, bands) if stops == "auto" else stops
        with interrupt.writing(), output.naming_file(self.sheet):
            save_sheet(self.sheet, panels, bands, exposure=used, columns=columns)
        for panel in panels:
            picture.save(panel.image, bands, self._single(panel.mode), picture.Tone(used))
        return used


@dataclass(frozen=True)
class _Places:
    """Pixels that no edge runs through: all, and those that show the surfaces that figures are asked of."""

    everywhere: npt.NDArray[np.bool_]
    subject: npt.NDArray[np.bool_] | None

    @classmethod
    def of(cls, lit: LitModel | Scene, view: picture.View, subject: str | None) -> _Places:
        """What a view shows.

        Raises:
            Stop: no surface of such a name is seen.
        """
        import numpy as np

        from radiosity.comparison import off_edges, seen
        from radiosity.files import LitModel

        assert view.camera is not None
        surface = seen(lit, view.camera, view.width, view.height)
        everywhere = off_edges(surface)
        if subject is None:
            return cls(everywhere, None)
        names = [s[0] for s in lit.surfaces] if isinstance(lit, LitModel) else [s.name for s in lit.surfaces]
        shown = everywhere & np.isin(surface, [k for k, name in enumerate(names) if fnmatch(name, subject)])
        if not shown.any():
            raise bad_argument(f"--of '{subject}': no surface of that name is seen")
        return cls(everywhere, shown)


def _draw(file: str, lit: LitModel | Scene | Solution, view: picture.View, *, quiet: bool) -> Panel:
    from radiosity import comparison

    name = getattr(lit, "name", "")
    with source.naming(file, name), Bar(comparison.CAPTIONS[view.mode][0].lower(), quiet=quiet) as bar:
        return comparison.draw(
            view.mode, lit, view.camera, width=view.width, height=view.height, samples=view.samples,
            ambient=view.ambient, threads=view.threads, seed=view.seed, progress=bar,
        )  # fmt: skip


def _figures(panels: list[Panel], bands: list[str], places: _Places) -> list[dict[str, Any]]:
    """Of each panel: mean luminances, and how far it is from the path-traced one."""
    from radiosity.colour import luminance
    from radiosity.comparison import difference

    reference = next((panel for panel in panels if panel.mode == "path"), None)
    figures = []
    for panel in panels:
        bright = luminance(panel.image, bands)
        told: dict[str, Any] = {"mode": panel.mode, "luminance": float(bright.mean())}
        if places.subject is not None:
            told["subject"] = float(bright[places.subject].mean())
        if reference is not None and panel is not reference:
            found = difference(panel, reference, places.everywhere)
            told |= {"difference": found.rms, "noise": found.noise}
        figures.append(told)
    return figures


def _show(figures: list[dict[str, Any]]) -> None:
    heads = {"luminance": "mean", "subject": "subject", "difference": "from path", "noise": "by noise"}
    columns = [key for key in heads if any(key in told for told in figures)]
    print(f"{'':<8}" + "".join(f"{heads[key]:>12}" for key in columns))
    for told in figures:
        cells = [_cell(key, told.get(key)) for key in columns]
        print(f"{told['mode']:<8}" + "".join(f"{cell:>12}" for cell in cells))
    print("\nmean, subject  mean luminance, W/(m2 sr), of the picture and of the surfaces that figures are asked of")
    if "difference" in columns:
        print("from path      root mean square difference from the path-traced picture off edges, relative to its mean")
        print("by noise       what the standard errors of both explain of it, where they are known")


def _cell(key: str, value: float | None) -> str:
    if value is None or math.isnan(value):
        return ""
    return f"{value:.2%}" if key in ("difference", "noise") else f"{value:.4g}"
