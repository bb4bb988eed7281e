"""What the pictures share: matplotlib, imported when it is needed, and colours."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Okabe and Ito 2008, "Color universal design", without its black, and after it the muted scheme of Tol 2021.
PALETTE = (
    "#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#F0E442",
    "#882255", "#44AA99", "#DDCC77", "#332288", "#117733", "#AA4499", "#999933",
)  # fmt: skip
"""Colours that those who do not tell red from green tell apart."""

INK = "#222222"
"""Of text and outlines."""

STYLE: dict[Any, Any] = {
    "font.size": 11,
    "axes.titlesize": 13,
    "axes.titlepad": 10,
    "axes.edgecolor": INK,
    "text.color": INK,
    "axes.labelcolor": INK,
    "savefig.dpi": 160,
    "savefig.facecolor": "white",
}
"""Of all pictures: the parameters that matplotlib calls rc."""


def style() -> AbstractContextManager[None]:
    """A context in which figures look alike.

    Raises:
        ImportError: matplotlib is not installed.
    """
    try:
        from matplotlib import rc_context  # noqa: PLC0415
    except ImportError as error:
        raise ImportError("pictures need matplotlib: pip install 'radiosity[plots]'") from error
    return rc_context(STYLE)


def new_figure(width: float, height: float) -> Figure:
    """An empty figure, inches, that no window shows and nothing else knows of."""
    from matplotlib.figure import Figure  # noqa: PLC0415

    return Figure(figsize=(width, height), facecolor="white")
