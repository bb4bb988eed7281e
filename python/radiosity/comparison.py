"""One view by several methods, side by side on one sheet, and figures that tell how they differ."""

from __future__ import annotations

import io
import math
import os
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from radiosity.colour import luminance
from radiosity.files import LitModel, write_whole
from radiosity.marking.stage import Stage, View
from radiosity.path_tracing import Source, path_trace
from radiosity.picture import SAMPLES, Image, Mode, render, save_image
from radiosity.scene import Camera, Scene
from radiosity.solution import Solution
from radiosity.teaching.figures import new_figure, style

Progress = Callable[[int, int], object]

PANELS: tuple[Mode, ...] = ("whitted", "direct", "gather", "path")
"""What is compared where nobody says: the classical comparison of ray tracing and radiosity."""

CAPTIONS: dict[Mode, tuple[str, str]] = {
    "whitted": ("Ray traced", "direct light, and the same ambient light everywhere"),
    "direct": ("Direct light only", "what comes straight from lamps"),
    "patches": ("Radiosity of patches", "one value each"),
    "smooth": ("Radiosity, interpolated", "linear between corners"),
    "gather": ("Radiosity, gathered", "every point looks at the solution once more"),
    "path": ("Path traced", "the reference, without a solution"),
}
"""What stands above each panel: a title, and what it shows."""

_LIKE_RADIOSITY: tuple[Mode, ...] = ("gather", "smooth", "patches", "path")
"""The first of these that is drawn sets the exposure of all."""


@dataclass(frozen=True, eq=False)
class Panel:
    """One picture of the view.

    Attributes:
        mode: how it is made.
        image: (height, width, bands) float32 linear radiance, W/m2/sr.
        noise: likewise, standard errors; None where they are not known.
    """

    mode: Mode
    image: Image
    noise: Image | None = None


@dataclass(frozen=True)
class Difference:
    """How far two panels are apart, relative to the mean of the second.

    Attributes:
        rms: root mean square over pixels and bands.
        noise: the part of it that the standard errors of both explain; NaN where one is not known.
    """

    rms: float
    noise: float


def draw(
    mode: Mode,
    lit: Source,
    camera: Camera | None = None,
    *,
    width: int = 480,
    height: int = 480,
    samples: int | None = None,
    ambient: npt.ArrayLike | None = None,
    threads: int | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Panel:
    """One panel, with its noise where that can be told.

    Path tracing tells it, gathers are made of two that differ by it, and what is read off the solution has none.

    Args:
        mode: as in :func:`radiosity.picture.render`, like all that follows.
    """
    view: dict[str, Any] = {"width": width, "height": height, "threads": threads, "progress": progress}
    if mode == "path":
        traced = path_trace(lit, camera, samples=samples, seed=seed, **view)
        return Panel(mode, traced.image, traced.standard_error)
    if mode == "gather":
        each = max(1, (samples or SAMPLES[mode]) // 2)
        one, two = (render(lit, camera, mode=mode, samples=each, seed=s, **view) for s in (seed, seed ^ (1 << 63)))
        return Panel(mode, 0.5 * (one + two), 0.5 * abs(one - two))
    level = ambient if mode == "whitted" else None
    image = render(lit, camera, mode=mode, samples=samples, seed=seed, ambient=level, **view)
    return Panel(mode, image, np.zeros_like(image) if mode in ("smooth", "patches") else None)


def difference(panel: Panel, reference: Panel, where: npt.NDArray[np.bool_]) -> Difference:
    """How far a panel is from a reference in some (height, width) pixels.

    Leave out those that edges run through, see :func:`off_edges`: gathers draw edges from few points, the same in every
    pixel, so that their error there is no noise.
    """
    if not where.any():
        return Difference(math.nan, math.nan)
    mean = float(reference.image[where].mean(dtype=np.float64)) or math.nan
    noise = math.nan
    if panel.noise is not None and reference.noise is not None:
        noise = math.hypot(_rms(panel.noise[where]), _rms(reference.noise[where])) / mean
    return Difference(_rms((panel.image - reference.image)[where]) / mean, noise)


def _rms(values: Image) -> float:
    return math.sqrt(float(np.mean(values.astype(np.float64) ** 2)))


def seen(lit: Solution | LitModel | Scene, camera: Camera, width: int, height: int) -> npt.NDArray[np.intp]:
    """(height, width) index of the surface that the middle of each pixel shows, -1 for none.

    Surfaces that let through or reflect light count themselves.
    """
    patches: Any = lit.patches(as_is=True) if isinstance(lit, Scene) else lit.patches
    shown_from = np.stack([np.ones(len(patches), bool), patches.two_sided], axis=1)
    nothing = np.full(len(patches), -1)
    stage = Stage(
        Scene([]), patches.polygons, patches.surface, patches.normal, shown_from, nothing, [], np.array(camera.up)
    )
    face, _ = View(stage, camera).first_hits(width, height)
    return np.where(face >= 0, np.asarray(patches.surface, dtype=np.intp)[face], -1)


def off_edges(surface: npt.NDArray[np.intp]) -> npt.NDArray[np.bool_]:
    """(height, width) pixels around which :func:`seen` is the same all around, so that no edge runs through them."""
    height, width = surface.shape
    padded = np.pad(surface, 1, mode="edge")
    around = [padded[y : y + height, x : x + width] == surface for y in range(3) for x in range(3)]
    return np.asarray(np.logical_and.reduce(around))


def common_exposure(panels: Sequence[Panel], bands: Sequence[str]) -> float:
    """Stops that give the radiosity picture among the panels a mean of middle grey, as "auto" exposes one by itself."""
    ranked = [panel for mode in _LIKE_RADIOSITY for panel in panels if panel.mode == mode] or list(panels)
    bright = luminance(ranked[0].image, bands)
    lit = bright[(bright > 0) & np.isfinite(bright)]
    return math.log2(0.18) - float(np.mean(np.log2(lit))) if lit.size else 0.0


def save_sheet(
    path: str | os.PathLike[str],
    panels: Sequence[Panel],
    bands: Sequence[str],
    *,
    exposure: float,
    columns: int | None = None,
) -> None:
    """Write panels side by side as a ``.png``, with captions.

    Args:
        path: the file; appears whole or not at all.
        panels: of one size.
        bands: names of the bands.
        exposure: stops, the same for all.
        columns: panels a row (default: all up to four).

    Raises:
        ImportError: matplotlib is not installed.
    """
    with style():
        content = _sheet(panels, bands, exposure, columns or min(4, len(panels)))
    write_whole(Path(path), lambda file: file.write(content))


_DPI = 100


def _sheet(panels: Sequence[Panel], bands: Sequence[str], exposure: float, columns: int) -> bytes:
    height, width = panels[0].image.shape[:2]
    gap = max(4, width // 60)
    letter = max(9.0, width / 26)
    head = round(3.2 * letter)
    rows = -(-len(panels) // columns)
    across, down = columns * (width + gap) + gap, rows * (height + head) + gap
    figure = new_figure(across / _DPI, down / _DPI)
    for k, panel in enumerate(panels):
        left, top = gap + k % columns * (width + gap), k // columns * (height + head)
        # Counted from the lower left corner, in whole pixels.
        figure.figimage(_screen(panel, bands, exposure), left, down - top - head - height)
        points = 72 / _DPI * letter
        for text, size, weight, at in zip(
            CAPTIONS[panel.mode], (points, 0.72 * points), ("bold", "normal"), (1.25, 2.5), strict=True
        ):
            figure.text(left / across, 1 - (top + at * letter) / down, text, fontsize=size, weight=weight, va="center")
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=_DPI)
    return file.getvalue()


def _screen(panel: Panel, bands: Sequence[str], exposure: float) -> npt.NDArray[Any]:
    """(height, width, 3) as a picture file of the panel has it."""
    from matplotlib.image import imread  # noqa: PLC0415

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "panel.png"
        save_image(path, panel.image, exposure=exposure, bands=list(bands))
        return np.asarray(imread(path))
