"""A solution on its way, as ``solve(..., on_iterate=...)`` shows it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from radiosity.patches import Patches

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Snapshot:
    """What a solver has after some iterations.

    Attributes:
        patches: what it is on.
        iteration: products, sweeps or shots so far.
        residual: relative residual of the worst band.
        unshot: power that has arrived but was not sent on, as a share of what is emitted; None where the solver does
            not know it.
        radiosity: (n_patches, n_bands) W/m2, of the fronts.
        ambient: (n_bands,) irradiance that is still to come if it comes evenly everywhere, W/m2; zero where the solver
            does not estimate it.
        reflectance: (n_patches, n_bands).
    """

    patches: Patches
    iteration: int
    residual: float
    unshot: float | None
    radiosity: Floats
    ambient: Floats
    reflectance: Floats

    def with_ambient(self) -> Floats:
        """(n_patches, n_bands) radiosity with the light that is still to come, W/m2: what a picture should show.

        Cohen, Chen, Wallace and Greenberg 1988. Only for looking at: the solver does not use it.
        """
        return self.radiosity + self.reflectance * self.ambient


OnIterate = Callable[[Snapshot], object]
"""Called after every iteration; the solve waits for it, and ends if it returns False."""


def handed_to(callback: OnIterate | None, patches: Patches, reflectance: Floats) -> Callable[..., object] | None:
    """What the engine calls, so that ``callback`` sees snapshots."""
    if callback is None:
        return None

    def call(iteration: int, residual: float, unshot: float | None, radiosity: Floats, ambient: list[float]) -> Any:
        return callback(Snapshot(patches, iteration, residual, unshot, radiosity, np.array(ambient), reflectance))

    return call
