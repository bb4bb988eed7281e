"""The list of configurations, which each function joins where it is defined."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])


@dataclass(frozen=True)
class Configuration:
    """One entry of the catalogue; call its ``function`` with arguments of your own."""

    function: Callable[..., Any]
    number: str
    """Where Howell's catalogue has it, such as "C-11"; empty where it has no number of its own here."""
    title: str
    """What radiates to what."""
    example: Mapping[str, Any]
    """Arguments by name."""
    value: float
    """The factor for the example."""

    @property
    def name(self) -> str:
        """The name of the function."""
        return str(self.function.__name__)

    def __str__(self) -> str:
        return f"{self.number or '-':6} {self.name}: {self.title}"


REGISTERED: list[Configuration] = []


def configuration(number: str, title: str, value: float, /, **example: Any) -> Callable[[Function], Function]:
    """Enter the decorated function in the catalogue, unchanged."""

    def enter(function: Function) -> Function:
        REGISTERED.append(Configuration(function, number, title, example, value))
        return function

    return enter
