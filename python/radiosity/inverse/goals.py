"""What is wanted, as rows of a least squares problem."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_array, vstack

from radiosity.patches import Patches
from radiosity.sensitivity import named, weights_of

if TYPE_CHECKING:
    from radiosity.inverse import Target
    from radiosity.solution import Solution

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Goals:
    """What is wanted, row by row: a sum of irradiance over patches, weighed over bands, and its value.

    Attributes:
        weights: (n_sums, n_patches) of irradiance, sparse.
        sums: (n_rows,) which sum.
        bands: (n_rows, n_bands) weights of bands.
        wanted: (n_rows,) W/m2.
        scale: (n_rows,) what missing it is relative to, W/m2.
        share: (n_rows,) how much of its target a row is; of a target they sum to 1.
        weight: (n_rows,) of the target.
        rows: of each target.
    """

    weights: csr_array
    sums: npt.NDArray[np.intp]
    bands: Floats
    wanted: Floats
    scale: Floats
    share: Floats
    weight: Floats
    rows: list[slice]

    @classmethod
    def of(cls, patches: Patches, targets: Sequence[Target]) -> Goals:
        """The rows of targets.

        Raises:
            ValueError: there are none, there is no such surface, or values make no sense.
        """
        if not targets:
            raise ValueError("there is no target: give the irradiance of at least one surface")
        parts = [_Part.of(patches, target) for target in targets]
        ends = np.cumsum([len(part.wanted) for part in parts])
        first_sum = np.cumsum([0, *(part.weights.shape[0] for part in parts[:-1])])
        wanted = np.concatenate([part.wanted for part in parts])
        share = np.concatenate([part.share for part in parts])
        mean = np.average(wanted, weights=share)
        return cls(
            weights=vstack([part.weights for part in parts], format="csr"),
            sums=np.concatenate([part.sums + k for part, k in zip(parts, first_sum, strict=True)]),
            bands=np.concatenate([part.bands for part in parts]),
            wanted=wanted,
            scale=np.where(wanted > 0, wanted, mean if mean > 0 else 1.0),
            share=share,
            weight=np.concatenate([np.full(len(p.wanted), t.weight) for p, t in zip(parts, targets, strict=True)]),
            rows=[slice(end - len(part.wanted), end) for part, end in zip(parts, ends.tolist(), strict=True)],
        )

    @property
    def factor(self) -> Floats:
        """(n_rows,) what a miss is multiplied by in the sum of squares."""
        return self.weight * np.sqrt(self.share) / self.scale

    def values(self, solution: Solution) -> Floats:
        """(n_rows,) W/m2 on a solution."""
        return np.asarray(np.sum(self.bands * (self.weights @ solution.irradiance)[self.sums], axis=1))

    def residual(self, values: Floats) -> float:
        """Root mean square of relative misses, weighted."""
        squares = np.sum((self.factor * (values - self.wanted)) ** 2)
        return float(np.sqrt(squares / max(np.sum(self.weight**2 * self.share), 1e-300)))

    def miss(self, target: int, values: Floats) -> float:
        """Root mean square relative miss of one target."""
        of = self.rows[target]
        return float(np.sqrt(np.sum(self.share[of] * ((values - self.wanted)[of] / self.scale[of]) ** 2)))

    def means(self, target: int, values: Floats) -> tuple[float | Floats, float | Floats]:
        """What one target wanted and got: a number, or one a band."""
        of = self.rows[target]
        bands, index = np.unique(self.bands[of], axis=0, return_inverse=True)
        order = np.argsort([np.flatnonzero(index.ravel() == k)[0] for k in range(len(bands))])
        found = [
            [float(np.average(v[of][index.ravel() == k], weights=self.share[of][index.ravel() == k])) for k in order]
            for v in (self.wanted, values)
        ]
        return (found[0][0], found[1][0]) if len(order) == 1 else (np.array(found[0]), np.array(found[1]))


@dataclass(frozen=True, eq=False)
class _Part:
    """The rows of one target; fields as in :class:`Goals`."""

    weights: csr_array
    sums: npt.NDArray[np.intp]
    bands: Floats
    wanted: Floats
    share: Floats

    @classmethod
    def of(cls, patches: Patches, target: Target) -> _Part:
        value, is_grey = _checked(patches, target)
        n_bands = len(patches.scene.bands)
        mean = weights_of(patches, target.surface)[:, 0]
        spectra = np.full((1, n_bands), 1 / n_bands) if is_grey else np.eye(n_bands)
        if value.ndim < 2 and not target.even:
            weights, area, value = csr_array(mean[None]), np.ones(1), value.reshape(1, -1)
        else:
            on = np.flatnonzero(named(patches, target.surface))
            has_area = mean[on] > 0
            value = value[has_area] if value.ndim == 2 else value.reshape(1, -1)
            on = on[has_area]
            area = mean[on]
            weights = csr_array((np.ones(len(on)), (np.arange(len(on)), on)), shape=(len(on), len(mean)))
        rows, kinds = len(area), len(spectra)
        return cls(
            weights, np.repeat(np.arange(rows), kinds), np.tile(spectra, (rows, 1)),
            np.broadcast_to(value, (rows, kinds)).ravel().copy(), np.repeat(area, kinds) / kinds,
        )  # fmt: skip


def _checked(patches: Patches, target: Target) -> tuple[Floats, bool]:
    """The value of a target, and whether it is of the mean over bands.

    Raises:
        ValueError: it makes no sense.
    """
    value, n_bands = np.asarray(target.value, dtype=np.float64), len(patches.scene.bands)
    n_patches = int(np.count_nonzero(named(patches, target.surface)))
    where = f"the target of surface '{target.surface}'"
    if not (np.all(np.isfinite(value)) and np.all(value >= 0)):
        raise ValueError(f"{where} must be finite and not negative, in W/m2, not {value.tolist()}")
    if not (np.isfinite(target.weight) and target.weight > 0):
        raise ValueError(f"the weight of {where} must be a positive number, not {target.weight}")
    if value.ndim == 2 and (len(value) != n_patches or value.shape[1] not in (1, n_bands)):
        raise ValueError(f"{where} has a row for each of {value.shape[0]} patches and {value.shape[1]} bands: "
                         f"the surface has {n_patches} patches, the scene {n_bands} bands")  # fmt: skip
    if value.ndim > 2 or (value.ndim == 1 and len(value) != n_bands):
        raise ValueError(f"{where} is a number, one for each of {n_bands} bands, or a row for each of {n_patches} "
                         f"patches, not an array of shape {value.shape}")  # fmt: skip
    return value, value.ndim == 0 or (value.ndim == 2 and value.shape[1] == 1 != n_bands)
