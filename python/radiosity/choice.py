"""How a scene is best solved: by samples, on a hierarchical exchange, or by shooting."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from radiosity.patches import Patches

Way = Literal["sampled", "hierarchical", "shooting"]

MANY_SIDES = 15_000
"""From so many sides on, blocks beat samples of every side; measured on furnished rooms."""

FINEST_OF_BLOCKS = 2e-3
"""Blocks of rank one are slow to become more accurate than this."""

BYTES_OF_BLOCKS = 3_500
"""A hierarchical exchange and what it is built from take no more bytes a side, at the accuracies it is chosen for."""

TOO_MANY_SIDES = 500_000
"""From so many sides on, shooting has an answer while the exchange is still being built."""


def choose(patches: Patches, accuracy: float, memory_limit: int) -> tuple[Way, str]:
    """The way to solve, and why, in words for a report."""
    sides = len(patches) + int(np.count_nonzero(patches.two_sided))
    needed = BYTES_OF_BLOCKS * sides
    if patches.is_specular or patches.is_translucent:
        ways = "by mirrors and glass" if patches.is_specular else "through paper and leaves"
        return "sampled", f"nothing else follows light {ways}"
    if sides < MANY_SIDES:
        return "sampled", f"{sides:,} sides are few"
    if sides >= TOO_MANY_SIDES:
        return "shooting", f"{sides:,} sides are too many for an exchange to be worth its time"
    if needed > memory_limit:
        return "shooting", f"an exchange of {sides:,} sides may take {needed / 1e9:.1f} GB"
    if accuracy < FINEST_OF_BLOCKS:
        return "sampled", f"an accuracy of {accuracy:g} is beyond blocks"
    return "hierarchical", f"{sides:,} sides are many"
