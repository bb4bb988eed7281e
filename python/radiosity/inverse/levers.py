"""What may change, as numbers within bounds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from radiosity.patches import Patches
from radiosity.scene import DirectionalLight, PointLight, SpotLight
from radiosity.sensitivity import named, unknown

if TYPE_CHECKING:
    from radiosity.inverse import Variable
    from radiosity.solution import Solution

Floats = npt.NDArray[np.float64]

Kind = str
"""emission, reflectance or strength."""

HIGHEST_REFLECTANCE = 0.99
"""Of any band of a paint that is looked for."""

DIMMEST = 0.05
"""What may shine is measured at no less than this part of the brightest, so that it is sampled."""


@dataclass(frozen=True, eq=False)
class Lever:
    """A variable on these patches: where it acts, what a number of it is.

    Attributes:
        kind, name, label: what it is, of whom, and how it is called in answers.
        on: (n_patches,) or (n_lights,) whether it acts there.
        spectra: (k, n_bands): one, or one a band.
        low, high, start: (k,).
        power: (k,) W for each unit.
    """

    kind: Kind
    name: str
    label: str
    on: npt.NDArray[np.bool_]
    spectra: Floats
    low: Floats
    high: Floats
    start: Floats
    power: Floats


@dataclass(frozen=True, eq=False)
class Levers:
    """All that may change; numbers of all side by side are x."""

    all: list[Lever]

    @classmethod
    def of_solution(cls, solution: Solution, variables: Sequence[Variable]) -> Levers:
        """Variables on a solution: lights that are dark in its scene were not measured and cannot be found any more.

        Raises:
            ValueError: there are none, there is no such surface or light, or bounds make no sense.
        """
        now = {"emission": solution.emission, "reflectance": solution.reflectance, "strength": solution.lights}
        return cls(_levers(solution.patches, variables, now, is_measured=True))

    @classmethod
    def of_patches(cls, patches: Patches, variables: Sequence[Variable]) -> Levers:
        """Variables on patches that are yet to be solved: what may shine begins as bright as it may.

        Raises:
            ValueError: as :meth:`of_solution`.
        """
        now = {"emission": patches.emission, "reflectance": patches.reflectance, "strength": _strengths(patches)}
        return cls(_levers(patches, variables, now, is_measured=False))

    def _joined(self, what: str) -> Floats:
        return np.concatenate([getattr(lever, what) for lever in self.all])

    @property
    def low(self) -> Floats:
        """(n,) lower bounds."""
        return self._joined("low")

    @property
    def high(self) -> Floats:
        """(n,) upper bounds."""
        return self._joined("high")

    @property
    def start(self) -> Floats:
        """(n,) what to begin with."""
        return self._joined("start")

    @property
    def power(self) -> Floats:
        """(n,) W for each unit."""
        return self._joined("power")

    @property
    def is_paint(self) -> npt.NDArray[np.bool_]:
        """(n,) whether it is a reflectance, in which irradiance is not linear."""
        return np.concatenate([np.full(len(lever.low), lever.kind == "reflectance") for lever in self.all])

    def parts(self, x: Floats) -> list[Floats]:
        """The numbers of each lever."""
        return np.split(x, np.cumsum([len(lever.low) for lever in self.all])[:-1])

    def by_name(self, x: Floats) -> dict[tuple[Kind, str], Floats]:
        """(n_bands,) spectra by kind and name."""
        pairs = zip(self.all, self.parts(x), strict=True)
        return {(lever.kind, lever.name): numbers @ lever.spectra for lever, numbers in pairs}

    def shining(self, x: Floats) -> Floats:
        """The same with all that may shine bright enough to be sampled."""
        bright = x.copy()
        for kind in ("emission", "strength"):
            of = np.concatenate([np.full(len(lever.low), lever.kind == kind) for lever in self.all])
            if np.any(of):
                level = x[of].max() if x[of].max() > 0 else self.start[of]
                bright[of] = np.minimum(np.maximum(x[of], DIMMEST * level), self.high[of])
        return bright

    def applied(self, solution: Solution, x: Floats) -> dict[str, Floats]:
        """What to relight a solution with."""
        blocks = {"emission": solution.emission, "reflectance": solution.reflectance, "lights": solution.lights}
        blocks = {name: block.copy() for name, block in blocks.items()}
        for lever, numbers in zip(self.all, self.parts(x), strict=True):
            blocks["lights" if lever.kind == "strength" else lever.kind][lever.on] = numbers @ lever.spectra
        if not np.any(blocks["reflectance"] != solution.reflectance):
            del blocks["reflectance"]
        return blocks

    def values(self, x: Floats) -> dict[str, float | Floats]:
        """By label: a number, or one a band."""
        pairs = zip(self.all, self.parts(x), strict=True)
        return {lever.label: float(v[0]) if len(lever.spectra) == 1 else v for lever, v in pairs}

    def at_bound(self, x: Floats) -> dict[str, str]:
        """By label: low, high or nothing."""

        def which(lever: Lever, v: Floats) -> str:
            span = np.where(np.isfinite(lever.high), lever.high - lever.low, np.maximum(np.abs(v), 1e-300))
            if np.any(v <= lever.low + 1e-6 * span):
                return "low"
            return "high" if np.any(v >= lever.high - 1e-6 * span) else ""

        return {lever.label: which(lever, v) for lever, v in zip(self.all, self.parts(x), strict=True)}


def _levers(
    patches: Patches, variables: Sequence[Variable], now: dict[Kind, Floats], *, is_measured: bool
) -> list[Lever]:
    if not variables:
        raise ValueError("there is nothing to vary: give bounds of at least one surface or light")
    keys = [(_kind(v), v.name) for v in variables]
    for kind, name in keys:
        if keys.count((kind, name)) > 1:
            raise ValueError(f"the {kind} of '{name}' is varied twice")
    levers = []
    for variable, (kind, name) in zip(variables, keys, strict=True):
        is_alone = sum(other == name for _, other in keys) == 1
        label = name if is_alone else f"{name} {kind}"
        levers.append(_lever(patches, variable, kind, label, now[kind], is_measured))
    return _with_starts(levers)


def _strengths(patches: Patches) -> Floats:
    """(n_lights, n_bands) of the scene."""
    n_bands = len(patches.scene.bands)
    return np.array([light._tuple(n_bands)[-1] for light in patches.scene.lights]).reshape(-1, n_bands)


def _kind(variable: Variable) -> Kind:
    kind = type(variable).__name__.lower()
    if kind not in ("emission", "reflectance", "strength"):
        raise ValueError(f"'{variable.name}': say what varies with Emission, Reflectance or Strength")
    return kind


def _lever(patches: Patches, variable: Variable, kind: Kind, label: str, given: Floats, is_measured: bool) -> Lever:
    """A variable on patches; `given` is what it is now, for each patch or light."""
    scene, name = patches.scene, variable.name
    if kind == "strength":
        on = np.array([light.name == name for light in scene.lights], dtype=bool)
        if not np.any(on):
            raise unknown("light", name, [light.name for light in scene.lights])
    else:
        on = named(patches, name)
        if not np.any(on):
            raise ValueError(f"surface '{name}' has no patches to vary")
    now = given[on].mean(axis=0)
    if is_measured and kind == "strength" and not np.any(_strengths(patches)[on] > 0):
        raise ValueError(
            f"light '{name}' is dark in the scene of this solution, and was not measured: pass the scene instead"
        )
    tint = _tint(variable, now)
    spectra = np.eye(len(now)) if variable.per_band else tint[None]
    low, high = _bounds(variable, kind, len(spectra))
    if kind == "reflectance":
        high = np.minimum(high, HIGHEST_REFLECTANCE / spectra.max(axis=1))
        if np.any(high <= low):
            raise ValueError(f"the reflectance of '{name}' exceeds {HIGHEST_REFLECTANCE:g} in some band at its lower "
                             f"bound {low.max():g}: choose another tint, or lower bounds")  # fmt: skip
    current = now if variable.per_band else np.array([now.mean()])
    start = np.clip(current, low, high)
    if kind != "reflectance" and not is_measured:
        start = np.where(np.isfinite(high), high, start)
    return Lever(kind, name, label, on, spectra, low, high, start, _power(patches, kind, on) * spectra.sum(axis=1))


def _tint(variable: Variable, now: Floats) -> Floats:
    """(n_bands,) with a mean of 1."""
    tint = now if variable.tint is None else np.asarray(variable.tint, dtype=np.float64)
    if tint.shape != now.shape or not (np.all(np.isfinite(tint)) and np.all(tint >= 0)):
        raise ValueError(f"the tint of '{variable.name}' must be {len(now)} numbers, one a band and none negative")
    if not np.any(tint > 0):
        if variable.tint is not None:
            raise ValueError(f"the tint of '{variable.name}' is black")
        return np.ones_like(now)
    return np.asarray(tint / tint.mean())


def _bounds(variable: Variable, kind: Kind, count: int) -> tuple[Floats, Floats]:
    try:
        low, high = (np.array(np.broadcast_to(np.asarray(b, np.float64), (count,))) for b in variable.bounds)
    except (ValueError, TypeError) as error:
        raise ValueError(f"the bounds of '{variable.name}' must be two numbers, least and most"
                         + (f", or two of {count} each" if count > 1 else "")) from error  # fmt: skip
    if not (np.all(low >= 0) and np.all(low < high) and np.all(np.isfinite(low))):
        raise ValueError(f"the bounds of '{variable.name}' must be 0 or more, the lower below the upper, "
                         f"not {variable.bounds}")  # fmt: skip
    if kind == "reflectance" and np.any(low >= HIGHEST_REFLECTANCE):
        raise ValueError(f"the reflectance of '{variable.name}' must stay below {HIGHEST_REFLECTANCE:g}")
    return low, high


def _power(patches: Patches, kind: Kind, on: npt.NDArray[np.bool_]) -> float:
    """W for a strength of one in one band."""
    if kind == "emission":
        return float(np.sum(patches.area[on] * (1 + patches.two_sided[on])))
    if kind == "reflectance":
        return 0.0
    return sum(_solid_angle(light) for light, varies in zip(patches.scene.lights, on, strict=True) if varies)


def _solid_angle(light: PointLight | SpotLight | DirectionalLight) -> float:
    """Power over intensity, sr."""
    if isinstance(light, PointLight):
        return 4 * np.pi
    if isinstance(light, SpotLight):
        # The square of a linear ramp in the cosine (KHR_lights_punctual) has a mean of a third.
        inner, outer = np.cos(light.inner_angle), np.cos(light.outer_angle)
        return float(2 * np.pi * (1 - inner + (inner - outer) / 3))
    return 0.0


def _with_starts(levers: list[Lever]) -> list[Lever]:
    """What has nothing to begin with begins as others of its kind do."""
    for kind in ("emission", "strength"):
        known = [v for lever in levers if lever.kind == kind for v in lever.start if v > 0]
        fill = float(np.median(known)) if known else 1.0
        for lever in (lever for lever in levers if lever.kind == kind):
            lever.start[lever.start == 0] = np.minimum(fill, lever.high[lever.start == 0])
    return levers
