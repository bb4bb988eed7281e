"""Arguments that must be whole numbers within bounds."""

from __future__ import annotations

import operator
from typing import SupportsIndex


def whole(value: SupportsIndex, what: str, least: int, most: int) -> int:
    """``value`` as an int within ``least`` and ``most``.

    Raises:
        ValueError: it is outside. TypeError: it is not a whole number.
    """
    number = operator.index(value)
    if not least <= number <= most:
        raise ValueError(f"{what} must be from {least} to {most}, not {number}")
    return number


def threads_or_all(threads: SupportsIndex | None) -> int | None:
    """A number of threads; None for all cores."""
    return None if threads is None else whole(threads, "threads", 1, 4096)
