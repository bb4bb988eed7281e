"""Arguments that must be whole numbers within bounds, and what stands for them where they are not given."""

from __future__ import annotations

import operator
import os
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


def memory_or_most(limit: SupportsIndex | None) -> int:
    """A number of bytes; None for four fifths of the memory that is free now, where the system says."""
    if limit is not None:
        return whole(limit, "memory_limit", 0, 2**64 - 1)
    try:
        pages, size = os.sysconf("SC_AVPHYS_PAGES"), os.sysconf("SC_PAGE_SIZE")
    except (ValueError, OSError, AttributeError):
        return (1 << 64) - 1
    return int(0.8 * pages * size)
