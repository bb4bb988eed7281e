"""Scenes whose light is known, to ask of a solution whether the error that it reports is the one it has.

    for known in KNOWN.values():
        solution = radiosity.solve(known.mesh(), accuracy=0.02)
        print(known.name, solution.report.estimated_error, true_error_of_patch_means(known, solution))

Three kinds. Of some the irradiance is known at any point: in closed form, or to ``accuracy_of_truth`` from small panels
whose form factors are. Of some it is stored at ``probes`` and as means over one mesh, with standard errors, found by
another program. Of the Cornell box only means over one mesh are known.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

import numpy as np
import numpy.typing as npt
from convex_room import ConvexRoom
from exact_light import OnSurface, area_of, from_lamp, mean_over, part_behind, solid_angle
from known_rooms import PATH_TRACED, block, lamp, mesh_of, probes_on, room
from pieces import rectangle

import radiosity

Floats = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]
REFERENCES = Path(__file__).parent / "references"


@dataclass(frozen=True)
class Probes:
    """Points spread evenly by area over all surfaces, lamps included, and the light there."""

    points: Floats
    surface: Indices
    value: Floats
    """(k, bands) W/m2."""
    error: Floats
    """(k, bands) standard error of the value; zeros where it is exact."""


@dataclass(frozen=True)
class Means:
    """Mean irradiance of patches, (n, bands) W/m2, and its standard error."""

    value: Floats
    error: Floats


@dataclass(frozen=True, eq=False)
class Known:
    """A scene and its light, of all bands in W/m2.

    ``scene`` makes it anew. ``accuracy_of_truth`` is relative: root mean square over area, over the mean. ``why`` names
    the source.
    """

    name: str
    scene: Callable[[], radiosity.Scene]
    why: str
    accuracy_of_truth: float

    def mesh(self, count: int = 600) -> radiosity.Patches:
        """Patches that the means are known of; about so many, where there is a choice."""
        return self.scene().patches(count=count)

    def irradiance_at(self, points: Floats, surface: Indices) -> Floats:
        """(k, bands) at points, (k, 3), on surfaces, (k,).

        Raises:
            LookupError: only what is stored is known.
        """
        raise LookupError(f"{self.name}: the light is not known at any point")

    def patch_means(self, patches: radiosity.Patches) -> Means:
        """Of any patches of the scene, or of those of ``mesh()`` alone.

        Raises:
            LookupError: these patches are not those that means are stored of.
        """
        raise NotImplementedError

    def probes(self, count: int = 1000) -> Probes:
        """So many, or as many as are stored.

        Raises:
            LookupError: nothing but means is known.
        """
        raise LookupError(f"{self.name}: no more than means over patches are known")

    def counts(self, patches: radiosity.Patches) -> npt.NDArray[np.bool_]:
        """(n,) of which patches the truth is known."""
        return np.ones(len(patches), bool)


@dataclass(frozen=True, eq=False)
class KnownEverywhere(Known):
    """Known at any point, so on any patches. ``means`` is their closed form, where there is one."""

    at: OnSurface
    means: Callable[[radiosity.Patches], Floats] | None = None

    def irradiance_at(self, points: Floats, surface: Indices) -> Floats:
        """(k, bands), as told."""
        return self.at(points, surface)

    def patch_means(self, patches: radiosity.Patches) -> Means:
        """Of any patches: the closed form, or points in cells as small as it takes."""
        value = self.means(patches) if self.means else mean_over(patches, self.at)
        return Means(value, np.zeros_like(value))

    def probes(self, count: int = 1000) -> Probes:
        """So many, one in each of equal shares of the area."""
        points, surface, _ = probes_on(self.mesh(count), count)
        value = self.at(points, surface)
        return Probes(points, surface, value, np.zeros_like(value))


@dataclass(frozen=True, eq=False)
class KnownFromFile(Known):
    """Known at stored probes and on one mesh, from ``make_known_answers.py``."""

    @cached_property
    def _arrays(self) -> dict[str, np.ndarray]:
        path = REFERENCES / f"known_{self.name.replace(' ', '_')}.npz"
        with np.load(path, allow_pickle=False) as file:
            return {name: file[name].astype(float) for name in file.files}

    def mesh(self, count: int = 600) -> radiosity.Patches:
        """The one that means are stored of, whatever the count."""
        return mesh_of(self.scene())

    def patch_means(self, patches: radiosity.Patches) -> Means:
        """As stored."""
        stored = self._arrays
        _require_same(self.name, stored["centre"], patches.centre)
        return Means(stored["mean"], stored["mean_error"])

    def probes(self, count: int = 1000) -> Probes:
        """As stored, whatever the count."""
        stored = self._arrays
        return Probes(stored["points"], stored["surface"].astype(np.int64), stored["value"], stored["value_error"])


@dataclass(frozen=True, eq=False)
class KnownMeans(Known):
    """The Cornell box: means over the patches of the reference. What lies wholly or partly under a block counts."""

    @cached_property
    def _arrays(self) -> dict[str, np.ndarray]:
        with np.load(REFERENCES / "cornell_irradiance.npz", allow_pickle=False) as file:
            return dict(file)

    def mesh(self, count: int = 600) -> radiosity.Patches:
        """The 1,920 of the reference, whatever the count."""
        return self.scene().patches(as_is=True)

    def patch_means(self, patches: radiosity.Patches) -> Means:
        """As stored."""
        _require_same(self.name, self._arrays["quads"].mean(axis=1), patches.polygons.mean(axis=1))
        return Means(self._arrays["E"], self._arrays["sem"])

    def counts(self, patches: radiosity.Patches) -> npt.NDArray[np.bool_]:
        """All but the lamp, which reflects nothing."""
        dark: npt.NDArray[np.bool_] = self._arrays["emission"].sum(axis=1) == 0
        return dark


def _require_same(name: str, stored: Floats, centres: Floats) -> None:
    if stored.shape != centres.shape or not np.allclose(stored, centres, rtol=0, atol=1e-5 * np.ptp(stored)):
        raise LookupError(f"{name}: means are known of the patches of mesh() alone")


def true_error_of_patch_means(known: Known, solution: radiosity.Solution) -> float:
    """Root mean square over area and bands of the error of irradiance, over the mean, as ``report.estimated_error``.

    What is known of the error of the truth is taken off.
    """
    patches = solution.patches
    return true_error_of_means(patches, solution.irradiance, known.patch_means(patches), known.counts(patches))


def true_error_of_means(
    patches: radiosity.Patches, irradiance: Floats, truth: Means, counts: npt.NDArray[np.bool_] | None = None
) -> float:
    """The same where the truth is at hand: of irradiance, (n, bands), on the patches that count."""
    counts = np.ones(len(patches), bool) if counts is None else counts
    weight = patches.area[counts] / patches.area[counts].sum()
    square = weight @ ((irradiance - truth.value) ** 2 - truth.error**2)[counts]
    return float(np.sqrt(max(square.mean(), 0.0)) / (weight @ truth.value[counts]).mean())


def true_error_of_field(known: Known, values_at: OnSurface, count: int = 1000) -> float:
    """The same of a field, by probes: ``values_at`` gives (k, bands) at (k, 3) points on (k,) surfaces."""
    probes = known.probes(count)
    square = (values_at(probes.points, probes.surface) - probes.value) ** 2 - probes.error**2
    return float(np.sqrt(max(square.mean(), 0.0)) / probes.value.mean())


def probe_points(known: Known, count: int = 1000) -> tuple[Floats, Indices]:
    """(k, 3) points spread evenly by area over all surfaces, lamps included, and (k,) their surfaces."""
    probes = known.probes(count)
    return probes.points, probes.surface


def normals_of(scene: radiosity.Scene, points: Floats, surface: Indices) -> Floats:
    """The way surfaces look at points on them."""
    patches = scene.patches(as_is=True)
    normals = np.zeros_like(points)
    for k in np.unique(surface):
        of, here = np.flatnonzero(patches.surface == k), surface == k
        off = np.abs(((points[here][:, None] - patches.centre[of]) * patches.normal[of]).sum(axis=2))
        low, high = patches.polygons[of].min(axis=1) - 1e-6, patches.polygons[of].max(axis=1) + 1e-6
        inside = np.all((points[here][:, None] >= low) & (points[here][:, None] <= high), axis=2)
        normals[here] = patches.normal[of[np.argmin(np.where(inside, off, np.inf), axis=1)]]
    return normals


def _corners(surface: radiosity.Surface) -> list[Floats]:
    vertices = np.asarray(surface.vertices)
    return [vertices[face] for face in np.asarray(surface.faces)]


def _normals(scene: radiosity.Scene) -> Floats:
    """(surfaces, 3) of flat surfaces."""
    corners = np.array([_corners(s)[0][:3] for s in scene.surfaces])
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    unit: Floats = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    return unit


# Furnaces


def _furnace(name: str, scene: Callable[[], radiosity.Scene], rho: Floats, emission: Floats) -> KnownEverywhere:
    level = emission / (1 - rho)
    return KnownEverywhere(
        name, scene, "uniform E and rho in a closed box: H = B = E / (1 - rho)", 0.0,
        at=lambda points, surface: np.tile(level, (len(points), 1)),
        means=lambda patches: np.tile(level, (len(patches), 1)),
    )  # fmt: skip


def furnace_box() -> KnownEverywhere:
    """A box that glows."""
    rho, emission = np.array([0.3, 0.8]), np.array([1.0, 0.5])

    def scene() -> radiosity.Scene:
        surfaces = room([0, 0, 0], [1, 1.3, 0.9], rho)
        for surface in surfaces:
            surface.emission = emission
        return radiosity.Scene(surfaces, name="furnace box")

    return _furnace("furnace box", scene, rho, emission)


def furnace_blocks() -> KnownEverywhere:
    """The same with blocks in it and much reflected."""
    rho, emission = np.array([0.9]), np.array([1.0])
    return _furnace("furnace blocks", lambda: radiosity.scenes.furnace(0.9, 1.0), rho, emission)


# Lights without area, over black ground


FLOOR = rectangle([0, 0, 0], [3, 0, 0], [0, 2, 0], name="floor")
SCREEN = [1.13, 0.47, 0.53], [0.78, 0.21, 0], [-0.19, 0.81, 0]
"""Aslant, so that no shadow runs along a mesh."""


def _screen() -> radiosity.Surface:
    return rectangle(*SCREEN, name="screen")


def _inverse_square(points: Floats, normal: Floats, eye: Floats) -> Floats:
    way = eye - points
    distance = np.linalg.norm(way, axis=1)
    return np.maximum(np.einsum("ki,ki->k", way, normal), 0) / distance**3


def _hidden(points: Floats, *, eye: Floats | None = None, along: Floats | None = None) -> npt.NDArray[np.bool_]:
    """Whether the screen is between points on the floor and a light above it."""
    (corner, b, _, d), up = _corners(_screen())[0], np.array([0.0, 0.0, 1.0])
    ray = np.broadcast_to(-along, points.shape) if eye is None else eye - points
    crossing = points + ((corner - points) @ up / (ray @ up))[:, None] * ray
    share = (crossing - corner)[:, :2] @ np.linalg.inv(np.stack([b - corner, d - corner])[:, :2])
    inside: npt.NDArray[np.bool_] = np.all((share > 0) & (share < 1), axis=1)
    return inside


def point_over_floor() -> KnownEverywhere:
    """A point light close over a black floor."""
    eye, intensity = np.array([0.8, 0.7, 0.4]), np.array([3.0, 1.0])
    up = np.array([0.0, 0.0, 1.0])

    def scene() -> radiosity.Scene:
        return radiosity.Scene([FLOOR], [radiosity.PointLight(eye, intensity)], name="point over floor")

    def at(points: Floats, surface: Indices) -> Floats:
        return _inverse_square(points, np.tile(up, (len(points), 1)), eye)[:, None] * intensity

    def means(patches: radiosity.Patches) -> Floats:
        return (solid_angle(patches.polygons, eye) / patches.area)[:, None] * intensity

    return KnownEverywhere("point over floor", scene, "I cos / r^2; means: I times the solid angle over the area",
                           1e-12, at, means)  # fmt: skip


def point_and_screen() -> KnownEverywhere:
    """A point light over a black floor, and a screen between: a sharp shadow."""
    eye, intensity = np.array([1.2, 0.7, 1.5]), np.array([3.0])

    def scene() -> radiosity.Scene:
        light = radiosity.PointLight(eye, intensity)
        return radiosity.Scene([FLOOR], [light], name="point and screen", obstructions=[_screen()])

    def at(points: Floats, surface: Indices) -> Floats:
        up = np.tile([0.0, 0.0, 1.0], (len(points), 1))
        return (_inverse_square(points, up, eye) * ~_hidden(points, eye=eye))[:, None] * intensity

    def means(patches: radiosity.Patches) -> Floats:
        cells, eyes = patches.polygons, np.tile(eye, (len(patches), 1))
        shadow = part_behind(cells, _corners(_screen())[0], eye=eyes)
        return ((solid_angle(cells, eye) - solid_angle(shadow, eye)) / patches.area)[:, None] * intensity

    return KnownEverywhere("point and screen", scene, "as point over floor, less the solid angle of what is in shadow",
                           1e-12, at, means)  # fmt: skip


def sun_and_screen() -> KnownEverywhere:
    """Parallel light on a black floor, and a screen."""
    along, strength = np.array([0.6, 0.0, -0.8]), np.array([1.0, 2.0, 0.5])

    def scene() -> radiosity.Scene:
        sun = radiosity.DirectionalLight(along, strength)
        return radiosity.Scene([FLOOR], [sun], name="sun and screen", obstructions=[_screen()])

    def at(points: Floats, surface: Indices) -> Floats:
        return np.where(_hidden(points, along=along), 0, 0.8)[:, None] * strength

    def means(patches: radiosity.Patches) -> Floats:
        cells = patches.polygons
        shadow = area_of(part_behind(cells, _corners(_screen())[0], along=along))
        return (0.8 * (1 - shadow / patches.area))[:, None] * strength

    return KnownEverywhere("sun and screen", scene, "E cos; means: the share of the area in the sun", 1e-12, at, means)


def spot() -> KnownEverywhere:
    """A spot light with a soft edge, aslant over a black floor."""
    eye, aim = np.array([0.6, 0.8, 1.0]), np.array([0.7, 0.3, -1.0]) / np.linalg.norm([0.7, 0.3, -1.0])
    inner, outer, intensity = 0.25, 0.5, np.array([4.0])

    def scene() -> radiosity.Scene:
        light = radiosity.SpotLight(eye, aim, intensity, inner, outer)
        return radiosity.Scene([FLOOR], [light], name="spot")

    def at(points: Floats, surface: Indices) -> Floats:
        way = points - eye
        cosine = way @ aim / np.linalg.norm(way, axis=1)
        ramp = np.clip((cosine - np.cos(outer)) / (np.cos(inner) - np.cos(outer)), 0, 1)
        up = np.tile([0.0, 0.0, 1.0], (len(points), 1))
        return (ramp**2 * _inverse_square(points, up, eye))[:, None] * intensity

    return KnownEverywhere("spot", scene, "I ramp^2 cos / r^2, the ramp of KHR_lights_punctual", 1e-4, at)


# Lamps in black rooms


def _black(
    name: str, surfaces: Callable[[], list[radiosity.Surface]], solids: list[list[Floats]],
    obstructions: Callable[[], list[radiosity.Surface]] = list,
) -> KnownEverywhere:  # fmt: skip
    """Nothing reflects: Lambert's formula for what is visible of one lamp; points under a solid are dark."""

    def scene() -> radiosity.Scene:
        return radiosity.Scene(surfaces(), name=name, obstructions=obstructions())

    of = scene()
    normals, lit = _normals(of), next(s for s in of.surfaces if np.any(s.emission))
    own = [s.name for s in of.surfaces].index(lit.name)
    shining, emission = _corners(lit)[0], np.broadcast_to(np.asarray(lit.emission, float), (len(of.bands),))
    bounds = [(np.min(np.concatenate(s), axis=0), np.max(np.concatenate(s), axis=0)) for s in solids if len(s) > 1]

    def at(points: Floats, surface: Indices) -> Floats:
        found = np.zeros(len(points))
        rest = surface != own
        for low, high in bounds:
            stands = (points[:, 2] < low[2] + 1e-9) & (normals[surface, 2] > 0.5)
            rest &= ~(stands & np.all((points[:, :2] > low[:2]) & (points[:, :2] < high[:2]), axis=1))
        found[rest] = from_lamp(points[rest], normals[surface[rest]], shining, solids)
        return found[:, None] * emission

    return KnownEverywhere(name, scene, "Lambert's formula for the visible part of the lamp", 1e-4, at)


def black_room() -> KnownEverywhere:
    """A lamp near a corner under the ceiling of a black room without ceiling."""
    return _black("black room", lambda: [
        *room([0, 0, 0], [3, 2.5, 2], 0.0, leave=["ceiling"]), lamp((0.1, 0.3), (0.9, 0.8), 2.0, [10.0, 4.0])
    ], [])  # fmt: skip


def lamp_and_screen() -> KnownEverywhere:
    """A lamp, a screen that only blocks, a black floor and a wall: half shadow."""
    screen = rectangle([0.93, 0.57, 0.71], [1.08, 0.16, 0], [-0.11, 0.77, 0], name="screen")
    return _black("lamp and screen", lambda: [
        FLOOR, rectangle([3, 0, 0], [0, 0, 2], [0, 2, 0], name="wall"), lamp((1.02, 0.73), (1.81, 1.29), 2.0, 10.0)
    ], [_corners(screen)], lambda: [screen])  # fmt: skip


def window_and_box() -> KnownEverywhere:
    """A black box that stands on a black floor before a large window: shadows with a corner at the box's foot."""
    box = block([1.23, 0.79, 0], [1.78, 1.52, 0.67], 0.0, leave=["floor"], name="box")
    return _black("window and box", lambda: [
        *room([0, 0, 0], [3, 2.4, 2], 0.0, leave=["left", "ceiling"]), *box,
        rectangle([0, 0.3, 0.4], [0, 1.8, 0], [0, 0, 1.4], 0.0, [5.0, 8.0], name="window"),
    ], [[_corners(s)[0] for s in box]])  # fmt: skip


def standing_lamp() -> KnownEverywhere:
    """A lamp that stands on a black floor: at its foot irradiance goes from half the exitance on in no distance."""
    return _black("standing lamp", lambda: [
        FLOOR, rectangle([1, 1.0, 0], [0, 0.4, 0], [0, 0, 0.6], 0.0, 10.0, name="lamp")
    ], [])  # fmt: skip


# Interreflection in convex rooms


def _convex(
    name: str, scene: Callable[[], radiosity.Scene], lights: Callable[[Floats, Floats], Floats] | None = None,
    reflecting: list[radiosity.Surface] | None = None, *, accuracy: float,
) -> KnownEverywhere:  # fmt: skip
    """``accuracy`` is that of points, chiefly of those near an edge; means are good to a third of it."""

    @cache
    def solved() -> ConvexRoom:
        return ConvexRoom(scene(), lights, reflecting)

    return KnownEverywhere(name, scene, "direct light in closed form, the rest by small panels seen from points",
                           accuracy, at=lambda points, surface: solved().irradiance_at(points, surface),
                           means=lambda patches: solved().means(patches))  # fmt: skip


def parallel_squares() -> KnownEverywhere:
    """A square that shines and reflects, and one opposite that reflects."""
    return _convex("parallel squares", lambda: radiosity.Scene([
        rectangle([0, 0, 0], [1, 0, 0], [0, 1, 0], 0.5, 1.0, name="lower"),
        rectangle([0, 0, 0.5], [0, 1, 0], [1, 0, 0], 0.9, 0.0, name="upper"),
    ], name="parallel squares"), accuracy=5e-4)  # fmt: skip


def perpendicular_squares() -> KnownEverywhere:
    """The same with an edge in common."""
    return _convex("perpendicular squares", lambda: radiosity.Scene([
        rectangle([0, 0, 0], [1, 0, 0], [0, 1, 0], 0.5, 1.0, name="floor"),
        rectangle([0, 0, 0], [0, 1, 0], [0, 0, 1], 0.9, 0.0, name="wall"),
    ], name="perpendicular squares"), accuracy=1e-3)  # fmt: skip


def lamp_room() -> KnownEverywhere:
    """A cube with a small lamp flush in the ceiling; lamp and walls reflect alike."""
    rho = np.array([0.8, 0.4])

    def scene() -> radiosity.Scene:
        surfaces = room([0, 0, 0], [1, 1, 1], rho, leave=["ceiling"])
        for k, (low, high) in enumerate([
            ((0, 0), (1, 0.6)), ((0, 0.8), (1, 1)), ((0, 0.6), (0.3, 0.8)), ((0.5, 0.6), (1, 0.8)),
            ((0.3, 0.6), (0.5, 0.8)),
        ]):  # fmt: skip
            part = lamp(low, high, 1.0, [20.0, 10.0] if k == 4 else 0.0)
            part.name, part.reflectance = ("lamp" if k == 4 else f"ceiling {k}"), rho
            surfaces.append(part)
        return radiosity.Scene(surfaces, name="lamp room")

    return _convex("lamp room", scene, reflecting=room([0, 0, 0], [1, 1, 1], rho), accuracy=1e-3)


IN_BOX = np.array([0.3, 0.5, 0.6])


def from_point_in_box(points: Floats, normal: Floats) -> Floats:
    """(k, 1) direct light of the point light in the box, 1 W/sr."""
    return _inverse_square(points, normal, IN_BOX)[:, None]


def point_in_box() -> KnownEverywhere:
    """A point light off the middle of a closed box."""

    def scene() -> radiosity.Scene:
        light = radiosity.PointLight(IN_BOX, 1.0)
        return radiosity.Scene(room([0, 0, 0], [1, 1.3, 0.9], 0.5), [light], name="point in box")

    return _convex("point in box", scene, from_point_in_box, accuracy=1e-3)


# What other programs found


def _cornell_scene() -> radiosity.Scene:
    """The scene of the reference, one surface a face, one face a patch."""
    with np.load(REFERENCES / "cornell_irradiance.npz", allow_pickle=False) as file:
        stored = dict(file)
    surfaces = []
    for name, (nu, nv, start) in zip(stored["face_name"], stored["face_grid"], strict=True):
        quads = stored["quads"][start : start + nu * nv]
        faces = np.arange(4 * len(quads)).reshape(-1, 4)
        emission = np.pi * stored["emission"][start]
        surfaces.append(
            radiosity.Surface(quads.reshape(-1, 3), faces, stored["reflectance"][start], emission, str(name))
        )
    return radiosity.Scene(surfaces, name="cornell")


STANDARD_ERROR = {"keyhole": 0.0025, "study": 0.0035, "corridor": 0.011, "crater": 0.001, "window room": 0.0045}


def _path_traced(name: str) -> KnownFromFile:
    why = "path traced by Mitsuba 3.9.1; see references/README.md"
    return KnownFromFile(name, PATH_TRACED[name], why, STANDARD_ERROR[name])


KNOWN: dict[str, Known] = {
    known.name: known
    for known in (
        furnace_box(), furnace_blocks(), point_over_floor(), point_and_screen(), sun_and_screen(), spot(), black_room(),
        lamp_and_screen(), window_and_box(), standing_lamp(), parallel_squares(), perpendicular_squares(), lamp_room(),
        point_in_box(),
        KnownMeans("cornell", _cornell_scene, "Mitsuba 3.9.1; see references/README.md", 0.0005),
        *(_path_traced(name) for name in PATH_TRACED),
    )
}  # fmt: skip
"""By name."""

__all__ = [
    "KNOWN", "Known", "KnownEverywhere", "KnownFromFile", "KnownMeans", "Means", "Probes", "probe_points",
    "true_error_of_field", "true_error_of_means", "true_error_of_patch_means",
]  # fmt: skip
