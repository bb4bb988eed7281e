"""Who gets anything from the server, over real sockets, and that it outlives what it is sent."""

from __future__ import annotations

import http.client
import json
import os
import socket
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

import radiosity
from radiosity.viewer.packet import unpack
from radiosity.viewer.page import MissingPageError
from radiosity.viewer.server import MOST_BYTES, MOST_PAGES, Server
from radiosity.viewer.session import Session
from radiosity.viewer.settings import Settings

PATIENCE = 60


@pytest.fixture
def server(serve: Any, lit_room: radiosity.Solution) -> Server:
    return serve(lit_room, title="room")


def get(server: Server, path: str, method: str = "GET", **headers: str | None) -> http.client.HTTPResponse:
    """Answer to a request whose path goes out as it is; a header that is None is left out."""
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=PATIENCE)
    connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
    for name, value in {"host": f"127.0.0.1:{server.port}", **headers}.items():
        if value is not None:
            connection.putheader(name, value)
    connection.endheaders()
    answer = connection.getresponse()
    answer.body = answer.read()  # type: ignore[attr-defined]
    connection.close()
    return answer


def knock(server: Server, path: str = "socket", **headers: str | None) -> int:
    """The number that answers somebody who would have a websocket."""
    upgrade = {"upgrade": "websocket", "connection": "Upgrade", "sec-websocket-version": "13"}
    key = {"sec-websocket-key": "AAAAAAAAAAAAAAAAAAAAAA=="}
    return get(server, f"/{server.token}/{path}", **upgrade, **key, **headers).status


def dial(server: Server, name: str = "127.0.0.1") -> connect:
    """A websocket as a page opens it."""
    host = f"{name}:{server.port}"
    return connect(
        f"ws://{host}/{server.token}/socket", origin=f"http://{host}",  # type: ignore[arg-type]
        sock=socket.create_connection(("127.0.0.1", server.port), PATIENCE), max_size=None, open_timeout=PATIENCE,
        compression=None, proxy=None,
    )  # fmt: skip


@contextmanager
def talking(server: Server) -> Iterator[ClientConnection]:
    with dial(server) as page:
        until(page, type="status", stage="ready")
        yield page


def until(page: ClientConnection, **wanted: object) -> dict[str, Any]:
    """The next message or head that says so."""
    while True:
        post = page.recv(timeout=PATIENCE)
        head = unpack(post)[0] if isinstance(post, bytes) else json.loads(post)
        if wanted.items() <= head.items():
            return head


def assert_answers(server: Server) -> None:
    assert get(server, f"/{server.token}/").status == 200
    with talking(server) as page:
        page.send(json.dumps({"type": "relight", "reflectance": {}, "lamps": {}}))
        until(page, type="light")


def test_the_page_is_served_with_a_policy(server: Server, built: Any) -> None:
    answer = get(server, f"/{server.token}/")
    assert answer.status == 200
    assert answer.body.decode() == built.read_text()  # type: ignore[attr-defined]
    policy = answer.getheader("content-security-policy") or ""
    for rule in ("default-src 'none'", "frame-ancestors 'none'", f"connect-src 'self' ws://127.0.0.1:{server.port}"):
        assert rule in policy
    assert answer.getheader("x-content-type-options") == "nosniff"
    assert answer.getheader("referrer-policy") == "no-referrer"
    assert answer.getheader("cache-control") == "no-store"
    assert answer.getheader("cross-origin-opener-policy") == "same-origin"
    assert answer.getheader("cross-origin-resource-policy") == "same-origin"
    assert answer.getheader("server") is None
    assert server.address == f"http://127.0.0.1:{server.port}/{server.token}/"
    assert len(server.token) >= 32


def test_localhost_is_a_name_of_it(server: Server) -> None:
    assert get(server, f"/{server.token}/", host=f"localhost:{server.port}").status == 200
    with dial(server, "localhost") as page:
        assert until(page, type="scene")["title"] == "room"


def test_it_listens_on_this_machine_only(server: Server) -> None:
    assert server._socket.getsockname()[0] == "127.0.0.1"


PATHS = [
    "/", "//", "/{token}", "/{token}x/", "/x{token}/", "//{token}/", "/{token}//", "/./{token}/", "/{token}/.",
    "/{token}/..", "/{token}/../", "/{token}/%2e%2e/", "/{token}/..%2f..%2fetc%2fpasswd", "/{token}/%2e%2e%2f",
    "/{token}/..\\..\\", "/{token}/%252e%252e/", "/{token}%2f", "/%2f{token}/", "/{token}/index.html",
    "/{token}/socket", "/{token}/socket/", "/{token}/%73ocket", "/{token}/\u00e0", "/{token}/;/", "/favicon.ico",
    "/%00", "/{token}/%00", "/{other}/", "/{other}/socket", "http://evil.example/{token}/x",
]  # fmt: skip


@pytest.mark.parametrize("path", PATHS)
def test_there_is_nothing_else(server: Server, path: str) -> None:
    text = path.format(token=server.token, other=server.token[::-1])
    # http.client refuses what servers must bear, so this goes out by hand.
    with socket.create_connection(("127.0.0.1", server.port), timeout=PATIENCE) as raw:
        raw.sendall(
            f"GET {text} HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nConnection: close\r\n\r\n".encode("latin-1")
        )
        answer = b"".join(iter(lambda: raw.recv(4096), b""))
    assert int(answer.split()[1]) in (400, 404), answer
    assert server.token.encode() not in answer
    assert_answers(server)


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS", "TRACE", "BREW"])
def test_pages_are_only_got(server: Server, method: str) -> None:
    assert get(server, f"/{server.token}/", method).status == 405


HOSTS = ["evil.example", "evil.example:{port}", "127.0.0.1", "127.0.0.1:1", "localhost", "", None,
         "127.0.0.1:{port}.evil.example", "[::1]:{port}", "0.0.0.0:{port}"]  # fmt: skip


@pytest.mark.parametrize("host", HOSTS)
def test_a_foreign_host_is_refused(server: Server, host: str | None) -> None:
    name = None if host is None else host.format(port=server.port)
    assert get(server, f"/{server.token}/", host=name).status in (400, 421)
    assert knock(server, host=name, origin=f"http://{name}") in (400, 403)
    assert_answers(server)


def test_two_hosts_are_refused(server: Server) -> None:
    with socket.create_connection(("127.0.0.1", server.port), timeout=PATIENCE) as raw:
        hosts = f"Host: 127.0.0.1:{server.port}\r\nHost: evil.example\r\n"
        raw.sendall(f"GET /{server.token}/ HTTP/1.1\r\n{hosts}Connection: close\r\n\r\n".encode())
        answer = b"".join(iter(lambda: raw.recv(4096), b""))
    assert int(answer.split()[1]) in (400, 421)


ORIGINS = ["http://evil.example", "https://127.0.0.1:{port}", "http://127.0.0.1", "http://127.0.0.1:{other}", "null",
           "http://localhost:{port}", "http://127.0.0.1:{port}.evil.example", "file://"]  # fmt: skip


@pytest.mark.parametrize("origin", ORIGINS)
def test_a_foreign_origin_is_refused(server: Server, origin: str) -> None:
    said = origin.format(port=server.port, other=server.port ^ 1)
    assert get(server, f"/{server.token}/", origin=said).status == 403
    assert knock(server, origin=said) == 403
    assert_answers(server)


def test_a_socket_says_where_it_comes_from(server: Server) -> None:
    assert knock(server) == 403


@pytest.mark.parametrize("path", ["", "socket/", "../socket", "%73ocket", "socket/x"])
def test_sockets_are_in_one_place(server: Server, path: str) -> None:
    assert knock(server, path, origin=f"http://127.0.0.1:{server.port}") == 403


BAD = [
    ("", "no JSON"),
    ("{", "no JSON"),
    ("[" * 20000, "no JSON"),
    ("1" * 10000, "no JSON"),
    ("[]", "is a JSON object"),
    ("3", "is a JSON object"),
    ("{}", "no message of the type 'null'"),
    ('{"type": "scene"}', "no message of the type 'scene'; there are relight, stop"),
    ('{"type": ["stop"]}', "no message of the type"),
    ('{"type": "stop", "now": true}', "stop: there is no field 'now'"),
    ('{"type": "relight"}', "relight: reflectance is missing"),
    ('{"type": "relight", "reflectance": {}}', "relight: lamps is missing"),
    ('{"type": "relight", "reflectance": {}, "lamps": {}, "x": 1}', "there is no field 'x'"),
    ('{"type": "relight", "reflectance": [], "lamps": {}}', "reflectance: '[]' is not what belongs there"),
    ('{"type": "relight", "reflectance": {"0": 0.5}, "lamps": {}}', "reflectance '0': '0.5' is not what belongs"),
    ('{"type": "relight", "reflectance": {"0": [0.5, 0.5, NaN]}, "lamps": {}}', "NaN is no number"),
    ('{"type": "relight", "reflectance": {"0": [0.5, 0.5, 1e999]}, "lamps": {}}', "a number is too large"),
    ('{"type": "relight", "reflectance": {"0": [0.5, 0.5, ' + "9" * 400 + ']}, "lamps": {}}', "a number is too large"),
    ('{"type": "relight", "reflectance": {"0": [0.5, 0.5, true]}, "lamps": {}}', "'true' is not what belongs there"),
    ('{"type": "relight", "reflectance": {"0": [0.5, 0.5]}, "lamps": {}}', "give 3 values, one a band, not 2"),
    (
        '{"type": "relight", "reflectance": {"0": [0.5, 0.5, 1]}, "lamps": {}}',
        "reflectance 0: values go from 0 to 0.99",
    ),
    ('{"type": "relight", "reflectance": {"0": [-0.1, 0, 0]}, "lamps": {}}', "values go from 0"),
    ('{"type": "relight", "reflectance": {"10": [0, 0, 0]}, "lamps": {}}', "there is no '10'; there are 10, from 0 on"),
    ('{"type": "relight", "reflectance": {"-1": [0, 0, 0]}, "lamps": {}}', "there is no '-1'"),
    ('{"type": "relight", "reflectance": {"00": [0, 0, 0]}, "lamps": {}}', "there is no '00'"),
    ('{"type": "relight", "reflectance": {"\u0661": [0, 0, 0]}, "lamps": {}}', "there is no '\u0661'"),
    ('{"type": "relight", "reflectance": {}, "lamps": {"5": [0, 0, 0]}}', "lamps: there is no '5'; there are 5"),
    ('{"type": "relight", "reflectance": {}, "lamps": {"0": [0, 0, 1e7]}}', "lamps 0: values go from 0 to 1e+06"),
]


def test_bad_messages_are_answered(server: Server) -> None:
    with talking(server) as page:
        for text, why in BAD:
            page.send(text)
            assert why in until(page, type="failed")["message"]
    assert_answers(server)


def test_binary_messages_are_refused(server: Server) -> None:
    with talking(server) as page:
        page.send(b'{"type": "stop"}')
        assert until(page, type="failed")["message"] == "messages are text"
    assert_answers(server)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=9), inner, max_size=4),
    max_leaves=12,
)
RELIGHTS = st.fixed_dictionaries({"type": st.just("relight"), "reflectance": JSON, "lamps": JSON})


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(JSON.map(json.dumps) | RELIGHTS.map(json.dumps) | st.text(max_size=100))
def test_no_message_ends_the_conversation(server: Server, text: str) -> None:
    with talking(server) as page:
        page.send(text)
        page.send('{"type": "nothing"}')
        assert (
            "'nothing'"
            in until(page, message="there is no message of the type 'nothing'; there are relight, stop")["message"]
        )


def test_long_messages_end_it(server: Server) -> None:
    with talking(server) as page:
        page.send(" " * (MOST_BYTES - 20) + '{"type": "stop"}')
        page.send(" " * (MOST_BYTES + 1))
        with pytest.raises(ConnectionClosed) as closed:
            until(page, type="never")
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code == 1009
    assert_answers(server)


def test_who_hangs_up_is_missed_by_nobody(server: Server) -> None:
    for cut in (1, 5, 200):
        page = dial(server).__enter__()
        page.socket.sendall(b"\x81\xfe\x00\xff"[:cut] + b"x" * cut)
        page.socket.shutdown(socket.SHUT_RDWR)
        page.socket.close()
    # In the middle of the handshake, and of a request.
    for begun in (b"GET ", f"GET /{server.token}/socket HTTP/1.1\r\nUpgrade: websocket\r\n".encode(), os.urandom(300)):
        with socket.create_connection(("127.0.0.1", server.port)) as raw:
            raw.sendall(begun)
    assert_answers(server)


def test_a_flood_is_answered_by_the_last(server: Server) -> None:
    with talking(server) as page:
        for k in range(500):
            page.send(json.dumps({"type": "relight", "reflectance": {}, "lamps": {"0": [k / 500] * 3}}))
        answers = 0
        page.send('{"type": "over"}')
        while "over" not in until(page, type="failed")["message"]:
            answers += 1
    assert_answers(server)


def test_who_does_not_read_delays_nobody(server: Server) -> None:
    with dial(server) as deaf:
        for k in range(200):
            deaf.send(json.dumps({"type": "relight", "reflectance": {}, "lamps": {"0": [k / 500] * 3}}))
        assert_answers(server)


def test_many_pages_are_enough(server: Server) -> None:
    with ExitStack() as pages:
        for _ in range(MOST_PAGES):
            assert until(pages.enter_context(dial(server)), type="scene")["title"] == "room"
        assert knock(server, origin=f"http://127.0.0.1:{server.port}") == 403
    for _ in range(100):
        with socket.create_connection(("127.0.0.1", server.port)):
            pass
    assert_answers(server)


def test_a_port_may_be_chosen(server: Server, lit_room: radiosity.Solution) -> None:
    with pytest.raises(OSError, match="in use; choose another"):
        Server(Session(lit_room, Settings()), server.port)


def test_it_ends_with_pages_open(built: Any, lit_room: radiosity.Solution) -> None:
    with Server(Session(lit_room, Settings())) as server:
        page = dial(server).__enter__()
        until(page, type="scene")
    server._thread.join(PATIENCE)
    assert not server._thread.is_alive()
    with pytest.raises(ConnectionClosed):
        until(page, type="never")


def test_without_a_page_there_is_no_server(lit_room: radiosity.Solution, built: Any) -> None:
    built.unlink()
    with pytest.raises(MissingPageError):
        Server(Session(lit_room, Settings()))
