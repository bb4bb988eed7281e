"""``python -m radiosity.viewer.typescript viewer/src/messages.ts`` writes the messages as TypeScript has them."""

from __future__ import annotations

import dataclasses
import inspect
import sys
import types
import typing
from pathlib import Path
from typing import Any

from radiosity.viewer import messages

_PLAIN = {str: "string", int: "number", float: "number", bool: "boolean", Any: "unknown"}


def written() -> str:
    """The TypeScript of all messages."""
    heads = [*_named(messages.HEADS), *messages.HEADS]
    parts = [
        "// Written by python -m radiosity.viewer.typescript from python/radiosity/viewer/messages.py.",
        "",
        f"export const VERSION = {messages.VERSION};",
        "",
        *(_interface(kind) for kind in [*heads, *messages.FROM_PAGE, *messages.TO_PAGE]),
        _union("Head", messages.HEADS),
        _union("FromPage", messages.FROM_PAGE),
        _union("ToPage", messages.TO_PAGE),
    ]
    return "\n".join(parts)


def _named(kinds: tuple[type, ...]) -> list[type]:
    """What the fields of these are made of, and has a name."""
    found: list[Any] = []
    for kind in kinds:
        for hint in typing.get_type_hints(kind).values():
            found += [a for a in typing.get_args(hint) if dataclasses.is_dataclass(a) and a not in found]
    return found


def _interface(kind: type) -> str:
    hints = typing.get_type_hints(kind)
    lines = [f"/** {(inspect.getdoc(kind) or '').splitlines()[0]} */", f"export interface {kind.__name__} {{"]
    for field in dataclasses.fields(kind):
        said = f'"{field.default}"' if field.name == "type" else _type(hints[field.name])
        lines.append(f"  {field.name}: {said};")
    return "\n".join([*lines, "}", ""])


def _type(hint: Any) -> str:
    if hint in _PLAIN:
        return _PLAIN[hint]
    if dataclasses.is_dataclass(hint) and isinstance(hint, type):
        return hint.__name__
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin is list:
        return f"{_type(arguments[0])}[]"
    if origin is tuple:
        return f"[{', '.join(_type(a) for a in arguments)}]"
    if origin is dict:
        return f"Record<{_type(arguments[0])}, {_type(arguments[1])}>"
    if origin in (types.UnionType, typing.Union):
        return " | ".join("null" if a is type(None) else _type(a) for a in arguments)
    raise TypeError(f"messages may not hold {hint}")


def _union(name: str, kinds: tuple[type, ...]) -> str:
    return f"export type {name} = {' | '.join(kind.__name__ for kind in kinds)};\n"


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(written(), encoding="utf-8")
