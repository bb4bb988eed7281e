"""Light by path tracing: without a solution and without bias, for pictures and as an independent check of solvers."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from radiosity import _native
from radiosity.checks import threads_or_all, whole
from radiosity.files import LitModel
from radiosity.patches import Patches
from radiosity.scene import Camera, Scene
from radiosity.solution import Solution, _lamps

Floats = npt.NDArray[np.float64]
Image = npt.NDArray[np.float32]
Progress = Callable[[int, int], object]
Source = Scene | Patches | Solution | LitModel

DEFAULT_SAMPLES = 64
"""Paths per pixel or place where neither their number nor an accuracy is given."""

MOST_SAMPLES = 1 << 16
"""Most paths per pixel or place for an accuracy, where the caller does not say."""


@dataclass(frozen=True)
class Effort:
    """What a path tracing took, and how good it came out.

    Attributes:
        samples: paths per pixel or place.
        rays: all rays, those to lamps included.
        seconds: time it took.
        relative_error: of pictures the mean over lit pixels of the standard error over the value; of irradiance the
            standard error, root mean square over places by area, over the mean.
        accuracy: the relative error that was asked for; None if the number of samples was.
    """

    samples: int
    rays: int
    seconds: float
    relative_error: float
    accuracy: float | None

    @property
    def reached(self) -> bool:
        """Whether it is as accurate as asked."""
        return self.accuracy is None or self.relative_error <= self.accuracy


@dataclass(frozen=True, eq=False)
class PathTraced:
    """A path-traced picture.

    Attributes:
        image: (height, width, bands) float32, linear: radiance in W/m2/sr, or irradiance in W/m2.
        standard_error: likewise, of each pixel.
        effort: what it took.
    """

    image: Image
    standard_error: Image
    effort: Effort


@dataclass(frozen=True, eq=False)
class PathIrradiance:
    """Path-traced irradiance.

    Attributes:
        irradiance: (k, n_bands) W/m2 at points, or means over fronts of all patches; what a solid stands on is dark.
        error: likewise, standard errors.
        back_irradiance, back_error: (n_patches, n_bands) of the backs, NaN where a patch is one-sided; None for points.
        effort: what it took.
    """

    irradiance: Floats
    error: Floats
    back_irradiance: Floats | None
    back_error: Floats | None
    effort: Effort


def path_trace(
    scene: Source,
    camera: Camera | None = None,
    *,
    width: int = 800,
    height: int = 600,
    samples: int | None = None,
    accuracy: float | None = None,
    show: Literal["radiosity", "irradiance"] = "radiosity",
    threads: int | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> PathTraced:
    """Render by path tracing, with standard errors (Kajiya 1986; lamps by area and by rays, Veach and Guibas 1995).

    Unbiased: without patches, smoothing or a solution, so what is left is noise, and the errors say how much. Textures
    count at every bounce. Paths follow mirrors and clear glass, and go on behind what lets light through diffusely.
    Lamps in mirrors are found by rays alone, and small ones make noise; lights without area are looked for at their
    images, all of them unless mirrors face one another, else as far as :func:`radiosity.solve` takes them, 64
    reflections or 4096 images.

    Args:
        scene: a scene or patches, which need no solving; of a solution or lit model, its paints and lamps are taken.
        camera: the viewpoint (default: the scene's first, or one that sees everything).
        width, height: pixels.
        samples: paths per pixel, in eight independent rounds or more, from which the errors come (default 64); with an
            accuracy, the most.
        accuracy: mean relative standard error of the pixels at which to stop; all pixels get as many paths.
        show: radiosity is shown as radiance (W/m2/sr); irradiance in W/m2.
        threads: default: all cores. The picture does not depend on it.
        seed: the same seed gives the same bytes.
        progress: called with (done, total) tiles some twenty times a second.

    Raises:
        SceneError: the scene cannot be lit.
        ValueError: a number out of its range.
    """
    from radiosity.picture import camera_of  # noqa: PLC0415

    optics = _optics(scene)
    camera = camera or camera_of(optics.cameras, optics.patches.polygons)
    start = time.monotonic()
    image, error, taken, relative, rays = _native.path_trace(
        optics.patches, optics.emission, optics.reflectance, optics.lights, camera._tuple(), width, height,
        samples_or_default(samples, accuracy), accuracy, "radiance" if show == "radiosity" else show,
        whole(seed, "seed", 0, 2**64 - 1), optics.going_on, threads_or_all(threads), progress, optics.through,
        optics.textures, optics.gloss,
    )  # fmt: skip
    return PathTraced(image, error, Effort(taken, rays, time.monotonic() - start, relative, accuracy))


def path_irradiance(
    scene: Source,
    points: npt.ArrayLike | None = None,
    normals: npt.ArrayLike | None = None,
    *,
    samples: int | None = None,
    accuracy: float | None = None,
    threads: int | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> PathIrradiance:
    """Irradiance by path tracing, with standard errors, of every patch or at points: a check that shares no equations.

    Args:
        scene: as in :func:`path_trace`. The patches of a scene are its faces.
        points: (k, 3) metres, on surfaces or in the open; without points, the means over all patches are found.
        normals: (k, 3), or one for all: the way a surface looks there.
        samples: paths per point or patch, in eight independent rounds or more (default 64); with an accuracy, the most.
        accuracy: standard error, root mean square over area, or over points, relative to the mean, at which to stop.
        threads, seed, progress: as in :func:`path_trace`.

    Raises:
        SceneError: the scene cannot be lit.
        ValueError: a number out of its range, normals that do not fit the points, or a lit model with two-sided
            surfaces.
    """
    if isinstance(scene, LitModel) and any(name.endswith(" (back)") for name, *_ in scene.surfaces):
        raise ValueError(
            "this lit model has two-sided surfaces, whose backs it keeps as patches of their own, right behind the "
            "fronts: give the solution or the scene that it was made of"
        )
    optics = _optics(scene)
    if (points is None) != (normals is None):
        raise ValueError("points and normals go together")
    places = ways = None
    if points is not None and normals is not None:
        places = np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 3)
        ways = np.broadcast_to(np.asarray(normals, dtype=np.float64), places.shape)
        length = np.linalg.norm(ways, axis=1, keepdims=True)
        if not np.all(np.isfinite(places)) or not np.all((length > 0) & np.isfinite(length)):
            raise ValueError("points and normals must be finite, and normals not zero")
        ways = np.ascontiguousarray(ways / length)
    start = time.monotonic()
    value, error, taken, relative, rays = _native.path_irradiance(
        _native.Enclosure(optics.patches, threads_or_all(threads), *optics.parts), optics.emission, optics.reflectance,
        optics.lights, places, ways, samples_or_default(samples, accuracy), accuracy, whole(seed, "seed", 0, 2**64 - 1),
        threads_or_all(threads), progress, optics.through, optics.textures,
    )  # fmt: skip
    effort = Effort(taken, rays, time.monotonic() - start, relative, accuracy)
    if places is not None:
        return PathIrradiance(value, error, None, None, effort)
    two_sided, n = optics.patches.two_sided, len(optics.patches)
    backs = [np.full((n, value.shape[1]), np.nan) for _ in range(2)]
    for back, sides in zip(backs, (value, error), strict=True):
        back[two_sided] = sides[n:]
    return PathIrradiance(value[:n], error[:n], backs[0], backs[1], effort)


def samples_or_default(samples: int | None, accuracy: float | None) -> int:
    """A number of samples; what stands for it where there is none."""
    if samples is None:
        return DEFAULT_SAMPLES if accuracy is None else MOST_SAMPLES
    return whole(samples, "samples", 1, 1 << 24)


class _Optics(NamedTuple):
    """Shapes, and what shines and reflects."""

    patches: _native.Patches
    emission: Floats
    reflectance: Floats
    going_on: Floats | None
    lights: list[_native.LightTuple]
    cameras: list[Camera]
    through: Floats | None
    textures: _native.Textures | None
    gloss: Floats | None

    @property
    def parts(self) -> tuple[Floats | None, Floats | None]:
        """(n,) mirror reflectance and transmittance of patches; None where there is neither."""
        if self.going_on is None:
            return None, None
        return np.ascontiguousarray(self.going_on[:, 0]), np.ascontiguousarray(self.going_on[:, 1])


def _optics(scene: Source) -> _Optics:
    if isinstance(scene, LitModel):
        emitted, lamps = np.ascontiguousarray(scene.emission), scene.lights or []
        return _Optics(
            scene.patches, emitted, scene._reflectance, scene._going_on, lamps, scene.cameras, scene._through,
            scene.textures, scene.gloss,
        )  # fmt: skip
    if isinstance(scene, Solution):
        patches, whole_scene = scene.patches, scene.patches.scene
        emission, reflectance, lights = scene.emission, scene.reflectance, _lamps(whole_scene, scene.lights)
    else:
        if isinstance(scene, Scene):
            scene.validate()
            scene = scene.patches(as_is=True)
        patches, whole_scene = scene, scene.scene
        emission, reflectance, lights = patches.emission, patches.reflectance, _lamps(whole_scene)
    blocks = np.ascontiguousarray(emission), np.ascontiguousarray(reflectance)
    going_on = np.ascontiguousarray(patches._going_on) if patches.is_specular else None
    textures = patches._textures_in(reflectance)
    return _Optics(
        patches._native, *blocks, going_on, lights, whole_scene.cameras, patches._through, textures, patches._gloss
    )  # fmt: skip
