"""What the functions of the catalogue ask of their arguments, and the shape of their answers."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

Length = npt.ArrayLike
"""Metres; any shape that broadcasts with the other arguments."""

Angle = npt.ArrayLike
"""Radians; any shape that broadcasts with the other arguments."""

Interval = tuple[npt.ArrayLike, npt.ArrayLike]
"""Where something starts and where it ends, in metres along one axis."""

Factor = np.float64 | Floats
"""A configuration factor: a scalar where all arguments are scalars, otherwise an array of their common shape."""


def require(holds: npt.ArrayLike, sentence: str) -> None:
    """Raise ValueError with the sentence unless the condition holds everywhere."""
    if not np.all(holds):
        raise ValueError(sentence)


def finite(**values: npt.ArrayLike) -> list[Floats]:
    """The named values as float64 arrays; ValueError for what is not a finite number."""
    arrays = []
    for name, value in values.items():
        try:
            array = np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise ValueError(f"{name} must be a number or an array of numbers, not {value!r}") from error
        require(np.isfinite(array), f"{name} must be finite, not {_first(array, np.isfinite(array))}: give a number")
        arrays.append(array)
    return arrays


def positive(**values: npt.ArrayLike) -> list[Floats]:
    """The named values as arrays of numbers above zero."""
    arrays = finite(**values)
    for name, array in zip(values, arrays, strict=True):
        require(array > 0, f"{name} must be positive, not {_first(array, array > 0)}: give a size in metres above zero")
    return arrays


def nonnegative(**values: npt.ArrayLike) -> list[Floats]:
    """The named values as arrays of numbers that are zero or more."""
    arrays = finite(**values)
    for name, array in zip(values, arrays, strict=True):
        require(array >= 0, f"{name} must not be negative, but is {_first(array, array >= 0)}: give zero or metres")
    return arrays


def within(least: float, most: float, **angles: npt.ArrayLike) -> list[Floats]:
    """The named angles as arrays; ValueError for what is not between the bounds, both allowed."""
    arrays = finite(**angles)
    for name, array in zip(angles, arrays, strict=True):
        inside = (array >= least) & (array <= most)
        require(inside, f"{name} must be from {least:.6g} to {most:.6g} radians, not {_first(array, inside)}")
    return arrays


def interval(least: float = -np.inf, **ends: Interval) -> list[Floats]:
    """Start and end of the named interval as arrays; ValueError unless least <= start < end."""
    ((name, (first, last)),) = ends.items()
    start, end = finite(**{f"start of {name}": first, f"end of {name}": last})
    require(start < end, f"{name} must start before it ends: exchange its two numbers, or correct them")
    require(start >= least, f"{name} must not start below {least:g}: move or cut the surface")
    return [start, end]


def points(**values: npt.ArrayLike) -> list[Floats]:
    """The named points as arrays (..., 3)."""
    arrays = finite(**values)
    for name, array in zip(values, arrays, strict=True):
        require(array.ndim > 0 and array.shape[-1] == 3, f"{name} must have x, y, z along its last axis, (..., 3)")
    return arrays


def answer(values: npt.ArrayLike) -> Factor:
    """A scalar for an array without dimensions, otherwise the array; what rounding left below 0 is 0."""
    result: Factor = np.maximum(np.asarray(values, dtype=np.float64), 0.0)[()]
    return result


def _first(array: Floats, fine: npt.NDArray[np.bool_]) -> float:
    """The first value that is not fine, for a message."""
    return float(array[~fine][0]) if not np.all(fine) else 0.0
