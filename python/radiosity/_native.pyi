"""The extension module, as crates/python defines it; tests/test_native.py holds the two together."""

from collections.abc import Callable, Sequence
from typing import Any, final

import numpy as np
import numpy.typing as npt

__version__: str

_Floats = npt.NDArray[np.float64]
_Indices = npt.NDArray[np.uint32]
_Pixels = npt.NDArray[np.float32]
_Triple = Sequence[float]
_Progress = Callable[[int, int], object]
# iteration, residual, unshot, radiosity, ambient
_OnIterate = Callable[[int, float, float | None, _Floats, list[float]], object]

# kind, name, position, direction, inner and outer angle, strength
LightTuple = tuple[str, str, _Triple, _Triple, float, float, list[float]]
# offsets, columns, values
CsrTuple = tuple[npt.NDArray[np.int64], _Indices, _Floats]
# name, position, forward, up, vertical angle of view, aspect
CameraTuple = tuple[str, _Triple, _Triple, _Triple, float, float | None]
# name, material, reflectance, two-sided, specular, transmittance, diffuse transmittance or nothing
LitSurfaceTuple = tuple[str, str, list[float], bool, float, float, list[float]]
# severity, code, element, message; surface, (k,) faces of it, (k, 2, 3) edges, (k, 3) points
_FindingTuple = tuple[Any, str, str, str, int | None, _Indices, _Floats, _Floats]
# image and (n_vertices, 2) texture coordinates
_Texture = tuple[Raster, _Floats] | None
# name, vertices, faces; name of the material, reflectance, emission, two-sided, specular, transmittance, diffuse
# transmittance or nothing; texture; metallic and roughness
_Gloss = tuple[float, float]
_SurfaceIn = tuple[
    str,
    _Floats,
    npt.NDArray[np.int64],
    str,
    list[float],
    list[float],
    bool,
    float,
    float,
    list[float],
    _Texture,
    _Gloss,
]
_SurfaceOut = tuple[
    str, _Floats, _Indices, str, list[float], list[float], bool, float, float, list[float], _Texture, _Gloss
]

class SceneError(ValueError):
    """A scene that cannot be read, meshed or lit."""

class ResourceError(RuntimeError):
    """The work does not fit the limits given."""

@final
class Raster:
    @staticmethod
    def of_bytes(image: npt.NDArray[np.uint8], wrap: tuple[str, str]) -> Raster: ...
    @staticmethod
    def of_values(image: _Pixels, wrap: tuple[str, str]) -> Raster: ...
    def with_wrap(self, wrap: tuple[str, str]) -> Raster: ...
    def values(self) -> _Pixels: ...
    @property
    def shape(self) -> tuple[int, int, int]: ...
    @property
    def wrap(self) -> tuple[Any, Any]: ...
    @property
    def memory_bytes(self) -> int: ...

@final
class Textures:
    def __new__(cls, scene: Scene, patches: Patches) -> Textures: ...
    def __len__(self) -> int: ...
    def picked(self, which: _Indices, keep: npt.NDArray[np.bool_]) -> Textures: ...
    def with_means(self, patches: Patches, values: _Floats) -> _Floats: ...

@final
class Scene:
    def __new__(
        cls,
        name: str,
        bands: list[str],
        surfaces: list[_SurfaceIn],
        lights: list[LightTuple],
        cameras: list[CameraTuple],
        obstructions: list[_SurfaceIn] = ...,
        combined: dict[int, int] = ...,
    ) -> Scene: ...
    @property
    def name(self) -> str: ...
    @property
    def bands(self) -> list[str]: ...
    def surfaces(self) -> list[_SurfaceOut]: ...
    def obstructions(self) -> list[_SurfaceOut]: ...
    def combined(self) -> dict[int, int]: ...
    def hints(self) -> dict[str, float | int | bool]: ...
    def lights(self) -> list[LightTuple]: ...
    def cameras(self) -> list[CameraTuple]: ...
    def loading_findings(self) -> list[_FindingTuple]: ...
    def findings(self) -> list[_FindingTuple]: ...
    def enclosure_findings(self) -> list[_FindingTuple]: ...
    def validate(self) -> None: ...
    def validate_geometry(self) -> None: ...
    def patches(
        self,
        max_edge: float | None = None,
        count: int | None = None,
        as_is: bool = False,
        contacts: bool = True,
    ) -> Patches: ...
    def grid(self, divisions: list[tuple[int, int]]) -> Patches: ...

@final
class Patches:
    def __new__(
        cls,
        polygons: _Floats,
        surface: _Indices,
        face: _Indices,
        two_sided: npt.NDArray[np.bool_],
        obstructions: _Floats | None = None,
    ) -> Patches: ...
    def __len__(self) -> int: ...
    @property
    def polygons(self) -> _Floats: ...
    @property
    def obstructions(self) -> _Floats: ...
    @property
    def surface(self) -> _Indices: ...
    @property
    def face(self) -> _Indices: ...
    @property
    def two_sided(self) -> npt.NDArray[np.bool_]: ...
    @property
    def area(self) -> _Floats: ...
    @property
    def centre(self) -> _Floats: ...
    @property
    def normal(self) -> _Floats: ...

@final
class Enclosure:
    def __new__(
        cls,
        patches: Patches,
        threads: int | None = None,
        specular: _Floats | None = None,
        transmittance: _Floats | None = None,
    ) -> Enclosure: ...
    def locate(self, points: _Floats, normals: _Floats, reach: float) -> tuple[npt.NDArray[np.int64], _Floats]: ...
    def validate(self) -> None: ...
    # polygon or -1, distance, whether it is the front
    def looks(
        self, points: _Floats, directions: _Floats, threads: int | None = None
    ) -> tuple[npt.NDArray[np.int64], _Floats, npt.NDArray[np.bool_]]: ...
    @property
    def memory_bytes(self) -> int: ...

@final
class AdaptiveMesh:
    def __new__(cls, scene: Scene, count: int) -> AdaptiveMesh: ...
    def patches(self) -> tuple[Patches, _Indices]: ...
    def refine(self, marked: npt.NDArray[np.uint8]) -> int: ...

@final
class Solution:
    @property
    def irradiance(self) -> _Floats: ...
    @property
    def radiosity(self) -> _Floats: ...
    @property
    def error(self) -> _Floats: ...
    def backs(self) -> list[_Floats]: ...
    def causes(self) -> list[tuple[str, list[_Floats]]]: ...
    def mesh(self) -> _Floats: ...
    def report(self) -> dict[str, Any]: ...
    def relight(
        self,
        reflectance: _Floats,
        emission: _Floats,
        lamps: list[LightTuple],
        accuracy: float,
        method: str,
        exact_closure: bool,
        max_iterations: int | None = None,
        threads: int | None = None,
        progress: _Progress | None = None,
        as_field: bool = False,
        diffuse_transmittance: _Floats | None = None,
    ) -> Solution: ...
    def on_sides(
        self,
        reflectance: _Floats,
        emission: _Floats,
        lamps: list[LightTuple],
        accuracy: float,
        method: str,
        threads: int | None = None,
        diffuse_transmittance: _Floats | None = None,
    ) -> _Floats | None: ...
    def gradients(
        self,
        reflectance: _Floats,
        emission: _Floats,
        lamps: list[LightTuple],
        weights: _Floats,
        threads: int | None = None,
        progress: _Progress | None = None,
    ) -> list[_Floats]: ...

@final
class ExchangeFile:
    def __init__(self, path: str, verify: bool) -> None: ...
    @property
    def patches(self) -> Patches: ...
    @property
    def description(self) -> str: ...
    def factors(self, enclosure: Enclosure, memory_limit: int) -> Factors: ...

@final
class ShootingState:
    def __new__(
        cls,
        counts: npt.NDArray[np.uint64],
        shares: _Floats,
        sums: npt.NDArray[np.float32],
        landed: _Indices,
    ) -> ShootingState: ...
    def parts(self) -> tuple[npt.NDArray[np.uint64], _Floats, npt.NDArray[np.float32], _Indices]: ...
    @property
    def memory_bytes(self) -> int: ...

@final
class ShotSolution:
    @property
    def irradiance(self) -> _Floats: ...
    @property
    def radiosity(self) -> _Floats: ...
    @property
    def error(self) -> _Floats: ...
    def backs(self) -> list[_Floats]: ...
    def report(self) -> dict[str, Any]: ...
    @property
    def state(self) -> ShootingState: ...

@final
class Factors:
    def __len__(self) -> int: ...
    @property
    def patch(self) -> _Indices: ...
    def exchange(self, x: _Floats) -> _Floats: ...
    def row(self, i: int) -> tuple[_Indices, _Floats]: ...
    def csr(self) -> CsrTuple: ...
    def count(self) -> int: ...
    def save(self, path: str, description: str) -> None: ...
    def standard_error(self) -> CsrTuple | None: ...
    def dense(self) -> _Floats: ...
    def smoothed(
        self, wanted: list[float], threads: int | None = None, progress: _Progress | None = None
    ) -> tuple[Factors, float]: ...
    def report(self) -> dict[str, Any]: ...
    def solve(
        self,
        reflectance: _Floats,
        emission: _Floats,
        lamps: list[LightTuple],
        accuracy: float,
        seed: int,
        memory_limit: int,
        method: str,
        max_iterations: int | None = None,
        threads: int | None = None,
        progress: _Progress | None = None,
        on_iterate: _OnIterate | None = None,
    ) -> Solution: ...

@final
class ItemBuffer:
    @property
    def resolution(self) -> int: ...
    @property
    def position(self) -> _Floats: ...
    @property
    def axes(self) -> _Floats: ...
    def owners(self) -> list[_Indices]: ...
    def depths(self) -> list[_Pixels]: ...
    def directions(self) -> list[_Floats]: ...
    def unfolded(self) -> _Indices: ...

def load(path: str, unit: str | None = None, two_sided: bool | None = None) -> Scene: ...
def builtin(name: str, numbers: list[float], spectra: list[list[float]]) -> Scene: ...
def corner_field(patches: Patches, values: _Floats) -> _Floats: ...
def solve(
    enclosure: Enclosure,
    reflectance: _Floats,
    emission: _Floats,
    lamps: list[LightTuple],
    accuracy: float,
    seed: int,
    max_rays: int,
    memory_limit: int,
    method: str,
    exact_closure: bool,
    max_iterations: int | None = None,
    threads: int | None = None,
    progress: _Progress | None = None,
    as_field: bool = False,
    importance: _Floats | None = None,
    diffuse_transmittance: _Floats | None = None,
) -> Solution: ...
def solve_on_demand(
    enclosure: Enclosure,
    reflectance: _Floats,
    emission: _Floats,
    lamps: list[LightTuple],
    accuracy: float,
    seed: int,
    memory_limit: int,
    method: str,
    max_iterations: int | None = None,
    threads: int | None = None,
    progress: _Progress | None = None,
    on_iterate: _OnIterate | None = None,
) -> Solution: ...
def solve_linked(
    enclosure: Enclosure,
    reflectance: _Floats,
    emission: _Floats,
    lamps: list[LightTuple],
    accuracy: float,
    seed: int,
    memory_limit: int,
    method: str,
    max_iterations: int | None = None,
    threads: int | None = None,
    progress: _Progress | None = None,
    on_iterate: _OnIterate | None = None,
) -> Solution: ...
def shoot(
    enclosure: Enclosure,
    reflectance: _Floats,
    emission: _Floats,
    lamps: list[LightTuple],
    accuracy: float,
    seed: int,
    max_rays: int,
    memory_limit: int,
    time_limit: float,
    start: ShootingState | None = None,
    threads: int | None = None,
    progress: _Progress | None = None,
) -> ShotSolution: ...
def form_factors(
    enclosure: Enclosure,
    method: str,
    tolerance: float,
    samples: int | None,
    resolution: int,
    seed: int,
    memory_limit: int,
    checkpoint: tuple[str, str] | None = None,
    threads: int | None = None,
    progress: _Progress | None = None,
) -> Factors: ...
def given_factors(
    enclosure: Enclosure, offsets: npt.NDArray[np.int64], columns: _Indices, values: _Floats
) -> Factors: ...
def frame(normal: _Triple) -> _Floats: ...
def nusselt_outline(point: _Triple, normal: _Triple, polygon: _Floats, steps: int) -> _Floats: ...
def nusselt_share(point: _Triple, normal: _Triple, polygon: _Floats) -> float: ...
def item_buffer(
    enclosure: Enclosure, side: int, resolution: int, seed: int, threads: int | None = None
) -> ItemBuffer: ...
def delta_form_factors(resolution: int) -> tuple[_Floats, _Floats]: ...
def write_lit(
    path: str,
    patches: Patches,
    surfaces: list[LitSurfaceTuple],
    bands: list[str],
    blocks: list[_Floats],
    cameras: list[CameraTuple],
    lights: list[LightTuple] | None,
    report: str,
) -> None: ...
def write_vtp(
    path: str,
    patches: Patches,
    surfaces: list[LitSurfaceTuple],
    bands: list[str],
    blocks: list[_Floats],
    cameras: list[CameraTuple],
    lights: list[LightTuple] | None,
    report: str,
) -> None: ...
def read_lit(
    path: str,
) -> (
    tuple[Patches, list[LitSurfaceTuple], list[str], list[_Floats], list[CameraTuple], list[LightTuple] | None, str]
    | None
): ...
def render(
    patches: Patches,
    values: _Floats,
    camera: CameraTuple,
    width: int,
    height: int,
    samples: int,
    scale: float,
    smooth: bool,
    irradiance: _Floats | None = None,
    reflectance: _Floats | None = None,
    going_on: _Floats | None = None,
    threads: int | None = None,
    progress: _Progress | None = None,
    diffuse_transmittance: _Floats | None = None,
    textures: Textures | None = None,
) -> _Pixels: ...
def write_png(path: str, image: _Pixels, exposure: float | None = None, curve: str = "filmic") -> None: ...
def write_false_colours(
    path: str, image: _Pixels, low: float | None = None, high: float | None = None, legend: str | None = None
) -> tuple[float, float]: ...
def write_exr(path: str, image: _Pixels, bands: list[str]) -> None: ...

# image and its standard error, samples, relative error, rays
def gather(
    patches: Patches,
    emission: _Floats,
    reflectance: _Floats,
    irradiance: _Floats,
    radiosity: _Floats,
    lights: list[LightTuple],
    camera: CameraTuple,
    width: int,
    height: int,
    samples: int,
    show: str,
    seed: int,
    going_on: _Floats | None = None,
    threads: int | None = None,
    progress: _Progress | None = None,
    diffuse_transmittance: _Floats | None = None,
    textures: Textures | None = None,
    gloss: _Floats | None = None,
) -> tuple[_Pixels, float, int]: ...
def path_trace(
    patches: Patches,
    emission: _Floats,
    reflectance: _Floats,
    lights: list[LightTuple],
    camera: CameraTuple,
    width: int,
    height: int,
    samples: int,
    accuracy: float | None,
    show: str,
    seed: int,
    going_on: _Floats | None = None,
    threads: int | None = None,
    progress: _Progress | None = None,
    diffuse_transmittance: _Floats | None = None,
    textures: Textures | None = None,
    gloss: _Floats | None = None,
) -> tuple[_Pixels, _Pixels, int, float, int]: ...

# irradiance and its standard error, samples, relative error, rays
def path_irradiance(
    enclosure: Enclosure,
    emission: _Floats,
    reflectance: _Floats,
    lights: list[LightTuple],
    points: _Floats | None,
    normals: _Floats | None,
    samples: int,
    accuracy: float | None,
    seed: int,
    threads: int | None = None,
    progress: _Progress | None = None,
    diffuse_transmittance: _Floats | None = None,
    textures: Textures | None = None,
) -> tuple[_Floats, _Floats, int, float, int]: ...
