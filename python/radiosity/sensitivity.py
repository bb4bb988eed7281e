"""What irradiance owes to every lamp and every paint: derivatives from one adjoint solve."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from radiosity.patches import Patches

if TYPE_CHECKING:
    from radiosity.solution import Progress, Solution

Floats = npt.NDArray[np.float64]

Functional = str | npt.ArrayLike
"""The name of a surface, or weights of irradiance, (n_patches,) or (n_patches, n_bands)."""


@dataclass(frozen=True)
class SurfaceSensitivity:
    """Derivatives by what a whole surface emits and reflects, (n_bands,) each."""

    emission: Floats
    reflectance: Floats


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Derivatives of a weighted sum of irradiance, made by :meth:`radiosity.Solution.sensitivity`; prints as a table.

    Bands do not mix: entry b of a derivative is that of band b of the target by band b of what is changed. The target
    weighs irradiance of fronts. Both sides of a two-sided patch emit and reflect alike, and derivatives are by both.

    Attributes:
        patches: what it is on.
        weights: (n_patches, n_bands) of irradiance.
        value: (n_bands,) the target; W/m2 where it is a mean.
        emission: (n_patches, n_bands) by emission; W/m2 of the target for each W/m2 emitted.
        reflectance: (n_patches, n_bands) by reflectance; W/m2 of the target for a reflectance of 1.
        lights: (n_lights, n_bands) by the strength of lights without area; 1/m2 x sr for W/sr, 1 for parallel light.
    """

    patches: Patches
    weights: Floats
    value: Floats
    emission: Floats
    reflectance: Floats
    lights: Floats

    @property
    def importance(self) -> Floats:
        """(n_patches, n_bands) what light that leaves a patch is worth, with all that becomes of it.

        The target for each W that every side of the patch sends, emitted or reflected: 1/m2 where the target is a mean.
        It does not depend on the size of patches, and weighs errors of radiosity by what they do to the target: the
        sum of area x importance x residual.
        """
        area = self.patches.area[:, None]
        return np.divide(self.emission, area, out=np.zeros_like(self.emission), where=area > 0)

    def by_surface(self) -> dict[str, SurfaceSensitivity]:
        """Derivatives by what whole surfaces emit and reflect; surfaces of one name count as one."""
        return {
            name: SurfaceSensitivity(self.emission[on].sum(axis=0), self.reflectance[on].sum(axis=0))
            for name, on in ((name, named(self.patches, name)) for name in names(self.patches))
        }

    def by_light(self) -> dict[str, Floats]:
        """(n_bands,) derivatives by lights without area; lights of one name count as one."""
        found: dict[str, Floats] = {}
        for light, values in zip(self.patches.scene.lights, self.lights, strict=True):
            found[light.name] = found.get(light.name, np.zeros(len(values))) + values
        return found

    def __str__(self) -> str:
        surfaces, lights = self.by_surface(), self.by_light()
        width = max(map(len, ("target", *surfaces, *lights)))
        lines = [f"{'target':<{width}}  {_row(self.value)} W/m2 ({', '.join(self.patches.scene.bands)})"]
        lines += [f"{name:<{width}}  emission {_row(s.emission)}  reflectance {_row(s.reflectance)}"
                  for name, s in surfaces.items()]  # fmt: skip
        lines += [f"{name:<{width}}  strength {_row(values)}" for name, values in lights.items()]
        return "\n".join(lines)


def _row(values: Floats) -> str:
    return " ".join(f"{v:>10.4g}" for v in values)


def of(solution: Solution, target: Functional, progress: Progress | None = None) -> Sensitivity:
    """Derivatives of a target.

    Raises:
        ValueError: as :meth:`radiosity.Solution.sensitivity`.
    """
    weights = weights_of(solution.patches, target)
    emission, reflectance, lights = gradients(solution, weights[None], progress)
    value = (weights * solution.irradiance).sum(axis=0)
    return Sensitivity(solution.patches, weights, value, emission[0], reflectance[0], lights[0])


def gradients(solution: Solution, weights: Floats, progress: Progress | None = None) -> tuple[Floats, Floats, Floats]:
    """Derivatives of many sums of irradiance at once.

    Args:
        solution: on samples or form factors.
        weights: (n_sums, n_patches, n_bands).
        progress: called with (done, total) some twenty times a second.

    Returns:
        (n_sums, n_patches, n_bands) by emission, the same by reflectance, (n_sums, n_lights, n_bands) by lights.

    Raises:
        ValueError: the solution kept no exchange, or its equations have no answer.
    """
    from radiosity.solution import _lamps  # noqa: PLC0415

    demand_exchange(solution)
    sums, _, bands = weights.shape
    native: Any = solution._native
    found = native.gradients(
        solution.reflectance, solution.emission, _lamps(solution.patches.scene, solution.lights),
        np.ascontiguousarray(weights.reshape(-1, bands)), solution._options["threads"], progress,
    )  # fmt: skip
    emission, reflectance, lights = (block.reshape(sums, -1, bands) for block in found)
    return emission, reflectance, lights.reshape(sums, len(solution.lights), bands)


def demand_exchange(solution: Solution) -> None:
    """Refuse a solution that nothing can be sent back through.

    Raises:
        ValueError: it kept no exchange, or light passes through patches diffusely.
    """
    solution.patches._demand_opaque("importance, sent back from what it is of,", "")
    made = solution.report.transport
    if made == "shooting":
        raise ValueError("shooting keeps no exchange to send importance back through: solve with "
                         "transport='sampled' or 'hierarchical', or on form factors")  # fmt: skip
    if made == "on_demand":
        raise ValueError(f"{solution.report.solver} drew rows when they shot and kept no exchange: solve with "
                         "transport='sampled' or 'hierarchical', or on form factors")  # fmt: skip


def weights_of(patches: Patches, target: Functional) -> Floats:
    """(n_patches, n_bands) weights of irradiance.

    Raises:
        ValueError: there is no such surface, or weights do not fit.
    """
    shape = (len(patches), len(patches.scene.bands))
    if isinstance(target, str):
        share = np.where(named(patches, target), patches.area, 0.0)
        if not share.sum() > 0:
            raise ValueError(f"surface '{target}' has no area to take a mean over")
        return np.repeat((share / share.sum())[:, None], shape[1], axis=1)
    array = np.asarray(target, dtype=np.float64)
    if array.shape not in (shape[:1], shape):
        raise ValueError(f"a target is the name of a surface or weights of shape {shape[:1]} or {shape}, "
                         f"not {array.shape}")  # fmt: skip
    if not np.all(np.isfinite(array)):
        raise ValueError(f"the weight of patch {np.argwhere(~np.isfinite(array))[0][0]} is not finite")
    return np.array(np.broadcast_to(array if array.ndim == 2 else array[:, None], shape))


def names(patches: Patches) -> list[str]:
    """Of the surfaces, each once, in the order of the scene."""
    return list(dict.fromkeys(surface.name for surface in patches.scene.surfaces))


def named(patches: Patches, name: str) -> npt.NDArray[np.bool_]:
    """(n_patches,) whether a patch is of a surface of that name.

    Raises:
        ValueError: there is no such surface.
    """
    surfaces = [k for k, surface in enumerate(patches.scene.surfaces) if surface.name == name]
    if not surfaces:
        raise unknown("surface", name, names(patches))
    return np.isin(patches.surface, surfaces)


def those_near(name: str, known: Sequence[str]) -> list[str]:
    """The names that are like one, or the first of them if none is."""
    return get_close_matches(name, known, n=3, cutoff=0.5) or list(known[:8])


def unknown(what: str, name: str, known: Sequence[str]) -> ValueError:
    """The error about a name that nothing has, with those that are near."""
    near = those_near(name, known)
    if not near:
        return ValueError(f"there is no {what} '{name}': the scene has none")
    more = " ..." if len(near) == 8 < len(known) else ""
    return ValueError(f"there is no {what} '{name}'; there is {', '.join(repr(n) for n in near)}{more}")


__all__ = ["Functional", "Sensitivity", "SurfaceSensitivity"]
