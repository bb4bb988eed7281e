"""Who may talk to the server: pages that it served itself, and nobody else.

Anything on this machine can reach a port of it, and any website can make a browser try to. What keeps them out: a
token in the address that nobody can guess, and the Host and Origin that browsers send and websites cannot forge. A Host
that is another's name would be a website whose name was pointed at this machine (DNS rebinding).
"""

from __future__ import annotations

import hmac
from http import HTTPStatus

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

PAGE, SOCKET = "/", "/socket"
"""What there is after the token."""

POLICY = "; ".join(
    [
        "default-src 'none'",
        "script-src 'unsafe-inline'",  # the page is one file
        "style-src 'unsafe-inline'",
        "img-src data: blob:",
        "worker-src blob:",
        "connect-src 'self' ws://{host}",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'none'",
    ]
)

HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
}


class Guard:
    """Lets through what has the token and comes from where it should; of both HTTP and websockets.

    Args:
        app: what is guarded.
        token: first segment of every path.
        port: that the server listens on.
    """

    def __init__(self, app: ASGIApp, token: str, port: int) -> None:
        self._app = app
        self._prefix = f"/{token}".encode()
        names = ("127.0.0.1", "localhost")
        self._hosts = [f"{name}:{port}" for name in names] + (list(names) if port == 80 else [])

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve, or refuse, without saying more than the number of the reason."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        headers, is_socket = Headers(scope=scope), scope["type"] == "websocket"
        status = self._verdict(headers, scope["raw_path"], is_socket=is_socket)
        if status == HTTPStatus.OK:
            await self._app(scope, receive, send if is_socket else _with_headers(send, headers["host"]))
        elif is_socket:
            # Before it is accepted, that is an answer 403.
            await send({"type": "websocket.close", "code": 1008})
        else:
            answer = PlainTextResponse(status.phrase, status)
            await answer(scope, receive, _with_headers(send, ""))

    def _verdict(self, headers: Headers, path: bytes, *, is_socket: bool) -> HTTPStatus:
        hosts, origins = headers.getlist("host"), headers.getlist("origin")
        if len(hosts) != 1 or hosts[0] not in self._hosts:
            return HTTPStatus.MISDIRECTED_REQUEST
        if origins not in ([], [f"http://{hosts[0]}"]) or (is_socket and not origins):
            return HTTPStatus.FORBIDDEN
        # The path as it was sent: what is encoded, doubled or climbs is none of the two there are.
        prefix, rest = path[: len(self._prefix)], path[len(self._prefix) :]
        has_token = hmac.compare_digest(prefix, self._prefix)
        wanted = SOCKET if is_socket else PAGE
        return HTTPStatus.OK if has_token and rest == wanted.encode() else HTTPStatus.NOT_FOUND


def _with_headers(send: Send, host: str) -> Send:
    """Send with what tells the browser to keep the page to itself."""

    async def sent(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            headers.update(HEADERS | {"Content-Security-Policy": POLICY.format(host=host) if host else _NOTHING})
        await send(message)

    return sent


_NOTHING = "default-src 'none'; frame-ancestors 'none'"
