"""What is still to be sent to one page: never more than it could use."""

from __future__ import annotations

import asyncio
import json
from dataclasses import asdict

from radiosity.viewer.messages import Convergence, Failed, Status

MOST_POINTS = 2000
"""Points of the plot that wait at most; a page that is so far behind does without the oldest."""

Post = bytes | str
"""A packet, or the JSON of a message."""


class Mailbox:
    """Packets and messages for a page, in order; what is newer takes the place of what it makes useless.

    So a page that is slow, or does not read at all, has at most a scene, a light, and some messages waiting for it.
    Used from the thread of the event loop only.
    """

    def __init__(self) -> None:
        self._waiting: dict[object, Post] = {}
        self._points = 0
        self._arrived = asyncio.Event()

    def put(self, kind: str, post: Post) -> None:
        """Leave a packet or message; ``kind`` is the type of its head, or its own."""
        if kind == "scene":
            # Light on the patches before says nothing about these.
            self._waiting.pop("light", None)
        if kind == "convergence":
            self._points += 1
            self._waiting.pop((kind, self._points - MOST_POINTS), None)
            self._waiting[kind, self._points] = post
        else:
            self._waiting.pop(kind, None)
            self._waiting[kind] = post
        self._arrived.set()

    async def take(self) -> Post:
        """The first that waits."""
        while not self._waiting:
            self._arrived.clear()
            await self._arrived.wait()
        return self._waiting.pop(next(iter(self._waiting)))

    def __len__(self) -> int:
        return len(self._waiting)


def written(message: Status | Convergence | Failed) -> str:
    """The JSON of a message."""
    return json.dumps(asdict(message), allow_nan=False)
