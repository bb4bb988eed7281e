"""Pictures of a solution, and of scenes by path tracing or by direct light."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from radiosity import _native
from radiosity.checks import threads_or_all, whole
from radiosity.colour import developed, wavelengths_of
from radiosity.files import LitModel
from radiosity.patches import Patches
from radiosity.scene import Camera, Scene
from radiosity.solution import Solution

Image = npt.NDArray[np.float32]
Quantity = Literal["radiosity", "irradiance", "emission", "error"]
Mode = Literal["smooth", "patches", "gather", "path", "direct", "whitted"]

SAMPLES: dict[Mode, int] = {"smooth": 16, "patches": 16, "gather": 32, "path": 64, "direct": 16, "whitted": 16}
"""Rays or paths per pixel where the caller does not say."""

SHOWN_BY: dict[Mode, tuple[Quantity, ...]] = {
    "smooth": ("radiosity", "irradiance", "emission", "error"),
    "patches": ("radiosity", "irradiance", "emission", "error"),
    "gather": ("radiosity", "irradiance"),
    "path": ("radiosity", "irradiance", "error"),
    "direct": ("radiosity", "irradiance"),
    "whitted": ("radiosity",),
}
"""What each mode can show."""


def render(
    lit: Solution | LitModel | Scene | Patches,
    camera: Camera | None = None,
    *,
    width: int = 800,
    height: int = 600,
    samples: int | None = None,
    show: Quantity = "radiosity",
    mode: Mode = "smooth",
    accuracy: float | None = None,
    ambient: npt.ArrayLike | None = None,
    threads: int | None = None,
    seed: int = 0,
    progress: Callable[[int, int], object] | None = None,
) -> Image:
    """Render a solution as a camera sees it, or a scene by path tracing or by direct light.

    Args:
        lit: a solution, or a lit model read by :func:`radiosity.files.load_lit`; for modes "path" and "direct", and
            "whitted" with an ambient irradiance, also a scene or patches.
        camera: the viewpoint (default: the scene's first, or one that sees everything).
        width, height: pixels.
        samples: rays per pixel (default 16), of "gather" into the solution (default 32), or paths (default 64).
        show: radiosity is shown as radiance (W/m2/sr), other quantities in W/m2. "gather" and "direct" show radiosity
            and irradiance; "path" these and, as "error", the standard error of each pixel's radiance.
        mode: "smooth" interpolates values at corners, "patches" shows each patch's value. "gather" looks from every
            point that is seen once more at all lamps and into the solution (final gather; Reichert 1992), so that
            shadows are as sharp as they are. "path" takes nothing from a solution, see
            :func:`radiosity.path_tracing.path_trace`, which also returns errors. "direct" shows what comes straight
            from lamps, "whitted" an even ambient light as well, see :func:`radiosity.direct.direct_picture`.
        accuracy: of "path" only: the mean relative standard error of pixels at which to stop.
        ambient: of "whitted" only: ambient irradiance in W/m2, a number or one per band (default:
            :func:`radiosity.direct.ambient_of` the solution).
        threads, progress: as in :func:`radiosity.solve`.
        seed: of all but "smooth" and "patches": the same seed gives the same bytes.

    Textures show in all modes but "patches". Relighting a surface with other paint covers its texture. "gather" and
    "path" show the gloss of rough metals where the camera looks at them, other modes take it for diffuse.

    Radiance is also seen in mirrors and through clear glass. "smooth" and "patches" follow both ways of every ray, by
    at most 64 mirrors and panes and while more than 1/4096 of it is left, and show black beyond; other modes
    draw a way. Other quantities are those of the mirror or pane itself.

    Returns:
        (height, width, bands) float32, linear.

    Raises:
        ValueError: the mode cannot show this, or draws solutions only.
    """
    if ambient is not None and mode != "whitted":
        raise ValueError("ambient is for mode 'whitted'; other modes find the light that is there")
    if mode not in SHOWN_BY:
        raise ValueError(f"there is no mode '{mode}'; choose one of {', '.join(SHOWN_BY)}")
    if show not in SHOWN_BY[mode]:
        raise ValueError(f"mode '{mode}' cannot show '{show}'; it shows {', '.join(SHOWN_BY[mode])}")
    if mode == "path":
        from radiosity.path_tracing import path_trace  # noqa: PLC0415

        traced = path_trace(
            lit, camera, width=width, height=height, samples=samples, accuracy=accuracy,
            show="irradiance" if show == "irradiance" else "radiosity", threads=threads, seed=seed, progress=progress,
        )  # fmt: skip
        return traced.standard_error if show == "error" else traced.image
    if accuracy is not None:
        raise ValueError("accuracy is for mode 'path'; other modes are as accurate as the solution")
    rays = SAMPLES[mode] if samples is None else samples
    if mode in ("direct", "whitted"):
        from radiosity.direct import ambient_of, direct_picture  # noqa: PLC0415

        if mode == "whitted" and ambient is None:
            ambient = ambient_of(_solved(lit, mode), threads=threads, seed=seed)
        return direct_picture(
            lit, camera, ambient=0.0 if ambient is None else ambient, width=width, height=height, samples=rays,
            irradiance=show == "irradiance", threads=threads, seed=seed, progress=progress,
        )  # fmt: skip
    lit = _solved(lit, mode)
    if mode == "gather":
        return gather(
            lit, camera, width=width, height=height, samples=rays,
            show="irradiance" if show == "irradiance" else "radiosity", threads=threads, seed=seed, progress=progress,
        ).image  # fmt: skip
    if isinstance(lit, Solution):
        lit = LitModel.of(lit)
    camera = camera or default_camera(lit)
    values: npt.NDArray[np.float64] = getattr(lit, show)
    is_radiosity = show == "radiosity"
    return _native.render(
        lit.patches, np.ascontiguousarray(values), camera._tuple(), width, height, rays,
        1 / math.pi if is_radiosity else 1.0, mode == "smooth",
        np.ascontiguousarray(lit.irradiance) if is_radiosity else None,
        lit._reflectance if is_radiosity else None, lit._going_on if is_radiosity else None, threads, progress,
        lit._through if is_radiosity else None, lit.textures if is_radiosity else None,
    )  # fmt: skip


def _solved(lit: Solution | LitModel | Scene | Patches, mode: Mode) -> Solution | LitModel:
    if not isinstance(lit, Solution | LitModel):
        raise ValueError(f"mode '{mode}' draws a solution: solve the scene first, or use mode 'path'")
    return lit


@dataclass(frozen=True, eq=False)
class Gathered:
    """A gathered picture.

    Attributes:
        image: (height, width, bands) float32, linear.
        noise: its noise at most, root mean square over pixels, over its mean, as halves of its samples tell: up to
            three times what it is where they lie evenly. What the solution is off by comes on top, and what edges are
            that few points draw.
        rays: all rays, those to lamps included.
    """

    image: Image
    noise: float
    rays: int


def gather(
    lit: Solution | LitModel,
    camera: Camera | None = None,
    *,
    width: int = 800,
    height: int = 600,
    samples: int = SAMPLES["gather"],
    show: Literal["radiosity", "irradiance"] = "radiosity",
    threads: int | None = None,
    seed: int = 0,
    progress: Callable[[int, int], object] | None = None,
) -> Gathered:
    """Render by a final gather, as :func:`render` does with mode "gather", and tell its noise.

    Light of lamps is looked for from every point that is seen, more finely where shadows end. What rays find of all
    other light is compared with the solution's field, and what that is off by is fitted over the pixels around. Light
    that varies within some pixels, and that the mesh does not have, is smoothed.
    """
    model = LitModel.of(lit) if isinstance(lit, Solution) else lit
    blocks = [np.ascontiguousarray(b) for b in (model.emission, model._reflectance, model.irradiance, model.radiosity)]
    found = _native.gather(
        model.patches, blocks[0], blocks[1], blocks[2], blocks[3], model.lights or [],
        (camera or default_camera(model))._tuple(), width, height,
        whole(samples, "samples", 1, 1 << 24), "radiance" if show == "radiosity" else show,
        whole(seed, "seed", 0, 2**64 - 1), model._going_on, threads_or_all(threads), progress, model._through,
        model.textures, model.gloss,
    )  # fmt: skip
    return Gathered(*found)


def default_camera(lit: LitModel) -> Camera:
    """The first camera of the model, or one that looks at its middle from a corner outside."""
    return camera_of(lit.cameras, lit.patches.polygons)


def camera_of(cameras: Sequence[Camera], polygons: npt.NDArray[np.float64]) -> Camera:
    """The first of the cameras, or one that looks at the middle of (n, 4, 3) polygons from a corner outside."""
    if cameras:
        return cameras[0]
    points = polygons.reshape(-1, 3)
    low, high = points.min(axis=0), points.max(axis=0)
    middle, size = 0.5 * (low + high), float(np.linalg.norm(high - low)) or 1.0
    return Camera.look_at(middle + size * np.array([0.6, 0.5, 1.0]), middle)


def legend_of(show: Quantity, mode: Mode = "smooth") -> str:
    """What the legend of a picture in false colours says: the quantity and its unit, in lines."""
    if mode == "path" and show == "error":
        return "standard\nerror of\nradiance\nW/(m2 sr)"
    return {
        "radiosity": "radiance\nW/(m2 sr)",
        "irradiance": "irradiance\nW/m2",
        "emission": "exitance\nW/m2",
        "error": "error of\nirradiance\nW/m2",
    }[show]


def save_image(
    path: str | os.PathLike[str],
    image: Image,
    *,
    exposure: float | Literal["auto"] = "auto",
    curve: Literal["filmic", "linear", "reinhard"] = "filmic",
    false_colours: bool = False,
    legend: str | None = None,
    bands: list[str] | None = None,
) -> tuple[float, float] | None:
    """Write a linear image as ``.png`` (developed to sRGB) or ``.exr`` (linear, as it is).

    Args:
        path: the file; appears whole or not at all.
        image: (height, width, bands).
        exposure: stops, or "auto" for a mean of middle grey.
        curve: tone curve of a PNG.
        false_colours: map the mean over bands to colours instead; returns the values of the first and last colour.
        legend: with false colours, lines of text above a bar of the colours with their values, which stands on the
            right and makes the picture wider, see :func:`legend_of`; None for no bar.
        bands: channel names of an EXR. Where all are wavelengths, such as "400 nm", a PNG is developed as
            :func:`radiosity.colour.to_rgb` sees them; else three are red, green and blue, and others are grey at
            their mean.

    Raises:
        ValueError: another suffix.
    """
    suffix = Path(path).suffix.lower()
    pixels = np.ascontiguousarray(image, dtype=np.float32)
    if suffix == ".exr":
        names = bands or (["R", "G", "B"] if pixels.shape[2] == 3 else [f"band {k}" for k in range(pixels.shape[2])])
        _native.write_exr(os.fspath(path), pixels, names)
        return None
    if suffix != ".png":
        raise ValueError(f"{path}: cannot write '{suffix}' pictures; use .png or .exr")
    if false_colours:
        return _native.write_false_colours(os.fspath(path), pixels, None, None, legend)
    if bands is not None and wavelengths_of(bands) is not None:
        pixels = np.ascontiguousarray(developed(pixels, bands), dtype=np.float32)
    _native.write_png(os.fspath(path), pixels, None if exposure == "auto" else float(exposure), curve)
    return None
