"""What pages get to see: kept for those that come later, told at once to those that are there."""

from __future__ import annotations

import threading
from collections.abc import Callable

from radiosity.viewer.mailbox import MOST_POINTS, Post, written
from radiosity.viewer.messages import Convergence, Failed, Status

Hear = Callable[[str, Post], object]
"""Takes a packet or message of a kind; called by any thread, and must neither wait nor raise."""

SCENE, LIGHT = "scene", "light"


class Board:
    """The last scene, light and status, the points of the plot, and who wants to hear of more.

    Any thread may use it. What one page asked for is told to that page alone.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._last: dict[str, Post] = {}
        self._points: list[Post] = []
        self._listeners: list[Hear] = []

    def join(self, hear: Hear) -> None:
        """Tell what there is so far, and all that comes."""
        with self._lock:
            for kind in (SCENE, LIGHT):
                if kind in self._last:
                    hear(kind, self._last[kind])
            for point in self._points:
                hear("convergence", point)
            if "status" in self._last:
                hear("status", self._last["status"])
            self._listeners.append(hear)

    def leave(self, hear: Hear) -> None:
        """Tell no more."""
        with self._lock:
            self._listeners.remove(hear)

    def show(self, kind: str, packet: bytes) -> None:
        """A packet for all: a scene, or light on its patches."""
        with self._lock:
            if kind == SCENE:
                self._last.pop(LIGHT, None)
            self._tell(kind, packet)
            self._last[kind] = packet

    def say(self, message: Status | Convergence | Failed) -> None:
        """A message for all."""
        post = written(message)
        with self._lock:
            self._tell(message.type, post)
            if isinstance(message, Convergence):
                self._points = [*self._points[1 - MOST_POINTS :], post]
            elif isinstance(message, Status):
                self._last[message.type] = post

    def _tell(self, kind: str, post: Post) -> None:
        for hear in self._listeners:
            hear(kind, post)
