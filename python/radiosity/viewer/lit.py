"""What is shown: patches and, lamp by lamp or all together, the light on them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from radiosity import _native
from radiosity.files import LitModel
from radiosity.picture import default_camera
from radiosity.scene import Camera
from radiosity.viewer.messages import VERSION, CameraHead, LampHead, LightHead, SceneHead, SurfaceHead
from radiosity.viewer.packet import pack

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Lit:
    """A lit model, with the light of its lamps in layers that add up to it.

    Attributes:
        model: patches, surfaces, cameras, and all the light.
        layers: the light of each lamp on the same patches; only the model's if there are none.
        lamps: what each layer is of, or what can be switched by a relight.
        unit: "W/m2" or "lux".
        title: for the page.
        is_lit: whether there is light in it yet.
        up: the axis that is up.
    """

    model: LitModel
    layers: Sequence[LitModel] = ()
    lamps: Sequence[LampHead] = ()
    unit: str = "W/m2"
    title: str = "radiosity"
    is_lit: bool = True
    up: tuple[float, float, float] = field(default=(0.0, 1.0, 0.0))

    def scene_packet(self) -> bytes:
        """Patches, surfaces, cameras and light."""
        model = self.model
        polygons = model.patches.polygons
        low, high = polygons.min(axis=(0, 1)), polygons.max(axis=(0, 1))
        origin = 0.5 * (low + high)
        head = SceneHead(
            version=VERSION, title=self.title, bands=list(model.bands), unit=self.unit, origin=_triple(origin),
            up=self.up, surfaces=_surfaces(model), lamps=list(self.lamps),
            cameras=[
                CameraHead(c.name, _triple(np.subtract(c.position, origin)), _triple(c.forward), _triple(c.up),
                           c.vertical_fov)
                for c in model.cameras or [default_camera(model)]
            ],
            is_layered=bool(self.layers), is_lit=self.is_lit, is_field=bool(model.report.get("of_field", False)),
            report=model.report,
        )  # fmt: skip
        return pack(head, {"polygons": polygons - origin, "surface": model.patches.surface, **self._light()})

    def light_packet(self, seconds: float, *, is_final: bool = True) -> bytes:
        """The light alone, for a page that has the patches."""
        reflectance = [list(rho) for _, _, rho, *_ in self.model.surfaces]
        return pack(LightHead(reflectance, seconds, is_final, self.model.report), self._light())

    def _light(self) -> dict[str, npt.NDArray[Any]]:
        models = self.layers or [self.model]
        return {
            # The page knows reflection alone: what passes through patches shines for it.
            "emission": np.stack([m.emission + m._passed for m in models]),
            "irradiance": np.stack([m.irradiance for m in models]),
            "corner_irradiance": np.stack([corner_irradiance(m) for m in models]),
            "error": np.nan_to_num(self.model.error),
        }


def corner_irradiance(model: LitModel) -> Floats:
    """(n, 4, bands) W/m2: the field at the corners of patches, as pictures show it; never below zero."""
    return np.maximum(_native.corner_field(model.patches, np.ascontiguousarray(model.irradiance)), 0.0)


def up_axis(cameras: Iterable[Camera]) -> tuple[float, float, float]:
    """The axis that is up for all cameras, as near as an axis can be; y if they do not agree."""
    axes = set()
    for camera in cameras:
        k = int(np.argmax(np.abs(camera.up)))
        axes.add((k, float(np.sign(camera.up[k]))))
    axis, sign = axes.pop() if len(axes) == 1 else (1, 1.0)
    return _triple(sign * np.eye(3)[axis])


def _surfaces(model: LitModel) -> list[SurfaceHead]:
    surface, area, n = model.patches.surface, model.patches.area, len(model.surfaces)
    whole = np.maximum(np.bincount(surface, area, n), 1e-300)
    emission = np.stack([np.bincount(surface, area * band, n) / whole for band in model.emission.T], axis=1)
    return [
        SurfaceHead(name, material, list(rho), emission[k].tolist(), float(whole[k]))
        for k, (name, material, rho, *_) in enumerate(model.surfaces)
    ]


def _triple(values: npt.ArrayLike) -> tuple[float, float, float]:
    x, y, z = np.asarray(values, dtype=np.float64).tolist()
    return x, y, z
