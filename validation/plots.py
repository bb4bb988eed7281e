"""Plots of how errors fall, written to validation/out/."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from radiosity.teaching.figures import INK, PALETTE, style

OUT = Path(__file__).parent / "out"

MARKERS = "osD^vP*X"

Series = Mapping[str, tuple[Sequence[float], Sequence[float]]]
"""Abscissae and errors by label."""

SMALLEST = 1e-17
"""Where errors that are zero are drawn."""


@dataclass(frozen=True)
class Guide:
    """A dashed line of a known rate."""

    slope: float
    label: str
    through: tuple[float, float]
    """A point on it."""


def rate(x: Sequence[float], error: Sequence[float]) -> float:
    """The slope of a straight line through errors, both axes logarithmic."""
    return float(np.polyfit(np.log(x), np.log(error), 1)[0])


def plot_errors(
    name: str,
    title: str,
    x_label: str,
    series: Series,
    guides: Sequence[Guide] = (),
    y_label: str = "error of F",
    *,
    whole_guides: bool = False,
) -> None:
    """Write ``NAME.png``: errors over something, both axes logarithmic, and as much of the guides as beside them."""
    OUT.mkdir(exist_ok=True)
    with style():
        figure = Figure(figsize=(9.5, 5), layout="constrained")
        axes = figure.add_subplot()
        for k, (label, (x, error)) in enumerate(series.items()):
            drawn = np.maximum(np.abs(error), SMALLEST)
            axes.loglog(x, drawn, marker=MARKERS[k % len(MARKERS)], color=PALETTE[k], markersize=5.5, label=label)
        every = np.concatenate([x for x, _ in series.values()])
        span = np.array([every.min(), every.max()])
        low, high = axes.get_ylim()
        for guide, dash in zip(guides, ("--", ":", "-."), strict=False):
            x0, y0 = guide.through
            axes.loglog(span, y0 * (span / x0) ** guide.slope, dash, color=INK, linewidth=1.1, label=guide.label)
        axes.set(xlabel=x_label, ylabel=y_label)
        if not whole_guides:
            axes.set_ylim(low, high)
        axes.set_title(title)
        axes.grid(which="major", color="#DDDDDD", linewidth=0.7)
        axes.set_axisbelow(True)
        figure.legend(loc="outside right upper", frameon=False, fontsize=10)
        figure.savefig(OUT / f"{name}.png")
