"""Pictures without interreflection: direct light, and an even ambient light in place of the rest."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from radiosity import _native
from radiosity.checks import threads_or_all, whole
from radiosity.files import LitModel
from radiosity.path_tracing import Source, _optics
from radiosity.picture import Image, camera_of
from radiosity.scene import Camera
from radiosity.solution import Solution

Floats = npt.NDArray[np.float64]


def direct_picture(
    scene: Source,
    camera: Camera | None = None,
    *,
    ambient: npt.ArrayLike = 0.0,
    width: int = 800,
    height: int = 600,
    samples: int = 64,
    irradiance: bool = False,
    threads: int | None = None,
    seed: int = 0,
    progress: Callable[[int, int], object] | None = None,
) -> Image:
    """Light that comes straight from lamps, with its shadows, also as mirrors and clear glass show it.

    With an ambient irradiance it is the classical ray-traced picture (Whitted 1980, *An improved illumination model for
    shaded display*): every surface reflects the same ambient light, whatever stands around it. Unlike his, lamps have
    areas and shadows are soft, and light that a mirror or pane sends on to a surface counts as direct.

    Args:
        scene: as in :func:`radiosity.path_trace`; nothing needs to be solved.
        camera, width, height, threads, seed, progress: as in :func:`radiosity.picture.render`.
        ambient: irradiance in W/m2, a number or one per band.
        samples: rays a pixel.
        irradiance: show direct irradiance, without the ambient light, not radiance.

    Returns:
        (height, width, bands) float32, linear: radiance in W/m2/sr, or irradiance in W/m2.
    """
    o = _optics(scene)
    # What is seen glows by the ambient light as well; what lights it is emission alone.
    leaves = o.reflectance if o.through is None else o.reflectance + o.through
    glow = np.ascontiguousarray(o.emission + leaves * np.asarray(ambient, dtype=np.float64))
    return _native.gather(
        o.patches, glow, o.reflectance, np.zeros_like(o.emission), o.emission, o.lights,
        (camera or camera_of(o.cameras, o.patches.polygons))._tuple(), width, height,
        whole(samples, "samples", 1, 1 << 24), "irradiance" if irradiance else "radiance",
        whole(seed, "seed", 0, 2**64 - 1), o.going_on, threads_or_all(threads), progress, o.through, o.textures,
    )[0]  # fmt: skip


def ambient_of(lit: Solution | LitModel, *, samples: int = 64, threads: int | None = None, seed: int = 0) -> Floats:
    """(bands,) W/m2: the even ambient irradiance that is worth as much as all interreflection of a solution.

    All surfaces together reflect as much power of it as they do of indirect light, so that pictures are about equally
    bright. It has the colour of the direct light.

    Args:
        lit: a solution or lit model.
        samples: rays a patch that find the direct light.
        threads, seed: as in :func:`radiosity.solve`.
    """
    o = _optics(lit)
    area, paint = (np.concatenate([v, v[o.patches.two_sided]]) for v in (o.patches.area, o.reflectance))
    direct = _native.path_irradiance(
        _native.Enclosure(o.patches, threads_or_all(threads), *o.parts), o.emission, np.zeros_like(o.reflectance),
        o.lights, None, None, samples, None, whole(seed, "seed", 0, 2**64 - 1), threads_or_all(threads), None,
    )[0]  # fmt: skip
    colour = area @ direct
    reflected, white = area @ (paint * (_of_sides(lit) - direct)), area @ (paint * colour)
    if not white.any():
        return np.zeros_like(colour)
    return np.asarray(colour * max(0.0, float(reflected.sum() / white.sum())))


def _of_sides(lit: Solution | LitModel) -> Floats:
    """(sides, bands) irradiance of fronts, then backs."""
    if isinstance(lit, LitModel):
        return lit.irradiance
    return np.concatenate([lit.irradiance, lit.back_irradiance[lit.patches.two_sided]])
