"""The surface elements of a scene."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from radiosity import _native

if TYPE_CHECKING:
    from radiosity.scene import Scene

Floats = npt.NDArray[np.float64]


class Patches:
    """Planar polygons of three or four corners with stable ids, made by :meth:`radiosity.Scene.patches`.

    Attributes:
        scene: what they were cut from.
        polygons: (n, 4, 3) corners in metres, counter-clockwise from the front; a triangle repeats its last corner.
        surface, face: (n,) index of the surface and of its face that each patch was cut from.
        area: (n,) m2. centre: (n, 3) m. normal: (n, 3) unit vectors by the right-hand rule.
        two_sided: (n,) whether the back reflects too.
        obstructions: (k, 4, 3) corners of polygons that only block: opaque, black and without ids.
        cut: the arguments of :meth:`radiosity.Scene.patches`, to make the same patches again; None if unknown.

    Obstructions take part in exchange and cast shadows. Pictures do not show them; of saved solutions lit models keep
    them.
    """

    def __init__(self, scene: Scene, native: _native.Patches, cut: dict[str, Any] | None = None) -> None:
        self.scene = scene
        self.cut = cut
        self._native = native

    def __len__(self) -> int:
        return len(self._native)

    def __repr__(self) -> str:
        return f"Patches({len(self)} of {self.scene!r})"

    @cached_property
    def polygons(self) -> Floats:
        """(n, 4, 3) corners, metres."""
        return self._native.polygons

    @cached_property
    def obstructions(self) -> Floats:
        """(k, 4, 3) corners of what only blocks, metres; a triangle repeats its last."""
        return self._native.obstructions

    @cached_property
    def surface(self) -> npt.NDArray[np.uint32]:
        """(n,) index into ``scene.surfaces``."""
        return self._native.surface

    @cached_property
    def face(self) -> npt.NDArray[np.uint32]:
        """(n,) index into the surface's faces."""
        return self._native.face

    @cached_property
    def two_sided(self) -> npt.NDArray[np.bool_]:
        """(n,) whether the back reflects too."""
        return self._native.two_sided

    @cached_property
    def area(self) -> Floats:
        """(n,) m2."""
        return self._native.area

    @cached_property
    def centre(self) -> Floats:
        """(n, 3) centroids, metres."""
        return self._native.centre

    @cached_property
    def normal(self) -> Floats:
        """(n, 3) unit normals by the right-hand rule."""
        return self._native.normal

    @cached_property
    def reflectance(self) -> Floats:
        """(n, bands) diffuse reflectance; where there is a texture, its mean over the patch."""
        own = self._per_patch([s.reflectance for s in self.scene.surfaces])
        return own if self._textures is None else self._textures.with_means(self._native, own)

    @cached_property
    def _textures(self) -> _native.Textures | None:
        if all(s.texture is None for s in self.scene.surfaces):
            return None
        return _native.Textures(self.scene._native(), self._native)

    def _textures_in(self, reflectance: Floats, which: npt.NDArray[np.intp] | None = None) -> _native.Textures | None:
        """Those of (k,) patches, by default all; none where (n, bands) reflectance is of other paint."""
        if self._textures is None:
            return None
        chosen = np.arange(len(self)) if which is None else which
        shows: npt.NDArray[np.bool_] = np.all(reflectance == self.reflectance, axis=1)
        return self._textures.picked(chosen.astype(np.uint32), shows[chosen])

    @cached_property
    def _gloss(self) -> Floats | None:
        """(n, 2) what of the reflectance is of a rough metal, and how rough it is; None where there is none."""
        if not any(s.metallic for s in self.scene.surfaces):
            return None
        return np.array([(s.metallic, s.roughness) for s in self.scene.surfaces], dtype=float)[self.surface]

    def _mean_reflectance(self) -> list[list[float]]:
        """Of each surface; of those with a texture, the mean over their patches by area."""
        bands = len(self.scene.bands)
        means = [np.broadcast_to(np.asarray(s.reflectance, dtype=float), (bands,)) for s in self.scene.surfaces]
        for k in (k for k, s in enumerate(self.scene.surfaces) if s.texture is not None):
            on = self.surface == k
            if self.area[on].any():
                means[k] = self.area[on] @ self.reflectance[on] / self.area[on].sum()
        return [mean.tolist() for mean in means]

    @cached_property
    def emission(self) -> Floats:
        """(n, bands) radiant exitance, W/m2."""
        return self._per_patch([s.emission for s in self.scene.surfaces])

    @cached_property
    def specular(self) -> Floats:
        """(n,) mirror reflectance, the same in all bands."""
        return self._going_on[:, 0]

    @cached_property
    def transmittance(self) -> Floats:
        """(n,) what passes straight through, the same in all bands."""
        return self._going_on[:, 1]

    @cached_property
    def diffuse_transmittance(self) -> Floats:
        """(n, bands) what leaves the other side diffusely."""
        return self._per_patch([s.diffuse_transmittance for s in self.scene.surfaces])

    @cached_property
    def is_translucent(self) -> bool:
        """Whether light passes through any patch diffusely."""
        return any(bool(np.any(s.diffuse_transmittance)) for s in self.scene.surfaces)

    @property
    def _through(self) -> Floats | None:
        """Diffuse transmittance for the engine; None where there is none."""
        return np.ascontiguousarray(self.diffuse_transmittance) if self.is_translucent else None

    @cached_property
    def _going_on(self) -> Floats:
        if not self.scene.surfaces:
            return np.zeros((len(self), 2))  # patches without a scene of their own
        parts = [self.scene._going_on(surface) for surface in self.scene.surfaces]
        return np.array(parts, dtype=np.float64).reshape(-1, 2)[self.surface]

    @cached_property
    def is_specular(self) -> bool:
        """Whether any patch is a mirror or lets light through."""
        return bool(self._going_on.any())

    def _per_patch(self, spectra: list[npt.ArrayLike]) -> Floats:
        bands = len(self.scene.bands)
        table = np.array([np.broadcast_to(np.asarray(s, dtype=np.float64), (bands,)) for s in spectra])
        return table.reshape(-1, bands)[self.surface]

    @cached_property
    def _enclosure(self) -> _native.Enclosure:
        if not self.is_specular:
            return _native.Enclosure(self._native)
        specular, transmittance = (np.ascontiguousarray(part) for part in (self.specular, self.transmittance))
        return _native.Enclosure(self._native, None, specular, transmittance)

    def _demand_opaque(self, way: str, remedy: str = "solve with transport='sampled', or ") -> None:
        """Refuse what lets light through diffusely, for a ``way`` to solve that takes patches for opaque.

        Raises:
            ValueError: there is any; the message names a surface.
        """
        name = next((s.name for s in self.scene.surfaces if np.any(s.diffuse_transmittance)), None)
        if name is not None:
            raise ValueError(
                f"surface '{name}' lets light through diffusely, which {way} cannot follow: {remedy}"
                "set its diffuse_transmittance to 0"
            )

    def _diffuse_enclosure(self, way: str) -> _native.Enclosure:
        """The enclosure for a ``way`` to solve that follows no light by mirrors and glass, or through leaves.

        Raises:
            ValueError: there are any; the message names a surface.
        """
        self._demand_opaque(way)
        if self.is_specular:
            surface = self.scene.surfaces[int(self.surface[np.flatnonzero(self._going_on.any(axis=1))[0]])]
            what = "is a mirror" if np.any(surface.specular) else "lets light through"
            raise ValueError(
                f"surface '{surface.name}' {what}, which {way} cannot follow: solve with transport='sampled', or "
                "set its specular and transmittance to 0"
            )
        return self._enclosure
