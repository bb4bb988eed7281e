"""Form factors as a linear operator."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_array
from scipy.sparse.linalg import LinearOperator

from radiosity import _native
from radiosity.checks import threads_or_all, whole

if TYPE_CHECKING:
    from radiosity.patches import Patches

Floats = npt.NDArray[np.float64]

DEFAULT_RAYS = 4096
"""Rays per patch of the method ``monte_carlo``."""

MAX_RAYS = 1 << 22
"""The most rays per patch."""


class FormFactors(LinearOperator):  # type: ignore[misc]
    """F with ``F[i, j]`` the fraction of what leaves patch i that arrives at patch j, (n, n).

    Stored as the symmetric exchange ``G = A F``, so that ``A_i F_ij = A_j F_ji`` holds exactly. Row sums are what was
    measured, never normalised.
    """

    def __init__(self, patches: Patches, native: _native.Factors) -> None:
        if bool(np.any(patches.two_sided)):
            raise ValueError("form factors between patches need one-sided surfaces: set two_sided=False")
        self.patches = patches
        self._native = native
        with np.errstate(divide="ignore"):
            self._inverse_area = np.where(patches.area > 0, 1 / patches.area, 0.0)
        super().__init__(dtype=np.float64, shape=(len(patches), len(patches)))

    def _matmat(self, x: npt.ArrayLike) -> Floats:
        block = np.ascontiguousarray(x, dtype=np.float64)
        return self._native.exchange(block) * self._inverse_area[:, None]

    def _matvec(self, x: npt.ArrayLike) -> Floats:
        return self._matmat(np.reshape(x, (-1, 1)))[:, 0]

    def _rmatvec(self, x: npt.ArrayLike) -> Floats:
        # F^T = (A^-1 G)^T = G A^-1.
        scaled = np.ascontiguousarray((np.ravel(x) * self._inverse_area)[:, None])
        return self._native.exchange(scaled)[:, 0]

    def row(self, i: int) -> Floats:
        """(n,) form factors from patch i."""
        if not -len(self.patches) <= i < len(self.patches):
            raise IndexError(f"row {i} of {len(self.patches)} patches")
        columns, values = self._native.entries(i % len(self.patches))
        row: Floats = np.bincount(columns, values, len(self.patches)) * self._inverse_area[i]
        return row

    def toarray(self) -> Floats:
        """(n, n) dense form factors."""
        dense: Floats = self.to_scipy_sparse().toarray()
        return dense

    def to_scipy_sparse(self) -> csr_array:
        """(n, n) compressed rows."""
        n = len(self.patches)
        rows = [self._native.entries(i) for i in range(n)]
        counts = np.array([len(columns) for columns, _ in rows])
        columns = np.concatenate([c for c, _ in rows]) if n else np.zeros(0, int)
        values = np.concatenate([v for _, v in rows]) if n else np.zeros(0)
        matrix = csr_array(
            (values * np.repeat(self._inverse_area, counts), columns, np.concatenate([[0], np.cumsum(counts)])),
            shape=(n, n),
        )
        matrix.sum_duplicates()
        return matrix

    def closure(self) -> Floats:
        """(n,) raw row sums: 1 in a closed enclosure up to the error of the method, never normalised."""
        return self._matvec(np.ones(len(self.patches)))


def form_factors(
    patches: Patches,
    *,
    method: Literal["auto", "monte_carlo"] = "auto",
    tolerance: float | None = None,
    rays: int | None = None,
    seed: int = 0,
    threads: int | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> FormFactors:
    """Measure the form factors between all patches of an occluded scene.

    Args:
        patches: one-sided patches.
        method: "monte_carlo" shoots quasi-random cosine-distributed rays from every patch; "auto" chooses it.
        tolerance: wanted standard error of one form factor; sets ``rays`` to 1 / (4 tolerance^2), the worst case.
        rays: rays per patch (default 4,096).
        seed, threads, progress: as in :func:`radiosity.solve`.

    Raises:
        ValueError: a tolerance that needs more than 2^22 rays per patch, or two-sided patches.
    """
    if method not in ("auto", "monte_carlo"):
        raise ValueError(f"there is no method '{method}'; choose auto or monte_carlo")
    if rays is None:
        rays = DEFAULT_RAYS if tolerance is None else _rays_for(tolerance)
    rays, seed = whole(rays, "rays", 1, MAX_RAYS), whole(seed, "seed", 0, 2**64 - 1)
    native = _native.form_factors(patches._enclosure, rays, seed, threads_or_all(threads), progress)
    return FormFactors(patches, native)


def _rays_for(tolerance: float) -> int:
    """Rays that bring the standard error of the worst factor, 1/2, down to ``tolerance``."""
    least = 0.5 / MAX_RAYS**0.5
    if not least <= tolerance < np.inf:
        raise ValueError(f"a tolerance of {tolerance} is out of reach: ask for {least:.1e} or more")
    return int(np.ceil(0.25 / tolerance**2))
