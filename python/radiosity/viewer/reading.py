"""Reading what a page says: strictly, since anybody might be at the other end of a socket."""

from __future__ import annotations

import dataclasses
import json
import math
import typing
from collections.abc import Collection
from dataclasses import dataclass
from typing import Any, NoReturn

from radiosity.viewer.messages import FROM_PAGE, MOST_REFLECTANCE, Relight, Stop

BRIGHTEST = 1e6
"""The most that a lamp may be multiplied by: light stays a number that a graphics card has."""

_SAID = 40
"""Characters of what was sent that an answer repeats."""


class BadMessageError(ValueError):
    """Text that is no message, or a message that asks for what there is not; it says what is wrong."""


@dataclass(frozen=True)
class Known:
    """What messages may speak of: how many surfaces, lamps and bands there are."""

    surfaces: int
    lamps: int
    bands: int


def read(text: str, known: Known) -> Relight | Stop:
    """The message in a text.

    Raises:
        BadMessageError: there is none, or it does not fit the scene.
    """
    said = _parsed(text)
    if not isinstance(said, dict):
        raise BadMessageError("a message is a JSON object")
    kinds = {_name(kind): kind for kind in FROM_PAGE}
    kind = said.pop("type", None)
    if not isinstance(kind, str) or kind not in kinds:
        raise BadMessageError(f"there is no message of the type {_short(kind)}; there are {', '.join(kinds)}")
    message: Relight | Stop = _filled(kinds[kind], said)
    if isinstance(message, Relight):
        _check(message.reflectance, "reflectance", known.surfaces, known.bands, MOST_REFLECTANCE)
        _check(message.lamps, "lamps", known.lamps, known.bands, BRIGHTEST)
    return message


def _name(kind: type) -> str:
    return next(str(field.default) for field in dataclasses.fields(kind) if field.name == "type")


def _parsed(text: str) -> Any:
    def refuse(constant: str) -> NoReturn:
        raise BadMessageError(f"{constant} is no number")

    try:
        return json.loads(text, parse_constant=refuse)
    except BadMessageError:
        raise
    except (ValueError, RecursionError):
        # The decoder's own words are about columns of a text that nobody wrote by hand.
        raise BadMessageError(f"this is no JSON: {_short(text)}") from None


def _filled(kind: type, said: dict[str, Any]) -> Any:
    """The dataclass with these fields, which must be its own, all of them and of its types."""
    hints = typing.get_type_hints(kind)
    wanted = [field.name for field in dataclasses.fields(kind) if field.init]
    missing, surplus = [n for n in wanted if n not in said], [n for n in said if n not in wanted]
    if missing:
        raise BadMessageError(f"{_name(kind)}: {missing[0]} is missing")
    if surplus:
        raise BadMessageError(f"{_name(kind)}: there is no field {_short(surplus[0])}")
    return kind(**{name: _checked(said[name], hints[name], name) for name in wanted})


def _checked(value: Any, hint: Any, where: str) -> Any:
    """The value, if it is of the type; whole numbers become floats."""
    arguments = typing.get_args(hint)
    if typing.get_origin(hint) is dict and isinstance(value, dict):
        return {key: _checked(item, arguments[1], f"{where} {_short(key)}") for key, item in value.items()}
    if typing.get_origin(hint) is list and isinstance(value, list):
        return [_checked(item, arguments[0], where) for item in value]
    if hint is float and isinstance(value, int | float) and not isinstance(value, bool):
        return _finite(value, where)
    raise BadMessageError(f"{where}: {_short(value)} is not what belongs there")


def _finite(value: float, where: str) -> float:
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise BadMessageError(f"{where}: a number is too large")
    return number


def _check(spectra: dict[str, list[float]], what: str, count: int, bands: int, most: float) -> None:
    """Keys must be indices, and spectra of the scene's bands within limits."""
    for key, values in spectra.items():
        if not is_index(key, range(count)):
            raise BadMessageError(f"{what}: there is no {_short(key)}; there are {count}, from 0 on")
        if len(values) != bands:
            raise BadMessageError(f"{what} {key}: give {bands} values, one a band, not {len(values)}")
        if not all(0 <= value <= most for value in values):
            raise BadMessageError(f"{what} {key}: values go from 0 to {most:g}")


def is_index(key: str, indices: Collection[int]) -> bool:
    """Whether a string is one of these numbers as JavaScript writes them."""
    return key.isascii() and key.isdecimal() and len(key) < 10 and int(key) in indices and str(int(key)) == key


def _short(value: Any) -> str:
    """What was sent, at a length that may be repeated."""
    text = value if isinstance(value, str) else json.dumps(value, default=str)
    return repr(text if len(text) <= _SAID else text[:_SAID] + "...")
