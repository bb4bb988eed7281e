"""Scenes: surfaces with materials, lights and cameras, from files or from arrays."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt

from radiosity import _native
from radiosity._native import SceneError
from radiosity.texture import Texture

if TYPE_CHECKING:
    from radiosity.patches import Patches

Floats = npt.NDArray[np.float64]
Triple = tuple[float, float, float]


def _spectrum(values: npt.ArrayLike, bands: int, what: str) -> list[float]:
    """Broadcast a number or a sequence to one value per band."""
    array = np.asarray(values, dtype=np.float64)
    if array.ndim > 1 or (array.ndim == 1 and len(array) not in (1, bands)):
        raise SceneError(f"{what} has shape {array.shape}; give one number or one per band ({bands})")
    return [float(x) for x in np.broadcast_to(array, (bands,))]


def _grey(values: npt.ArrayLike, bands: int, what: str) -> float:
    """One number of what is the same in all bands."""
    spectrum = _spectrum(values, bands, what)
    if len(set(spectrum)) > 1:
        raise SceneError(f"{what} differs between bands, and mirrors and glass are grey; give one number")
    return spectrum[0] if spectrum else 0.0


def _bands_of(values: npt.ArrayLike) -> int:
    array = np.asarray(values)
    return int(array.shape[0]) if array.ndim else 1


def _triple(values: Sequence[float] | Floats, what: str) -> Triple:
    array = np.asarray(values, dtype=np.float64)
    if array.shape != (3,):
        raise SceneError(f"{what} must be three numbers, not an array of shape {array.shape}")
    return float(array[0]), float(array[1]), float(array[2])


def _unit(direction: Sequence[float] | Floats, light: str) -> Triple:
    """The direction of a light, scaled to length 1."""
    x, y, z = _triple(direction, f"the direction of light '{light}'")
    length = math.hypot(x, y, z)
    if not 0 < length < math.inf:
        raise SceneError(f"light '{light}': its direction ({x}, {y}, {z}) points nowhere; give one with a length")
    return x / length, y / length, z / length


@dataclass(eq=False)
class Surface:
    """Polygons that share one material.

    Of what meets a surface, diffuse reflectance, diffuse transmittance, mirror reflectance and transmittance are parts,
    which together stay below 1 in every band; the rest is absorbed. An ideal mirror or pane, of reflectance 0, may send
    on all of it.

    Args:
        vertices: (n, 3) float, metres.
        faces: (m, 3) or (m, 4) int, counter-clockwise seen from the front. Quads must be planar and convex.
        reflectance: diffuse reflectance in [0, 1), a number or one per band.
        emission: radiant exitance in W/m2, a number or one per band; pi times the radiance of a Lambertian emitter.
        name: for messages and files.
        two_sided: whether both sides reflect and emit; the back of a one-sided surface is black, and opaque but for its
            transmittance.
        material: the material's name, for files.
        specular: mirror reflectance in [0, 1], the same in all bands: what goes on as from a plane mirror.
        transmittance: what passes straight through, as through a thin sheet of clear glass and from either side, in
            [0, 1], the same in all bands.
        diffuse_transmittance: what leaves the other side diffusely, as of paper and leaves and from either side, in
            [0, 1), a number or one per band. A surface that has any is two-sided.
        texture: an image that multiplies ``reflectance``, with a place on it for each vertex.
        metallic: what of ``reflectance`` is of a rough metal, in [0, 1]. The solve takes it for diffuse; pictures of
            mode "gather" or "path" show its lobe (GGX; Walter et al. 2007) where a camera looks at it, which reflects
            that part of ``reflectance`` at right angles.
        roughness: of the metal, from 0, a mirror, to 1; the width of the lobe is its square, as in glTF.
    """

    vertices: npt.ArrayLike
    faces: npt.ArrayLike
    reflectance: npt.ArrayLike = 0.5
    emission: npt.ArrayLike = 0.0
    name: str = ""
    two_sided: bool = False
    material: str = ""
    specular: npt.ArrayLike = 0.0
    transmittance: npt.ArrayLike = 0.0
    diffuse_transmittance: npt.ArrayLike = 0.0
    texture: Texture | None = None
    metallic: float = 0.0
    roughness: float = 1.0

    def __post_init__(self) -> None:
        vertices, faces = np.asarray(self.vertices, dtype=np.float64), np.asarray(self.faces)
        if vertices.size and (vertices.ndim != 2 or vertices.shape[1] != 3):
            raise SceneError(f"surface '{self.name}': vertices must have shape (n, 3), not {vertices.shape}")
        if faces.size and not np.issubdtype(faces.dtype, np.integer):
            raise SceneError(f"surface '{self.name}': faces must be integers, not {faces.dtype}")
        if faces.size and (faces.ndim != 2 or faces.shape[1] not in (3, 4)):
            raise SceneError(f"surface '{self.name}': faces must have shape (m, 3) or (m, 4), not {faces.shape}")
        self.vertices = np.ascontiguousarray(vertices if vertices.size else np.zeros((0, 3)))
        self.faces = np.ascontiguousarray(faces if faces.size else np.zeros((0, 3)), dtype=np.int64)
        self.two_sided = self.two_sided or bool(np.any(self.diffuse_transmittance))
        if self.texture is not None and len(np.asarray(self.texture.uv)) != len(self.vertices):
            raise SceneError(
                f"surface '{self.name}': its texture has {len(np.asarray(self.texture.uv))} coordinates for "
                f"{len(self.vertices)} vertices; give one pair each"
            )


@dataclass(eq=False)
class PointLight:
    """A light without area that shines equally in all directions: ``intensity`` in W/sr per band."""

    position: Sequence[float]
    intensity: npt.ArrayLike
    name: str = "point light"

    def _tuple(self, bands: int) -> _native.LightTuple:
        power = _spectrum(self.intensity, bands, f"the intensity of light '{self.name}'")
        return "point", self.name, _triple(self.position, "position"), (0.0, 0.0, 0.0), 0.0, 0.0, power


@dataclass(eq=False)
class SpotLight:
    """A light that shines within a cone: ``intensity`` in W/sr on its axis, half angles in radians.

    Between the inner and the outer angle it falls off as ``KHR_lights_punctual`` says.
    """

    position: Sequence[float]
    direction: Sequence[float]
    intensity: npt.ArrayLike
    inner_angle: float = 0.0
    outer_angle: float = math.pi / 4
    name: str = "spot light"

    def _tuple(self, bands: int) -> _native.LightTuple:
        if not 0 <= self.inner_angle < self.outer_angle <= math.pi / 2:
            raise SceneError(f"light '{self.name}': angles must satisfy 0 <= inner < outer <= pi/2")
        power = _spectrum(self.intensity, bands, f"the intensity of light '{self.name}'")
        position, direction = _triple(self.position, "position"), _unit(self.direction, self.name)
        return "spot", self.name, position, direction, self.inner_angle, self.outer_angle, power


@dataclass(eq=False)
class DirectionalLight:
    """Parallel light that travels along ``direction``: ``irradiance`` in W/m2 on a surface that faces it."""

    direction: Sequence[float]
    irradiance: npt.ArrayLike
    name: str = "directional light"

    def _tuple(self, bands: int) -> _native.LightTuple:
        power = _spectrum(self.irradiance, bands, f"the irradiance of light '{self.name}'")
        return "directional", self.name, (0.0, 0.0, 0.0), _unit(self.direction, self.name), 0.0, 0.0, power


Light = PointLight | SpotLight | DirectionalLight


@dataclass(frozen=True)
class Camera:
    """A perspective viewpoint: unit vectors ``forward`` and ``up``, full vertical angle of view in radians."""

    position: Triple
    forward: Triple
    up: Triple = (0.0, 1.0, 0.0)
    vertical_fov: float = math.radians(45)
    aspect: float | None = None
    name: str = "camera"

    @classmethod
    def look_at(
        cls,
        position: Sequence[float],
        target: Sequence[float],
        up: Sequence[float] = (0.0, 1.0, 0.0),
        vertical_fov: float = math.radians(45),
        name: str = "camera",
    ) -> Camera:
        """A camera at ``position`` that looks at ``target``."""
        forward = np.asarray(target, dtype=float) - np.asarray(position, dtype=float)
        length = float(np.linalg.norm(forward))
        if not length > 0:
            raise SceneError(f"camera '{name}': position and target coincide")
        return cls(_triple(position, "position"), _triple(forward / length, "forward"), _triple(up, "up"), vertical_fov,
                   name=name)  # fmt: skip

    @classmethod
    def _from_tuple(cls, fields: _native.CameraTuple) -> Camera:
        name, position, forward, up, vertical_fov, aspect = fields
        place, ahead, above = (_triple(v, f"camera '{name}'") for v in (position, forward, up))
        return cls(place, ahead, above, vertical_fov, aspect, name)

    def _tuple(self) -> _native.CameraTuple:
        return self.name, self.position, self.forward, self.up, self.vertical_fov, self.aspect


def _none(*shape: int) -> npt.NDArray[np.float64]:
    return np.zeros((0, *shape))


@dataclass(frozen=True)
class Finding:
    """One thing noticed about a scene: ``severity`` is note, warning or error.

    Args:
        severity: how bad it is; a scene with an error cannot be lit.
        code: a stable kind, such as ``zero-area-faces``.
        element: the element concerned, such as ``surface 'floor', face 12``.
        message: what is wrong and what to do.
        surface: index of the surface concerned.
        faces: (k,) int, faces of that surface; where there are none, the whole of it is meant.
        edges: (k, 2, 3) float, stretches of edges in metres: rims of holes, joints, outlines of overlaps.
        points: (k, 3) float, metres.

    At most 10,000 faces, edges and points are kept. Two findings are equal if they say the same.
    """

    severity: Literal["note", "warning", "error"]
    code: str
    element: str
    message: str
    surface: int | None = None
    faces: npt.NDArray[np.uint32] = field(default_factory=lambda: np.zeros(0, np.uint32), repr=False, compare=False)
    edges: Floats = field(default_factory=lambda: _none(2, 3), repr=False, compare=False)
    points: Floats = field(default_factory=lambda: _none(3), repr=False, compare=False)

    def __str__(self) -> str:
        where = f"{self.element}: " if self.element else ""
        return f"{self.severity} [{self.code}]: {where}{self.message}"


@dataclass(eq=False)
class Scene:
    """Surfaces, lights and cameras.

    Args:
        surfaces: what reflects and emits.
        lights: lights without area.
        cameras: viewpoints.
        name: for messages.
        bands: names of the wavelength bands; inferred from the longest spectrum if not given.
        loading_findings: what the loader noticed.
        obstructions: surfaces that only block: opaque from both sides, black, cut into no patches. Their materials are
            ignored, and pictures and saved solutions leave them out.
        combined: index of a surface -> index of the surface it counts with in tables of factors, which itself counts
            with none. Files in View3D's format have it.
        hints: what the file asks of a computation of factors, by name: ``tolerance``, ``enclosure`` (the surfaces
            enclose a space) and ``emissivity`` (factors with reflections), both True, ``row`` and ``column`` (index of
            the only surface wanted). Only :meth:`findings` obeys any of it.
    """

    surfaces: list[Surface]
    lights: list[Light] = field(default_factory=list)
    cameras: list[Camera] = field(default_factory=list)
    name: str = "scene"
    bands: list[str] = field(default_factory=list)
    loading_findings: list[Finding] = field(default_factory=list, repr=False)
    obstructions: list[Surface] = field(default_factory=list)
    combined: dict[int, int] = field(default_factory=dict)
    hints: dict[str, float | int | bool] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.surfaces, self.lights, self.cameras = list(self.surfaces), list(self.lights), list(self.cameras)
        for index, surface in enumerate(self.surfaces):
            surface.name = surface.name or f"surface {index}"
        self.obstructions = list(self.obstructions)
        for index, obstruction in enumerate(self.obstructions):
            obstruction.name = obstruction.name or f"obstruction {index}"
        if not self.bands:
            self.bands = _band_names(self._longest_spectrum())

    def _longest_spectrum(self) -> int:
        spectra = [s.reflectance for s in self.surfaces] + [s.emission for s in self.surfaces]
        spectra += [s.diffuse_transmittance for s in self.surfaces]
        spectra += [li.irradiance if isinstance(li, DirectionalLight) else li.intensity for li in self.lights]
        channels = [s.texture.channels for s in self.surfaces if s.texture is not None]
        return max([*(_bands_of(s) for s in spectra), *channels], default=1)

    def __repr__(self) -> str:
        faces = sum(len(np.asarray(s.faces)) for s in self.surfaces)
        obstructions = f"{len(self.obstructions)} obstructions, " if self.obstructions else ""
        return (
            f"Scene('{self.name}', {len(self.surfaces)} surfaces, {faces} faces, {obstructions}"
            f"{len(self.lights)} lights, {len(self.cameras)} cameras, bands {', '.join(self.bands)})"
        )

    @classmethod
    def _from_native(cls, native: _native.Scene) -> Scene:
        surfaces = [_surface(fields) for fields in native.surfaces()]
        obstructions = [_surface(fields) for fields in native.obstructions()]
        lights = [_light(fields) for fields in native.lights()]
        cameras = [Camera._from_tuple(fields) for fields in native.cameras()]
        findings = [Finding(*f) for f in native.loading_findings()]
        return cls(surfaces, lights, cameras, native.name, native.bands, findings, obstructions, native.combined(),
                   native.hints())  # fmt: skip

    def _native(self) -> _native.Scene:
        n = len(self.bands)
        surfaces = [
            (s.name, np.asarray(s.vertices, np.float64), np.asarray(s.faces, np.int64), s.material,
             _spectrum(s.reflectance, n, f"reflectance of surface '{s.name}'"),
             _spectrum(s.emission, n, f"emission of surface '{s.name}'"), s.two_sided, *self._going_on(s),
             self._through(s), None if s.texture is None else s.texture._native(),
             (float(s.metallic), float(s.roughness)))
            for s in self.surfaces
        ]  # fmt: skip
        obstructions: list[_native._SurfaceIn] = [
            (s.name, np.asarray(s.vertices, np.float64), np.asarray(s.faces, np.int64), s.material,
             [0.0] * n, [0.0] * n, False, 0.0, 0.0, [], None, (0.0, 1.0))
            for s in self.obstructions
        ]  # fmt: skip
        lights, cameras = [light._tuple(n) for light in self.lights], [camera._tuple() for camera in self.cameras]
        bands, combined = list(self.bands), dict(self.combined)
        if any(index < 0 for pair in combined.items() for index in pair):
            raise SceneError(f"{self.name}: combined has a negative index; surfaces count from 0")
        return _native.Scene(self.name, bands, surfaces, lights, cameras, obstructions, combined)

    def _going_on(self, surface: Surface) -> tuple[float, float]:
        """The parts that a surface reflects as a mirror does and lets through."""
        n = len(self.bands)
        specular = _grey(surface.specular, n, f"specular of surface '{surface.name}'")
        return specular, _grey(surface.transmittance, n, f"transmittance of surface '{surface.name}'")

    def _through(self, surface: Surface) -> list[float]:
        """Diffuse transmittance per band; empty where there is none."""
        what = f"diffuse_transmittance of surface '{surface.name}'"
        spectrum = _spectrum(surface.diffuse_transmittance, len(self.bands), what)
        return spectrum if any(spectrum) else []

    def findings(self, *, enclosure: bool | None = None) -> list[Finding]:
        """Everything worth knowing before lighting the scene, worst first.

        Args:
            enclosure: whether the surfaces should enclose a space, so that open edges are worth a note; as the hints
                say by default.
        """
        native = self._native()
        found = self.loading_findings + [Finding(*f) for f in native.findings()]
        if bool(self.hints.get("enclosure")) if enclosure is None else enclosure:
            found += [Finding(*f) for f in native.enclosure_findings()]
        rank = {"error": 0, "warning": 1, "note": 2}
        return sorted(found, key=lambda f: rank[f.severity])

    def validate(self) -> None:
        """Raise SceneError with file, element and remedy if the scene cannot be lit."""
        self._native().validate()

    def patches(
        self,
        *,
        max_edge: float | None = None,
        count: int | None = None,
        as_is: bool = False,
        contacts: bool = True,
    ) -> Patches:
        """Cut the surfaces into patches.

        Args:
            max_edge: longest edge in metres.
            count: about how many patches.
            as_is: one patch per face, in the order of surfaces and faces; quads stay quads.
            contacts: whether patches end where another face touches or crosses theirs, so that none is on both sides of
                a wall that stands on it. Faces closer than 5e-7 of the longest extent of the scene touch. Has no effect
                ``as_is``.

        Obstructions are not cut: each of their faces is one of ``patches.obstructions``.

        Raises:
            SceneError: a face cannot be cut (not planar, not convex, an index out of range ...).
        """
        from radiosity.patches import Patches  # noqa: PLC0415

        native = self._native()
        native.validate_geometry()
        found = native.patches(max_edge=max_edge, count=count, as_is=as_is, contacts=contacts)
        cut = {"max_edge": max_edge, "count": count, "as_is": as_is, "contacts": contacts}
        return Patches(self, found, cut)


def _surface(fields: _native._SurfaceOut) -> Surface:
    name, vertices, faces, material, reflectance, emission, two_sided, specular, transmittance, through = fields[:10]
    texture, gloss = fields[10:]
    return Surface(vertices, _trim(faces), reflectance, emission, name, two_sided, material, specular, transmittance,
                   through or 0.0, Texture._from_native(texture), *gloss)  # fmt: skip


def _trim(faces: npt.NDArray[np.uint32]) -> npt.NDArray[np.int64]:
    """Drop the repeated corner where all faces are triangles."""
    signed = faces.astype(np.int64)
    return signed[:, :3] if len(faces) and bool(np.all(faces[:, 2] == faces[:, 3])) else signed


def _light(fields: _native.LightTuple) -> Light:
    kind, name, position, direction, inner, outer, power = fields
    if kind == "point":
        return PointLight(position, power, name)
    if kind == "spot":
        return SpotLight(position, direction, power, inner, outer, name)
    return DirectionalLight(direction, power, name)


def _band_names(n: int) -> list[str]:
    if n == 1:
        return ["grey"]
    return ["R", "G", "B"] if n == 3 else [f"band {k + 1}" for k in range(n)]


def load(path: str | os.PathLike[str], *, unit: str = "m", two_sided: bool | None = None) -> Scene:
    """Read a scene from a ``.glb``, ``.gltf``, ``.obj``, ``.stl``, ``.ply`` or ``.vs3`` file.

    Surfaces of an ``.obj`` file are two-sided unless told otherwise. Those of ``.stl``, ``.ply`` and ``.vs3`` are
    one-sided, with the front that the order of corners says; the first two have no materials, and reflectance 0.5 is
    taken. A ``.vs3`` file may also fill ``obstructions``, ``combined`` and ``hints``. Images of base colours become
    textures, up to 512 MiB a file; other images count by their mean.

    Args:
        path: the file.
        unit: what the number 1 in the file means: m, cm, mm, in, ft, km or a number of metres.
        two_sided: overrides what the file says about which sides of its surfaces reflect.

    Raises:
        SceneError: the file is missing, damaged or holds nothing that can be lit; the message says what to do.
    """
    return Scene._from_native(_native.load(os.fspath(path), unit, two_sided))
