"""Images on surfaces."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import numpy.typing as npt

from radiosity import _native
from radiosity._native import SceneError

Wrap = Literal["repeat", "clamp", "mirror"]


@dataclass(eq=False)
class Texture:
    """An image on a surface that its diffuse reflectance is multiplied with, point by point.

    A patch reflects the mean over it, exact but for rounding; pictures show what is at each point, interpolated between
    the four nearest texels.

    Args:
        image: (height, width), (height, width, 1) or (height, width, 3), the upper row first: ``uint8`` in sRGB, or
            float, linear and in [0, 1]. One channel serves any number of bands, three are for scenes of three bands. An
            image of a loaded scene is a native one, which surfaces share; :meth:`values` has its numbers.
        uv: (n_vertices, 2) texture coordinates as in glTF: (0, 0) is the upper left corner of the image, (1, 1) the
            lower right one. Of a triangle they are interpolated linearly; a quad is two triangles, parted by the
            diagonal from its first corner.
        wrap: what is beyond the edges, one for u and v or one each: the image again ("repeat"), its outermost texels
            ("clamp"), or the image turned over ("mirror").

    Bytes take one byte a texel and channel, floats four.

    Raises:
        SceneError: a shape or a value is not as it must be.
    """

    image: npt.ArrayLike | _native.Raster
    uv: npt.ArrayLike
    wrap: Wrap | tuple[Wrap, Wrap] = "repeat"
    _raster: _native.Raster = field(init=False, repr=False)

    def __post_init__(self) -> None:
        uv = np.ascontiguousarray(self.uv, dtype=np.float64)
        if uv.ndim != 2 or uv.shape[1] != 2:
            raise SceneError(f"texture: uv must have shape (n_vertices, 2), not {uv.shape}")
        is_finite = np.isfinite(uv).all(axis=1)
        if not is_finite.all():
            raise SceneError(f"texture: coordinate {int(np.argmin(is_finite))} is not finite")
        self.uv = uv
        wrap = (self.wrap, self.wrap) if isinstance(self.wrap, str) else tuple(self.wrap)
        try:
            self._raster = _raster(self.image, wrap)
        except ValueError as e:
            raise SceneError(f"texture: {e}") from e

    def __repr__(self) -> str:
        height, width, channels = self._raster.shape
        return f"Texture({height} x {width} x {channels}, wrap={self.wrap!r})"

    @property
    def channels(self) -> int:
        """1 or 3."""
        return self._raster.shape[2]

    def values(self) -> npt.NDArray[np.float32]:
        """(height, width, channels) linear values of the texels."""
        return self._raster.values()

    @classmethod
    def _from_native(cls, fields: tuple[_native.Raster, npt.NDArray[np.float64]] | None) -> Texture | None:
        if fields is None:
            return None
        raster, uv = fields
        return cls(raster, uv, raster.wrap)

    def _native(self) -> tuple[_native.Raster, npt.NDArray[np.float64]]:
        return self._raster, np.asarray(self.uv, np.float64)


def _raster(image: npt.ArrayLike | _native.Raster, wrap: tuple[str, ...]) -> _native.Raster:
    if len(wrap) != 2:
        raise ValueError(f"wrap is one mode or two, not {wrap}")
    if isinstance(image, _native.Raster):
        return image if image.wrap == wrap else image.with_wrap((wrap[0], wrap[1]))
    texels = np.asarray(image)
    if texels.ndim == 2:
        texels = texels[:, :, None]
    if texels.ndim != 3:
        raise ValueError(f"an image has shape (height, width) or (height, width, channels), not {texels.shape}")
    if texels.dtype == np.uint8:
        return _native.Raster.of_bytes(np.ascontiguousarray(texels), (wrap[0], wrap[1]))
    if not np.issubdtype(texels.dtype, np.floating):
        raise ValueError(f"an image is of uint8 or floats, not {texels.dtype}")
    return _native.Raster.of_values(np.ascontiguousarray(texels, dtype=np.float32), (wrap[0], wrap[1]))
