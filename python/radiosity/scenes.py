"""Built-in scenes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np
import numpy.typing as npt

from radiosity import _native
from radiosity.city import city
from radiosity.cornell_spectra import cornell_box_spectral
from radiosity.crater import crater
from radiosity.ferren import ferren
from radiosity.goral import goral_box
from radiosity.lampshade import lampshade
from radiosity.mirror_room import mirror_room
from radiosity.scene import Scene


def _spectrum(values: npt.ArrayLike) -> list[float]:
    return [float(x) for x in np.atleast_1d(np.asarray(values, dtype=np.float64))]


def cornell_box(variant: Literal["rgb", "original"] = "rgb") -> Scene:
    """The Cornell box with two blocks (Cornell University Program of Computer Graphics, 1985-1998).

    "rgb" squares the measured box (exact rectangles, one surface per face); "original" keeps the measured vertices.
    """
    names = {"rgb": "cornell_box", "original": "cornell_box_original"}
    if variant not in names:
        raise ValueError(f"there is no variant '{variant}' of the Cornell box; choose rgb or original")
    return Scene._from_native(_native.builtin(names[variant], [], []))


def furnace(reflectance: npt.ArrayLike = 0.5, emission: npt.ArrayLike = 1.0) -> Scene:
    """A closed box with boxes inside where every surface has the same reflectance and emission.

    Everywhere B = E / (1 - rho), whatever the shapes.
    """
    rho, exitance = np.broadcast_arrays(np.atleast_1d(reflectance), np.atleast_1d(emission))
    return Scene._from_native(_native.builtin("furnace", [], [_spectrum(rho), _spectrum(exitance)]))


def two_plates(
    width: float = 1.0,
    depth: float = 1.0,
    gap: float = 1.0,
    reflectance: tuple[npt.ArrayLike, npt.ArrayLike] = (0.5, 0.5),
    emission: tuple[npt.ArrayLike, npt.ArrayLike] = (1.0, 0.0),
) -> Scene:
    """Two parallel plates face to face, the lower one first."""
    arrays = np.broadcast_arrays(*(np.atleast_1d(a) for a in (*reflectance, *emission)))
    lower_rho, upper_rho, lower_e, upper_e = (_spectrum(a) for a in arrays)
    return Scene._from_native(
        _native.builtin("two_plates", [width, depth, gap], [lower_rho, lower_e, upper_rho, upper_e])
    )


def cornell_box_original() -> Scene:
    """The Cornell box as it was measured: faces that are rectangles only to a few millimetres."""
    return cornell_box("original")


def furnished_room(detail: int = 1) -> Scene:
    """A closed, furnished room with lamps, a window and three cameras; ``detail`` from 0 to 8 sets its faces."""
    if not 0 <= detail <= 8:
        raise ValueError(f"detail is a number from 0 to 8, not {detail}")
    return Scene._from_native(_native.builtin("furnished_room", [float(detail)], []))


BUILTIN_SCENES: dict[str, Callable[[], Scene]] = {
    "cornell-box": cornell_box,
    "cornell-box-original": cornell_box_original,
    "cornell-box-spectral": cornell_box_spectral,
    "city": city,
    "crater": crater,
    "ferren": ferren,
    "furnished-room": furnished_room,
    "furnace": furnace,
    "goral-box": goral_box,
    "lampshade": lampshade,
    "mirror-room": mirror_room,
    "two-plates": two_plates,
}
"""Built-in scenes by the name that the command line knows them by; the docstring's first line describes each."""
