"""The server of the page: on this machine, for this user, until it is told to stop.

It guards (:mod:`guard`) and carries packets and messages to and fro; what they mean is for the session.
"""

from __future__ import annotations

import asyncio
import secrets
import socket
import threading
from types import TracebackType

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import HTMLResponse
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket

from radiosity.viewer.board import Hear
from radiosity.viewer.guard import PAGE, SOCKET, Guard
from radiosity.viewer.mailbox import Mailbox, Post, written
from radiosity.viewer.messages import Failed
from radiosity.viewer.page import page
from radiosity.viewer.reading import BadMessageError, read
from radiosity.viewer.session import Session

HOST = "127.0.0.1"

MOST_BYTES = 1 << 16
"""Of a message from a page."""

MOST_PAGES = 16
"""Pages that may be open at once."""

MOST_CONNECTIONS = 200

_TOO_BUSY = 1013


class Server:
    """Serves the page of one session; as a context, from when it begins to when it ends.

    Args:
        session: what is behind the page.
        port: to listen on; a free one if not given.

    Raises:
        MissingPageError: there is no page to serve.
        OSError: the port cannot be had.
    """

    def __init__(self, session: Session, port: int | None = None) -> None:
        self._session, self._page = session, page()
        self._socket = _listening(port or 0)
        self.port: int = self._socket.getsockname()[1]
        self.token = secrets.token_urlsafe(24)
        self._pages = 0
        config = uvicorn.Config(
            self._app(), ws_max_size=MOST_BYTES, ws_per_message_deflate=False, limit_concurrency=MOST_CONNECTIONS,
            lifespan="off", log_config=None, log_level="error", access_log=False, server_header=False,
            proxy_headers=False, timeout_graceful_shutdown=1,
        )  # fmt: skip
        self._server = uvicorn.Server(config)
        self._thread = threading.Thread(target=self._serve, name="radiosity-server", daemon=True)

    @property
    def address(self) -> str:
        """What to open in a browser."""
        return f"http://{HOST}:{self.port}/{self.token}/"

    def __enter__(self) -> Server:
        self._session.start()
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._server.should_exit = True
        self._session.close(0.2)
        self._thread.join(0.4)

    def wait(self) -> None:
        """Wait until the server ends, which it does not do by itself, or for Ctrl-C."""
        while self._thread.is_alive():
            # Not for ever: some systems let no signal through to a thread that waits without end.
            self._thread.join(0.5)

    def _serve(self) -> None:
        self._server.run(sockets=[self._socket])

    def _app(self) -> Guard:
        routes = [
            Route(f"/{self.token}{PAGE}", self._answer, methods=["GET"]),
            WebSocketRoute(f"/{self.token}{SOCKET}", self._talk),
        ]
        return Guard(Starlette(routes=routes), self.token, self.port)

    async def _answer(self, _request: Request) -> HTMLResponse:
        return HTMLResponse(self._page)

    async def _talk(self, websocket: WebSocket) -> None:
        """Carry to one page what the session says, and back, until either ends."""
        if self._pages >= MOST_PAGES:
            await websocket.close(_TOO_BUSY)
            return
        await websocket.accept()
        mailbox, loop = Mailbox(), asyncio.get_running_loop()

        def hear(kind: str, post: Post) -> None:
            # The loop may be closed already while the session still works.
            if not loop.is_closed():
                loop.call_soon_threadsafe(mailbox.put, kind, post)

        self._pages += 1
        self._session.join(hear)
        tasks = [asyncio.create_task(work) for work in (_carry(mailbox, websocket), self._listen(websocket, hear))]
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            self._pages -= 1
            self._session.leave(hear)
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    async def _listen(self, websocket: WebSocket, hear: Hear) -> None:
        while (event := await websocket.receive())["type"] != "websocket.disconnect":
            try:
                if event.get("text") is None:
                    raise BadMessageError("messages are text")
                self._session.take(read(event["text"], self._session.known), hear)
            except BadMessageError as error:
                hear("failed", written(Failed(str(error))))
            # Whoever floods us must not keep others waiting.
            await asyncio.sleep(0)


async def _carry(mailbox: Mailbox, websocket: WebSocket) -> None:
    while True:
        post = await mailbox.take()
        await (websocket.send_bytes(post) if isinstance(post, bytes) else websocket.send_text(post))


def _listening(port: int) -> socket.socket:
    listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.bind((HOST, port))
        # From now on, so that a browser that is quicker than the server waits instead of being refused.
        listening.listen(128)
    except OSError as error:
        listening.close()
        raise OSError(error.errno, f"port {port}: {error.strerror}; choose another, or none for a free one") from error
    return listening
