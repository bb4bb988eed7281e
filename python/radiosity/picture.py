"""Pictures of a solution."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from radiosity import _native
from radiosity.files import LitModel
from radiosity.scene import Camera
from radiosity.solution import Solution

Image = npt.NDArray[np.float32]
Quantity = Literal["radiosity", "irradiance", "emission", "error"]


def render(
    lit: Solution | LitModel,
    camera: Camera | None = None,
    *,
    width: int = 800,
    height: int = 600,
    samples: int = 16,
    show: Quantity = "radiosity",
    mode: Literal["smooth", "patches"] = "smooth",
    threads: int | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Image:
    """Render a solution as a camera sees it.

    Args:
        lit: a solution, or a lit model read by :func:`radiosity.files.load_lit`.
        camera: the viewpoint (default: the scene's first, or one that sees everything).
        width, height: pixels.
        samples: rays per pixel.
        show: radiosity is shown as radiance (W/m2/sr), other quantities in W/m2.
        mode: "smooth" interpolates values at corners, "patches" shows each patch's value.
        threads, progress: as in :func:`radiosity.solve`.

    Returns:
        (height, width, bands) float32, linear.
    """
    if isinstance(lit, Solution):
        lit = LitModel.of(lit)
    camera = camera or default_camera(lit)
    values: npt.NDArray[np.float64] = getattr(lit, show)
    is_radiosity = show == "radiosity"
    return _native.render(
        lit.patches, np.ascontiguousarray(values), camera._tuple(), width, height, samples,
        1 / math.pi if is_radiosity else 1.0, mode == "smooth",
        np.ascontiguousarray(lit.irradiance) if is_radiosity else None,
        [reflectance for _, _, reflectance, _ in lit.surfaces] if is_radiosity else None,
        threads, progress,
    )  # fmt: skip


def default_camera(lit: LitModel) -> Camera:
    """The first camera of the model, or one that looks at its middle from a corner outside."""
    if lit.cameras:
        return lit.cameras[0]
    points = lit.patches.polygons.reshape(-1, 3)
    low, high = points.min(axis=0), points.max(axis=0)
    middle, size = 0.5 * (low + high), float(np.linalg.norm(high - low)) or 1.0
    return Camera.look_at(middle + size * np.array([0.6, 0.5, 1.0]), middle)


def save_image(
    path: str | os.PathLike[str],
    image: Image,
    *,
    exposure: float | Literal["auto"] = "auto",
    curve: Literal["filmic", "linear", "reinhard"] = "filmic",
    false_colours: bool = False,
    bands: list[str] | None = None,
) -> tuple[float, float] | None:
    """Write a linear image as ``.png`` (developed to sRGB) or ``.exr`` (linear, as it is).

    Args:
        path: the file; appears whole or not at all.
        image: (height, width, bands).
        exposure: stops, or "auto" for a mean of middle grey.
        curve: tone curve of a PNG.
        false_colours: map the mean over bands to colours instead; returns the values of the first and last colour.
        bands: channel names of an EXR.

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
        return _native.write_false_colours(os.fspath(path), pixels, None, None)
    _native.write_png(os.fspath(path), pixels, None if exposure == "auto" else float(exposure), curve)
    return None
