"""Files of form factors that are read where they are mapped, ``.exchange``, and measured onto them."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from radiosity import _native
from radiosity.checks import memory_or_most
from radiosity.factors import FormFactors
from radiosity.patches import Patches

if TYPE_CHECKING:
    from radiosity.scene import Scene

PathLike = str | os.PathLike[str]

SUFFIX = ".exchange"


def is_exchange(path: PathLike) -> bool:
    """Whether a name is that of such a file."""
    return Path(path).suffix.lower() == SUFFIX


def partial_name(path: PathLike) -> Path:
    """Where a file is while it is built."""
    # A link is followed; else the name is left as the user knows it.
    target = Path(path).resolve() if Path(path).is_symlink() else Path(path)
    return target.with_name(target.name + ".partial")


def describe(patches: Patches, method: str, tolerance: float | None) -> str:
    """What the file says, beside numbers and geometry, so that it can be opened alone."""
    scene, bands = patches.scene, len(patches.scene.bands)
    surfaces = [
        {
            "name": surface.name,
            "reflectance": reflectance,
            "emission": np.broadcast_to(np.asarray(surface.emission, float), bands).tolist(),
        }
        for surface, reflectance in zip(scene.surfaces, patches._mean_reflectance(), strict=True)
    ]
    combined = [[int(part), int(whole)] for part, whole in scene.combined.items()]
    return json.dumps(
        {
            "method": method,
            "tolerance": tolerance,
            "cut": patches.cut,
            "bands": list(scene.bands),
            "combined": combined,
            "surfaces": surfaces,
        }
    )


class ExchangeFile:
    """An open file: its patches and settings, and form factors on them or on the same patches of a scene.

    Attributes:
        path: where it is.
        cut: how its patches were cut, as :attr:`radiosity.Patches.cut`.

    Raises:
        ValueError: the file is foreign, newer, truncated or damaged; OSError: it cannot be read.
    """

    def __init__(self, path: PathLike, *, verify: bool = False) -> None:
        self.path = path
        self._native = _native.ExchangeFile(os.fspath(path), verify)
        try:
            self._told: dict[str, Any] = json.loads(self._native.description)
            self.cut: dict[str, Any] | None = self._told["cut"]
            if self.cut is not None:
                # Files from before there were lines of contact do not speak of them.
                self.cut.setdefault("contacts", False)
        except (KeyError, TypeError, ValueError) as e:
            raise ValueError(f"{path}: the file does not say what it holds ({e})") from e

    def factors(self, patches: Patches | None = None, memory_limit: int | None = None) -> FormFactors:
        """The form factors, on patches made from the file unless others are given. Only once.

        If the file is larger than ``memory_limit`` bytes (default: four fifths of what is available), what is read of
        it does not stay in memory.

        Raises:
            ValueError: they were measured between other patches, or the file is damaged.
        """
        patches = self.patches() if patches is None else patches
        native = self._native.factors(patches._diffuse_enclosure("form factors"), memory_or_most(memory_limit))
        return FormFactors(patches, native, self._told["method"], self._told["tolerance"])

    def patches(self) -> Patches:
        """The patches with the reflectance and emission of their surfaces."""
        native = self._native.patches
        try:
            scene = self._scene(native)
        except (KeyError, TypeError, ValueError, IndexError) as e:
            raise ValueError(f"{self.path}: its surfaces are not those of its patches ({e})") from e
        return Patches(scene, native, self.cut)

    def _scene(self, native: _native.Patches) -> Scene:
        from radiosity.factor_files import scene_of  # noqa: PLC0415

        surfaces = self._told["surfaces"]
        return scene_of(
            {
                "polygons": native.polygons,
                "surface": native.surface,
                "two_sided": native.two_sided,
                "obstructions": native.obstructions,
                "surface_names": np.array([s["name"] for s in surfaces]),
                "reflectance": np.array([s["reflectance"] for s in surfaces])[native.surface],
                "emission": np.array([s["emission"] for s in surfaces])[native.surface],
                "bands": np.array(self._told["bands"]),
                "combined": np.array(self._told["combined"], dtype=np.int64).reshape(-1, 2),
            }
        )


def save_exchange(factors: FormFactors, path: PathLike) -> None:
    """Write form factors; the file appears whole or not at all."""
    description = describe(factors.patches, factors.report.method, factors.report.tolerance)
    factors._native.save(os.fspath(path), description)
