"""How wrong an answer is, why, and what would make it better."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from radiosity.report import Report

Floats = npt.NDArray[np.float64]

_MEANING = {
    "sampling": "too few rays a patch, visibility included",
    "interreflection": "noise of other patches, which arrives as their light does",
    "transport": "light that varies over patches, sent on as if it varied less",
    "balance": "power that is not accounted for, and what the solver left",
    "mesh": "light that varies over patches otherwise than the field through their values",
}

_REMEDY = {
    "sampling": "more rays: ask for a better accuracy, or raise max_rays",
    "interreflection": "more rays: ask for a better accuracy, or raise max_rays",
    "transport": "smaller patches where light varies, or more rays, which resolve smaller elements",
    "balance": "more rays; in a room, also a closed model without doubtful faces (radiosity check)",
    "mesh": "smaller patches where light varies: leave the mesh to the engine, or raise max_patches",
}


@dataclass(frozen=True, eq=False)
class Certificate:
    """The error of a solution, split into its causes.

    Attributes:
        error: (n_patches, n_bands) standard error of the irradiance of each patch, W/m2, all causes that count.
        by_cause: the same for each cause alone.
        whole: root mean square over area and bands of each cause, relative to the mean irradiance.
        interval: what holds the error of the whole, relative to the mean irradiance, nine times in ten.
        estimated_error: its upper end.
        of_field: whether "mesh" counts. It does where the engine chose the mesh and the answer is a field, piecewise
            linear over patches; on patches that were given, the answer is the mean over each.
    """

    error: Floats
    by_cause: dict[str, Floats]
    whole: dict[str, float]
    estimated_error: float
    interval: tuple[float, float]
    of_field: bool

    @classmethod
    def of(cls, report: Report, error: Floats, by_cause: dict[str, Floats]) -> Certificate:
        """From what a solve said."""
        return cls(error, by_cause, dict(report.causes), report.estimated_error, report.interval, report.of_field)

    @property
    def largest(self) -> str:
        """The cause that counts most; empty if nothing is wrong."""
        counting = {cause: e for cause, e in self.whole.items() if e > 0 and (self.of_field or cause != "mesh")}
        return max(counting, key=lambda cause: counting[cause]) if counting else ""

    @property
    def advice(self) -> str:
        """What would reduce the error most."""
        return _REMEDY[self.largest] if self.largest else "nothing: no error is known of"

    def __str__(self) -> str:
        low, high = self.interval
        lines = [f"error of irradiance  {low:.3%} to {high:.3%} of its mean, nine times in ten"]
        lines += [f"  by {cause:<17} {error:.3%}  {self._note(cause)}" for cause, error in self.whole.items()]
        return "\n".join([*lines, f"to reduce it most     {self.advice}"])

    def _note(self, cause: str) -> str:
        left_out = "" if self.of_field or cause != "mesh" else "; does not count for the means of patches"
        return _MEANING[cause] + left_out
