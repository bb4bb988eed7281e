"""From a solution or a lit model to picture files, for the commands that make pictures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from radiosity.cli import interrupt, output
from radiosity.cli.failure import bad_argument
from radiosity.cli.options import read_triple
from radiosity.cli.progress import Bar

if TYPE_CHECKING:
    from radiosity import Camera, PathTraced, Scene, Solution
    from radiosity.files import LitModel
    from radiosity.picture import Gathered, Image

SUFFIXES = (".png", ".exr")
Quantity = Literal["radiosity", "irradiance", "emission", "error"]
Mode = Literal["smooth", "patches", "gather", "path", "direct", "whitted"]


@dataclass(frozen=True)
class View:
    """What to draw, and from where. ``accuracy`` is that of path-traced pixels, ``ambient`` W/m2 of "whitted" ones."""

    width: int = 800
    height: int = 600
    samples: int | None = None
    show: Quantity = "radiosity"
    mode: Mode = "smooth"
    camera: Camera | None = None
    threads: int | None = None
    seed: int = 0
    accuracy: float | None = None
    ambient: float | None = None

    @property
    def needs_solution(self) -> bool:
        """Whether the scene must be solved first."""
        return self.mode not in ("path", "direct") and (self.mode != "whitted" or self.ambient is None)


@dataclass(frozen=True)
class Tone:
    """How a .png shows values: exposure in stops, or a colour scale with a legend."""

    exposure: float | Literal["auto"] = "auto"
    false_colours: bool = False
    legend: str | None = None


def render(lit: Solution | LitModel | Scene, view: View, *, quiet: bool) -> Image:
    """(height, width, bands) linear, with a progress bar."""
    from radiosity import picture

    with Bar("drawing", quiet=quiet) as bar:
        return picture.render(
            lit, view.camera, width=view.width, height=view.height, samples=view.samples, show=view.show,
            mode=view.mode, ambient=view.ambient, threads=view.threads, seed=view.seed, progress=bar,
        )  # fmt: skip


def gather(lit: Solution | LitModel, view: View, *, quiet: bool) -> Gathered:
    """A gathered picture with its noise, with a progress bar."""
    from radiosity import picture

    with Bar("gathering", quiet=quiet) as bar:
        return picture.gather(
            lit, view.camera, width=view.width, height=view.height, samples=view.samples or picture.SAMPLES["gather"],
            show="irradiance" if view.show == "irradiance" else "radiosity", threads=view.threads, seed=view.seed,
            progress=bar,
        )  # fmt: skip


def trace(scene: Scene | LitModel, view: View, *, quiet: bool) -> PathTraced:
    """A path-traced picture with its errors, with a progress bar."""
    from radiosity import path_trace

    with Bar("tracing", quiet=quiet) as bar:
        return path_trace(
            scene, view.camera, width=view.width, height=view.height, samples=view.samples, accuracy=view.accuracy,
            show="irradiance" if view.show == "irradiance" else "radiosity", threads=view.threads, seed=view.seed,
            progress=bar,
        )  # fmt: skip


def check_shown(mode: Mode, show: Quantity) -> None:
    """Refuse what a mode cannot show.

    Raises:
        Stop: it cannot.
    """
    from radiosity.picture import SHOWN_BY

    if show not in SHOWN_BY[mode]:
        raise bad_argument(f"--mode {mode} cannot show {show}: choose --show {' or '.join(SHOWN_BY[mode])}")


def check_ambient(modes: Sequence[Mode] | Mode, ambient: float | None) -> None:
    """Refuse an ambient light that no mode uses, or that is none.

    Raises:
        Stop: it is one of the two.
    """
    if ambient is not None and "whitted" not in ([modes] if isinstance(modes, str) else modes):
        raise bad_argument("--ambient is for --mode whitted; other modes find the light that is there")
    if ambient is not None and not 0 <= ambient < math.inf:
        raise bad_argument(f"--ambient must be a number of W/m2 from 0 on, not {ambient:g}")


def save(image: Image, bands: list[str], paths: Sequence[Path], tone: Tone) -> tuple[float, float] | None:
    """Write a picture in every form asked for; returns the values at the ends of the colour scale if there is one."""
    from radiosity import picture

    scale = None
    for path in paths:
        with interrupt.writing(), output.naming_file(path):
            used = picture.save_image(
                path, image, exposure=tone.exposure, false_colours=tone.false_colours, legend=tone.legend, bands=bands
            )
            scale = used or scale
    return scale


def read_exposure(text: str) -> float | Literal["auto"]:
    """``auto`` or stops (EV).

    Raises:
        Stop: it is neither.
    """
    if text == "auto":
        return "auto"
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise bad_argument(f"--exposure '{text}' is neither auto nor a number of stops")
    return value


def aim(model: LitModel | Scene, camera: Camera | None, fov: float | None) -> Camera:
    """The camera of :func:`choose_camera`, or the renderer's own choice with the angle of view asked for."""
    from dataclasses import replace

    from radiosity.files import LitModel
    from radiosity.picture import camera_of

    if camera is not None:
        return camera
    polygons = model.patches.polygons if isinstance(model, LitModel) else model.patches(as_is=True).polygons
    camera = camera_of(model.cameras, polygons)
    return camera if fov is None else replace(camera, vertical_fov=math.radians(fov))


def choose_camera(
    cameras: Sequence[Camera],
    name: str | None,
    look_from: str | None,
    look_at: str | None,
    fov: float | None,
) -> Camera | None:
    """The camera that the options describe; None leaves the choice to the renderer.

    Args:
        cameras: those of the scene.
        name: name or index of one of them.
        look_from, look_at: ``x,y,z`` in metres, instead of a name.
        fov: full vertical angle of view in degrees.
    """
    from dataclasses import replace

    if name is not None and (look_from is not None or look_at is not None):
        raise bad_argument("give --camera, or --look-from with --look-at, not both")
    if (look_from is None) != (look_at is None):
        raise bad_argument("--look-from and --look-at go together")
    if look_from is not None and look_at is not None:
        camera: Camera | None = _free_camera(look_from, look_at)
    elif name is not None:
        camera = _named_camera(cameras, name)
    else:
        camera = cameras[0] if cameras else None
    if fov is None or camera is None:
        return camera
    return replace(camera, vertical_fov=math.radians(fov))


def _free_camera(look_from: str, look_at: str) -> Camera:
    from radiosity import Camera

    position, target = read_triple(look_from, "--look-from"), read_triple(look_at, "--look-at")
    if position == target:
        raise bad_argument("--look-from and --look-at are the same point")
    # Straight up or down, "up" would not tell which way the picture is turned.
    upright = math.hypot(target[0] - position[0], target[2] - position[2]) > 1e-6 * math.dist(target, position)
    return Camera.look_at(position, target, (0.0, 1.0, 0.0) if upright else (0.0, 0.0, -1.0))


def _named_camera(cameras: Sequence[Camera], name: str) -> Camera:
    named = [camera for camera in cameras if camera.name == name]
    if named:
        return named[0]
    if name.isdecimal() and int(name) < len(cameras):
        return cameras[int(name)]
    known = ", ".join(f"{k} '{camera.name}'" for k, camera in enumerate(cameras)) or "none; use --look-from"
    raise bad_argument(f"there is no camera '{name}'; there are: {known}")
