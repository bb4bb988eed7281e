"""Files of a solution: lit models, arrays, ParaView."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from radiosity import _native
from radiosity.scene import Camera

if TYPE_CHECKING:
    from radiosity.patches import Patches
    from radiosity.solution import Solution

Floats = npt.NDArray[np.float64]
PathLike = str | os.PathLike[str]

SUFFIXES = (".glb", ".npz", ".vtp")
"""What :func:`save` writes."""


@dataclass(frozen=True, eq=False)
class LitModel:
    """Patches with the light on them, as a lit ``.glb`` holds it.

    The backs of two-sided patches follow all fronts as patches of their own, on surfaces named "... (back)".

    Attributes:
        patches: the native patches.
        surfaces: name, material, reflectance per band, two-sidedness, mirror reflectance, transmittance and diffuse
            transmittance per band, or none, of each.
        bands: names of the bands.
        emission, irradiance, radiosity, error: (n, bands) W/m2.
        cameras: viewpoints.
        lights: those without area, as the engine takes them: kind, name, position, direction, inner and outer angle,
            strength per band; None if a file of an earlier version does not say.
        report: the report of the solve as a dictionary.
        reflectance: (n, bands) diffuse reflectance of the patches; None if all of a surface have that of the surface.
        textures: those of the patches; a file does not keep them.
        gloss: (n, 2) what of the reflectance is of a rough metal, and how rough it is; a file does not keep it.
    """

    patches: _native.Patches
    surfaces: list[_native.LitSurfaceTuple]
    bands: list[str]
    emission: Floats
    irradiance: Floats
    radiosity: Floats
    error: Floats
    cameras: list[Camera]
    lights: list[_native.LightTuple] | None
    report: dict[str, Any]
    reflectance: Floats | None = None
    textures: _native.Textures | None = None
    gloss: Floats | None = None

    @classmethod
    def of(cls, solution: Solution) -> LitModel:
        """The lit model of a solution."""
        patches, back = solution.patches, np.flatnonzero(solution.patches.two_sided)
        native = _with_backs(solution.patches, back) if len(back) else patches._native
        scene = patches.scene
        return cls(native, bands=list(scene.bands), cameras=list(scene.cameras), **_light_of(solution, back))

    @property
    def _reflectance(self) -> Floats:
        """(n, bands) diffuse reflectance of the patches."""
        if self.reflectance is not None:
            return np.ascontiguousarray(self.reflectance)
        paint = np.array([reflectance for _, _, reflectance, *_ in self.surfaces], dtype=np.float64)
        return paint.reshape(-1, len(self.bands))[self.patches.surface]

    @property
    def _going_on(self) -> Floats | None:
        """(n, 2) mirror reflectance and transmittance of the patches; None where there is neither."""
        parts = np.array([surface[4:6] for surface in self.surfaces], dtype=np.float64)
        parts = parts.reshape(-1, 2)[self.patches.surface]
        return np.ascontiguousarray(parts) if parts.any() else None

    @property
    def _through(self) -> Floats | None:
        """(n, bands) diffuse transmittance of the patches; None where there is none."""
        bands = len(self.bands)
        spectra = np.array([surface[6] or [0.0] * bands for surface in self.surfaces], dtype=np.float64)
        return np.ascontiguousarray(spectra.reshape(-1, bands)[self.patches.surface]) if spectra.any() else None

    @property
    def _passed(self) -> Floats | float:
        """(n, bands) W/m2 of what leaves patches that arrived on their other sides; 0 where nothing passes."""
        through = self._through
        if through is None:
            return 0.0
        apart: Floats = self.radiosity - self.emission - self._reflectance * self.irradiance
        return np.where(through > 0, np.maximum(apart, 0.0), 0.0)

    def relit(self, solution: Solution) -> LitModel:
        """The same patches with the light of another solution on them.

        Raises:
            ValueError: the solution is on other patches.
        """
        back = np.flatnonzero(solution.patches.two_sided)
        if len(solution.patches) + len(back) != len(self.patches):
            raise ValueError("the solution is on other patches than the model")
        return replace(self, **_light_of(solution, back))

    def with_light(
        self, emission: Floats, irradiance: Floats, reflectance: Floats, passed: Floats | float = 0.0
    ) -> LitModel:
        """The same patches with other light and paint, (n, bands) each; of the error nothing new is known.

        ``passed`` is the part of radiosity that comes from their other sides, W/m2.
        """
        means = _means(self.patches.surface, len(self.surfaces), reflectance)
        surfaces: list[_native.LitSurfaceTuple] = [
            (*surface[:2], rho, *surface[3:]) for surface, rho in zip(self.surfaces, means, strict=True)
        ]
        return replace(
            self,
            surfaces=surfaces,
            emission=emission,
            irradiance=irradiance,
            radiosity=emission + reflectance * irradiance + passed,
            reflectance=reflectance,
            textures=None,
        )

    def _native_fields(self) -> tuple[Any, ...]:
        blocks = [np.ascontiguousarray(v) for v in (self.emission, self.irradiance, self.radiosity, self.error)]
        cameras = [c._tuple() for c in self.cameras]
        return self.patches, self.surfaces, self.bands, blocks, cameras, self.lights, json.dumps(self.report)


def _surface_reflectance(solution: Solution) -> list[list[float]]:
    """Mean over its patches of each surface's reflectance in the solution, which relighting may have changed."""
    return _means(solution.patches.surface, len(solution.patches.scene.surfaces), solution.reflectance)


def _means(surface: npt.NDArray[np.uint32], n: int, values: Floats) -> list[list[float]]:
    """Mean of each of n surfaces over its patches, by band."""
    count = np.bincount(surface, minlength=n)
    sums = np.stack([np.bincount(surface, band, n) for band in values.T], axis=1)
    return [[float(x) for x in row] for row in sums / np.maximum(count, 1)[:, None]]


def _light_of(solution: Solution, back: npt.NDArray[np.intp]) -> dict[str, Any]:
    """The fields of a lit model that are not of its geometry; ``back`` are the patches whose backs count."""
    surfaces = [
        (
            s.name,
            s.material,
            reflectance,
            False,
            *solution.patches.scene._going_on(s),
            solution.patches.scene._through(s),
        )
        for s, reflectance in zip(solution.patches.scene.surfaces, _surface_reflectance(solution), strict=True)
    ]
    if len(back):
        surfaces += [(f"{surface[0]} (back)", *surface[1:]) for surface in surfaces]
    scene = solution.patches.scene
    lights: list[_native.LightTuple] = [
        (*light._tuple(len(scene.bands))[:-1], strength)
        for light, strength in zip(scene.lights, solution.lights.tolist(), strict=True)
    ]
    sides = np.concatenate([np.arange(len(solution.patches)), back])
    return {
        "reflectance": solution.reflectance[sides],
        "textures": solution.patches._textures_in(solution.reflectance, sides),
        "gloss": None if solution.patches._gloss is None else solution.patches._gloss[sides],
        "lights": lights,
        "surfaces": surfaces,
        "emission": np.concatenate([solution.emission, solution.emission[back]]),
        "irradiance": np.concatenate([solution.irradiance, solution.back_irradiance[back]]),
        "radiosity": np.concatenate([solution.radiosity, solution.back_radiosity[back]]),
        "error": np.concatenate([solution.error, solution.back_error[back]]),
        "report": solution.report.to_dict(timed=False),
    }


def passed_through(patches: Patches, irradiance: Floats) -> Floats | float:
    """What leaves each side that arrived on the other: (n_sides, n_bands) of an irradiance of such a shape, W/m2.

    Fronts of all patches, then backs. 0 where nothing passes.
    """
    if not patches.is_translucent:
        return 0.0
    back, n = np.flatnonzero(patches.two_sided), len(patches)
    passed, through = np.zeros_like(irradiance), patches.diffuse_transmittance[back]
    passed[back], passed[n:] = through * irradiance[n:], through * irradiance[back]
    return passed


def _with_backs(p: Patches, back: npt.NDArray[np.intp]) -> _native.Patches:
    """Patches, and the backs of two-sided ones as patches and surfaces of their own."""
    triangle = np.all(p.polygons[back, 2] == p.polygons[back, 3], axis=1)
    order = np.where(triangle[:, None], [2, 1, 0, 0], [3, 2, 1, 0])
    reversed_polygons = np.take_along_axis(p.polygons[back], order[:, :, None], axis=1)
    polygons = np.concatenate([p.polygons, reversed_polygons])
    surface = np.concatenate([p.surface, p.surface[back] + np.uint32(len(p.scene.surfaces))])
    face = np.concatenate([p.face, p.face[back]])
    return _native.Patches(polygons, surface, face, np.zeros(len(polygons), dtype=bool), p.obstructions)


def load_lit(path: PathLike) -> LitModel | None:
    """Read a lit model back; None if the file is a glTF without a solution.

    Raises:
        OSError: the file cannot be read or is damaged.
    """
    fields = _native.read_lit(os.fspath(path))
    if fields is None:
        return None
    patches, surfaces, bands, blocks, cameras, lights, report = fields
    emission, irradiance, radiosity, error = blocks
    views = [Camera._from_tuple(camera) for camera in cameras]
    told = json.loads(report) if report else {}
    model = LitModel(patches, surfaces, bands, emission, irradiance, radiosity, error, views, lights, told)
    return replace(model, reflectance=_told_by_light(model))


def _told_by_light(model: LitModel) -> Floats:
    """(n, bands) the reflectance of patches by B = E + rho H, where that is not the mean of their surface.

    Textures and relighting make them differ. A file keeps the light in single precision. Of patches that light passes
    through it does not tell.
    """
    paint, arrives = model._reflectance, model.irradiance
    told = np.divide(model.radiosity - model.emission, arrives, out=paint.copy(), where=arrives > 0)
    rounding = np.divide(1e-6 * model.radiosity, arrives, out=np.zeros_like(paint), where=arrives > 0)
    most = 1.0 if model._going_on is None else 1 - model._going_on.sum(axis=1, keepdims=True)
    differs = (np.abs(told - paint) > 1e-3 + rounding) & (told >= 0) & (told <= most)
    if model._through is not None:
        differs &= ~model._through.any(axis=1, keepdims=True)
    return np.where(differs, told, paint)


def save(solution: Solution, path: PathLike) -> None:
    """Write a solution as ``.glb``, ``.npz`` or ``.vtp``; the file appears whole or not at all."""
    suffix = Path(path).suffix.lower()
    if suffix == ".npz":
        _save_arrays(solution, Path(path))
    elif suffix == ".glb":
        _native.write_lit(os.fspath(path), *LitModel.of(solution)._native_fields())
    elif suffix == ".vtp":
        _native.write_vtp(os.fspath(path), *LitModel.of(solution)._native_fields())
    else:
        raise ValueError(f"{path}: cannot write '{suffix}' files; use one of {', '.join(SUFFIXES)}")


def _save_arrays(solution: Solution, path: Path) -> None:
    """All arrays of a solution under their names in the API; strings and the report as JSON."""
    p = solution.patches
    arrays = {
        "polygons": p.polygons,
        "surface": p.surface,
        "face": p.face,
        "two_sided": p.two_sided,
        "area": p.area,
        "centre": p.centre,
        "normal": p.normal,
        "reflectance": solution.reflectance,
        "emission": solution.emission,
        "irradiance": solution.irradiance,
        "radiosity": solution.radiosity,
        "error": solution.error,
        "corner_irradiance": solution.corner_irradiance,
        "error_causes": np.array(list(solution.certificate.by_cause)),
        "error_by_cause": _stacked(solution),
        "back_irradiance": solution.back_irradiance,
        "back_radiosity": solution.back_radiosity,
        "back_error": solution.back_error,
        "bands": np.array(p.scene.bands),
        "surface_names": np.array([s.name for s in p.scene.surfaces]),
        "report": np.array(json.dumps(solution.report.to_dict(timed=False))),
    }
    if p.is_specular:
        arrays |= {"specular": p.specular, "transmittance": p.transmittance}
    if p.is_translucent:
        arrays |= {"diffuse_transmittance": p.diffuse_transmittance}
    write_whole(path, lambda file: np.savez_compressed(file, **arrays))  # type: ignore[arg-type]


def _stacked(solution: Solution) -> Floats:
    """(n_causes, n_patches, n_bands) the error of each cause."""
    by_cause = list(solution.certificate.by_cause.values())
    return np.stack(by_cause) if by_cause else np.zeros((0, *solution.error.shape))


def write_whole(path: Path, write: Callable[[IO[bytes]], object]) -> None:
    """Write a file that appears under its name when it is complete and on the disk, or not at all.

    A link is followed, and a file that is replaced hands down its permissions.
    """
    path = path.resolve()
    mode = path.stat().st_mode & 0o777 if path.exists() else 0o666 & ~_umask()
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=".radiosity-", suffix=".part")
    try:
        with os.fdopen(handle, "wb") as file:
            write(file)
            file.flush()
            os.fsync(file.fileno())
        Path(temporary).chmod(mode)
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def _umask() -> int:
    current = os.umask(0)
    os.umask(current)
    return current
