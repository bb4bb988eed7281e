r"""Walking through a solution in a browser.

    Solution, LitModel --layers--> Lit --packet--> bytes --page--> one file that works offline
                                                       \--server--> a browser beside this process

The page is a single HTML file that ``make viewer`` builds from ``viewer/`` (TypeScript, three.js). It knows nothing of
how light is found: it is given packets (:mod:`packet`), and where a server is behind it, they and messages
(:mod:`messages`) go both ways over one websocket. The server (:mod:`server`) guards; the session behind it
(:mod:`session`) solves and relights in one thread of its own, so that nothing waits for light.

    >>> import radiosity.viewer
    >>> radiosity.viewer.view("room.glb")  # doctest: +SKIP
    >>> radiosity.viewer.export("room.html", solution, layers=True)  # doctest: +SKIP
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from radiosity.viewer.page import MissingPageError
    from radiosity.viewer.showing import export, view

__all__ = ["MissingPageError", "export", "view"]

# Imported when first used: who reads or exports pages needs no server.
_HOME = {"MissingPageError": "page", "export": "showing", "view": "showing"}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'radiosity.viewer' has no attribute '{name}'")
    value = getattr(importlib.import_module(f"radiosity.viewer.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(set(globals()) | set(__all__))
