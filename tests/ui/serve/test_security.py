"""Nobody else gets in: every path of a real server, asked by raw HTTP and WebSocket."""

from __future__ import annotations

import asyncio
import base64
import contextlib
import json
import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple
from urllib.parse import urlsplit

import pytest

pytest.importorskip("starlette", reason="the extra 'ui' is not installed")

from amorsim.core.errors import AmorsimError
from amorsim.ui.serve.connection_limiter import MOST_WAITING
from amorsim.ui.serve.security import Door, Guard
from amorsim.ui.serve.server import listen
from tests.ui.aside import aside

PATHS = ["/run/one", "/run/two", "/amorsim/web/simulator/simulator.js", "/", "/favicon.ico", "/nothing"]
SOCKETS = ["/amorsim/socket/run/one", "/amorsim/socket/run/two"]


class Answer(NamedTuple):
    status: int
    headers: dict[str, str]
    body: bytes


class Server(NamedTuple):
    host: str
    port: int
    new_token: Callable[[], str]
    cookie: str = ""

    @property
    def own(self) -> str:
        return f"{self.host}:{self.port}"

    def ask(self, path: str, method: str = "GET", /, **headers: str) -> Answer:
        """A request as raw bytes, for clients tidy up paths; `Host` is ours unless given, the cookie comes if known."""
        given = {"Host": self.own, "Connection": "close"} | ({"Cookie": self.cookie} if self.cookie else {})
        given |= {name.replace("_", "-"): value for name, value in headers.items()}
        lines = [f"{method} {path} HTTP/1.1", *(f"{name}: {value}" for name, value in given.items() if value)]
        with socket.create_connection((self.host, self.port), timeout=10) as line:
            line.sendall("\r\n".join([*lines, "", ""]).encode("latin-1"))
            data = b""
            while b"\r\n\r\n" not in data or "Upgrade" not in given:
                part = line.recv(65536)
                if not part:
                    break
                data += part
        head, _, body = data.partition(b"\r\n\r\n")
        first, *rest = head.decode("latin-1").split("\r\n")
        return Answer(
            int(first.split()[1]), {k.lower(): v.strip() for k, _, v in (r.partition(":") for r in rest)}, body
        )

    def shake(self, path: str, **headers: str) -> int:
        """The status of a WebSocket's handshake: 101 where it is let in."""
        key = base64.b64encode(os.urandom(16)).decode()
        wanted = {
            "Upgrade": "websocket",
            "Connection": "Upgrade",
            "Sec_WebSocket_Key": key,
            "Sec_WebSocket_Version": "13",
        }
        return self.ask(path, **(wanted | {"Origin": f"http://{self.own}"} | headers)).status


@pytest.fixture(scope="module")
def stranger() -> Iterator[Server]:
    """The server as one without a cookie meets it."""
    command = [sys.executable, "-m", "tests.ui.stub"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        said, asked = process.stdout, process.stdin
        assert said is not None
        assert asked is not None
        parts = urlsplit(said.readline().strip())
        assert parts.hostname is not None
        assert parts.port is not None

        def new_token() -> str:
            asked.write("\n")
            asked.flush()
            return urlsplit(said.readline().strip()).query.removeprefix("token=")

        yield Server(parts.hostname, parts.port, new_token)
        process.kill()


@pytest.fixture(scope="module")
def user(stranger: Server) -> Server:
    """The server as one who opened the address meets it."""
    given = stranger.ask(f"/?token={stranger.new_token()}").headers["set-cookie"]
    return stranger._replace(cookie=given.split(";")[0])


def test_the_address_gives_a_cookie_that_scripts_and_other_sites_never_get(stranger: Server) -> None:
    token = stranger.new_token()
    answer = stranger.ask(f"/?token={token}")
    assert answer.status == 200
    name, *flags = answer.headers["set-cookie"].split("; ")
    assert set(flags) == {"Path=/", "HttpOnly", "SameSite=Strict"}
    assert token not in name  # who sees the cookie cannot open another window
    assert answer.headers["cache-control"] == "no-store"
    assert answer.headers["referrer-policy"] == "no-referrer"


@pytest.mark.parametrize("token", ["", "?token=", "?token=wrong", "?token=TOKEN&token=TOKEN", "?token=TOKENx"])
def test_a_missing_or_false_token_gives_nothing(stranger: Server, token: str) -> None:
    answer = stranger.ask("/" + token.replace("TOKEN", stranger.new_token()))
    assert answer.status == 401
    assert "set-cookie" not in answer.headers


def test_the_token_opens_the_page_alone(stranger: Server) -> None:
    token = stranger.new_token()
    assert stranger.ask(f"/amorsim/web/simulator/simulator.js?token={token}").status == 401
    assert stranger.ask(f"/?token={token}", "POST", Origin=f"http://{stranger.own}").status == 401
    # Not as a picture or a script in a page elsewhere, either.
    assert stranger.ask(f"/?token={token}", Sec_Fetch_Dest="image", Sec_Fetch_Site="cross-site").status == 403
    assert stranger.ask(f"/?token={token}", Sec_Fetch_Dest="document", Sec_Fetch_Site="cross-site").status == 200


def test_a_token_works_once(stranger: Server, user: Server) -> None:
    token = stranger.new_token()
    assert user.ask(f"/?token={token}").status == 307  # who is in already does not spend it
    assert stranger.ask(f"/?token={token}").status == 200
    again = stranger.ask(f"/?token={token}")
    assert again.status == 401
    assert "set-cookie" not in again.headers
    assert b"each works once" in again.body
    # A link in a page, where it was used already.
    assert stranger.ask(f"/?token={token}", Sec_Fetch_Dest="document", Sec_Fetch_Site="cross-site").status == 403
    assert user.ask(f"/?token={token}").status == 307  # the page is loaded again


@pytest.mark.parametrize("path", PATHS)
def test_without_the_cookie_no_path_answers(stranger: Server, path: str) -> None:
    assert stranger.ask(path).status == 401
    assert stranger.ask(path, Cookie=f"amorsim-{stranger.port}=guessed").status == 401


@pytest.mark.parametrize("path", PATHS[:3])
def test_with_the_cookie_they_do(user: Server, path: str) -> None:
    answer = user.ask(path)
    assert answer.status == 200
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert "frame-ancestors 'none'" in answer.headers["content-security-policy"]


@pytest.mark.parametrize("path", PATHS)
def test_a_foreign_host_is_refused_on_every_path(user: Server, path: str) -> None:
    for host in (
        "evil.example",
        f"evil.example:{user.port}",
        "127.0.0.1.evil.example",
        "192.168.1.7",
        "localhost.evil",
        "",
    ):
        assert user.ask(path, Host=host).status in (400, 403)
    # Nor does the token help a name that was rebound to this machine.
    assert user.ask(f"/?token={user.new_token()}", Host=f"evil.example:{user.port}").status == 403


@pytest.mark.parametrize("path", PATHS)
def test_a_foreign_origin_is_refused_on_every_path(user: Server, path: str) -> None:
    for origin in (
        "http://evil.example",
        "null",
        f"http://localhost:{user.port}",
        f"http://{user.host}:{user.port + 1}",
    ):
        assert user.ask(path, Origin=origin).status == 403
    # Another port of this machine is of the same site, and sends the cookie even where it sends no origin.
    assert user.ask(path, Sec_Fetch_Site="same-site").status == 403
    assert user.ask(path, Sec_Fetch_Site="cross-site").status == 403


@pytest.mark.parametrize("path", SOCKETS)
def test_sockets_want_origin_host_and_cookie(stranger: Server, user: Server, path: str) -> None:
    assert user.shake(path) == 101
    assert stranger.shake(path) == 403
    assert user.shake(path, Origin="http://evil.example") == 403
    assert user.shake(path, Origin=f"http://{user.host}:{user.port + 1}") == 403
    assert user.shake(path, Origin="") == 403
    assert user.shake(path, Host="evil.example", Origin="http://evil.example") == 403


def test_pages_are_found_by_their_names_and_the_first_where_none_is_named(user: Server) -> None:
    first = user.ask("/")
    assert (first.status, first.headers["location"]) == (307, "/run/one")
    for path in ("/run", "/run/", "/run/three", "/edit/one", "/amorsim/web", "/run/one/", "/run/..%2Fone"):
        assert user.ask(path).status in (307, 404), path
    for path in ("/amorsim/socket", "/amorsim/socket/run/three", "/amorsim/socket/edit/one"):
        assert user.shake(path) == 403


def test_each_page_talks_with_its_own_session(user: Server) -> None:
    from websockets.sync.client import connect

    def talk(name: str) -> Any:
        address = f"ws://{user.own}/amorsim/socket/run/{name}"
        return connect(address, additional_headers={"Cookie": user.cookie}, origin=f"http://{user.own}")  # type: ignore[arg-type]

    def window(socket: Any) -> str:
        return str(json.loads(socket.recv(30.0))["window"])

    with talk("one") as first, talk("one") as second, talk("two") as other:
        assert [window(socket) for socket in (first, second, other)] == ["window-1", "window-2", "window-1"]
        other.send(json.dumps({"id": 5, "do": "state"}))
        while isinstance(said := other.recv(30.0), bytes):  # a frame
            pass
        assert json.loads(said) == {"answer": 5, "said": {"ok": True, "window": "window-1", "said": "state"}}


def test_what_changes_things_wants_an_origin(user: Server) -> None:
    assert user.ask("/amorsim/gif", "POST", Content_Length="0").status == 403
    assert user.ask("/amorsim/gif?every=100", "POST", Content_Length="0", Origin=f"http://{user.own}").status == 400
    assert user.ask("/nothing", "POST", Content_Length="0").status == 403


@pytest.mark.parametrize(
    "path",
    ["../security.py", "..%2fsecurity.py", "%2e%2e/security.py", "....//security.py", "/etc/passwd", "%2fetc%2fpasswd"],
)
def test_no_path_leads_out_of_the_scripts_folder(user: Server, path: str) -> None:
    answer = user.ask("/amorsim/web/" + path)
    assert answer.status in (400, 403, 404)
    assert b"Guard" not in answer.body
    assert b"root:" not in answer.body


def test_the_policy_allows_scripts_and_styles_from_files_of_ours_or_with_a_nonce_of_the_answer_alone(
    stranger: Server, user: Server
) -> None:
    nonces: set[str] = set()
    for answer in (user.ask("/run/one"), user.ask("/run/one"), user.ask("/nothing"), stranger.ask("/")):
        parts = answer.headers["content-security-policy"].split("; ")
        policy = {name: sources for name, _, sources in (part.partition(" ") for part in parts)}
        assert policy["default-src"] == "'none'"
        assert policy["connect-src"] == "'self'"
        assert policy["script-src"] == policy["style-src"]
        own, _, nonce = policy["script-src"].partition(" ")
        assert own == "'self'"
        if nonce:
            value = nonce.removeprefix("'nonce-").removesuffix("'")
            assert len(value) >= 16
            assert value not in nonces
            nonces.add(value)
            assert answer.body.count(f'nonce="{value}"'.encode()) == (3 if answer.status == 200 else 0)
        assert "unsafe" not in answer.headers["content-security-policy"]
        assert policy["frame-ancestors"] == policy["base-uri"] == policy["form-action"] == "'none'"
    assert len(nonces) == 3  # not of what strangers get


# ---------------------------------------------------------------------------------------------------- before the door


def connections_of(server: Server, head: bytes, count: int) -> list[socket.socket]:
    lines = [socket.create_connection((server.host, server.port), timeout=30.0) for _ in range(count)]
    for line in lines:
        line.sendall(head)
    return lines


def is_open(line: socket.socket) -> bool:
    line.setblocking(False)
    try:
        return line.recv(1) != b""
    except BlockingIOError:
        return True
    except OSError:
        return False


def test_headers_without_end_are_cut_off(stranger: Server) -> None:
    sent = 0
    with socket.create_connection((stranger.host, stranger.port), timeout=30.0) as line:
        line.sendall(b"GET / HTTP/1.1\r\n")
        with contextlib.suppress(OSError):  # it is closed
            while sent < 64 * 2**20:
                sent += line.send(b"x-more: " + b"m" * 8000 + b"\r\n")
    # What the sockets' buffers hold is sent without being read.
    assert sent < 16 * 2**20


@pytest.mark.parametrize("size", [33, 70, 200])
def test_a_head_that_is_too_long_is_not_served_even_if_it_comes_at_once(user: Server, size: int) -> None:
    def is_served(path: str, **headers: str) -> bool:
        try:
            status = user.ask(path, **headers).status
        except ConnectionError:  # closed before all of it was read
            return False
        assert status in (200, 400, 431)
        return status == 200

    long = "m" * size * 1024
    assert is_served("/run/one", X_More="m" * 20_000)
    assert not is_served("/run/one", X_More=long)
    assert not is_served(f"/run/one?{long}")
    assert not is_served("/run/one", **{f"X-{number}": "m" * 1000 for number in range(size)})


def test_one_gif_at_a_time_and_no_odd_request_is_a_failure(user: Server) -> None:
    ours = {"Origin": f"http://{user.own}"}
    for every in ("", "x", "-1", "9" * 6000, "%FF", "1e3", "100&every=x"):
        assert user.ask(f"/amorsim/gif?every={every}", "POST", Content_Length="0", **ours).status == 400
    head = f"POST /amorsim/gif?every=100 HTTP/1.1\r\nHost: {user.own}\r\nOrigin: http://{user.own}\r\n"
    with socket.create_connection((user.host, user.port), timeout=30.0) as line:
        line.sendall(f"{head}Cookie: {user.cookie}\r\nContent-Length: 9\r\n\r\n1234".encode())
        end = time.monotonic() + 30.0
        while user.ask("/amorsim/gif?every=100", "POST", Content_Length="0", **ours).status != 429:
            assert time.monotonic() < end
    # Who goes in the middle of it leaves the place to others.
    while user.ask("/amorsim/gif?every=100", "POST", Content_Length="0", **ours).status != 400:
        assert time.monotonic() < end


def test_half_open_connections_are_not_kept(stranger: Server, user: Server) -> None:
    lines = connections_of(stranger, b"GET / HTTP/1.1\r\n", 300)
    try:
        assert user.ask("/amorsim/web/simulator/simulator.js").status == 200
        assert sum(is_open(line) for line in lines) <= MOST_WAITING
    finally:
        for line in lines:
            line.close()


@pytest.mark.parametrize("more", ["", "Content-Length: 1000000000\r\n", "Transfer-Encoding: chunked\r\n"])
def test_a_refused_connection_is_closed(stranger: Server, more: str) -> None:
    with socket.create_connection((stranger.host, stranger.port), timeout=30.0) as line:
        line.sendall(f"GET / HTTP/1.1\r\nHost: {stranger.own}\r\n{more}\r\n".encode())
        data = b""
        while part := line.recv(65536):  # to its end, which does not wait for what was announced
            data += part
        assert data.startswith(b"HTTP/1.1 401 ")
    key = "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: " + "A" * 22
    with socket.create_connection((stranger.host, stranger.port), timeout=30.0) as line:
        line.sendall(f"GET /amorsim/socket/run/one HTTP/1.1\r\nHost: {stranger.own}\r\n{key}==\r\n\r\n".encode())
        while line.recv(65536):
            pass


# ------------------------------------------------------------------------------------------------- the door, alone


def status_of(door: Door, headers: list[tuple[str, str]], **scope: Any) -> int:
    """What the guard says to a request; 200 where it lets it through."""

    async def inner(scope: Any, receive: Any, send: Any) -> None:
        await send({"type": "http.response.start", "status": 200, "headers": []})

    said: list[Any] = []

    async def send(message: Any) -> None:
        said.append(message)

    whole = {"type": "http", "method": "GET", "path": "/x", "query_string": b""} | scope
    whole["headers"] = [(name.encode(), value.encode()) for name, value in headers]
    aside(Guard(inner, door)(whole, None, send))  # type: ignore[arg-type]
    return int(said[0]["status"])


@pytest.mark.parametrize(
    ("bound", "host", "status"),
    [
        ("127.0.0.1", "127.0.0.1:8000", 200),
        ("127.0.0.1", "localhost:9999", 200),  # a port forwarded to ours
        ("127.0.0.1", "LOCALHOST", 200),
        ("127.0.0.1", "[::1]:8000", 200),
        ("127.0.0.1", "10.0.0.5:8000", 403),
        ("127.0.0.1", "user@localhost", 403),
        ("127.0.0.1", "localhost:8000:1", 403),
        ("127.0.0.1", "localhost, evil.example", 403),
        ("lab.example", "lab.example:8000", 200),
        ("lab.example", "other.example:8000", 403),
        ("0.0.0.0", "10.0.0.5:8000", 200),  # a number cannot be rebound
        ("0.0.0.0", "[fe80::1]:8000", 200),
        ("0.0.0.0", "evil.example:8000", 403),
    ],
)
def test_which_names_are_ours(bound: str, host: str, status: int) -> None:
    door = Door(host=bound, port=8000)
    cookie = ("cookie", f"amorsim-8000={door.cookie}")
    assert status_of(door, [("host", host), cookie]) == status
    assert status_of(door, [("host", host), ("origin", f"http://{host}"), cookie]) == status


def test_two_hosts_or_two_origins_are_refused() -> None:
    door = Door(port=8000)
    ours, cookie = ("host", "localhost:8000"), ("cookie", f"a=b; amorsim-8000={door.cookie}")
    origin = ("origin", "http://localhost:8000")
    assert status_of(door, [ours, origin, cookie]) == 200
    assert status_of(door, [ours, ours, cookie]) == 403
    assert status_of(door, [ours, origin, ("origin", "http://evil.example"), cookie]) == 403
    assert status_of(door, [cookie]) == 403


def test_doors_differ_and_do_not_show_their_secrets() -> None:
    one, other = Door(port=1), Door(port=1)
    tokens = [door.new_address().partition("token=")[2] for door in (one, one, other)]
    assert len({*tokens, one.cookie, other.cookie}) == 5
    assert tokens[0] not in repr(one)
    assert one.cookie not in repr(one)
    assert Door(host="0.0.0.0", port=80).new_address().startswith("http://127.0.0.1:80/?token=")
    assert Door(host="::1", port=80).new_address().startswith("http://[::1]:80/?token=")


def test_each_token_is_spent_by_itself_and_tells() -> None:
    door, used = Door(port=80), []
    first, second = (
        door.new_address(lambda name=name: used.append(name)).partition("token=")[2]  # type: ignore[misc]
        for name in "ab"
    )
    assert not door.spend("")
    assert not door.spend(first + "x")
    assert used == []
    assert door.spend(second)
    assert not door.spend(second)
    assert used == ["b"]
    assert door.knows_token(first)
    assert not door.knows_token(second)


@pytest.mark.parametrize(
    ("host", "is_ours"),
    [
        ("127.0.0.1", True),
        ("127.0.0.7", True),
        ("localhost", True),
        ("::1", True),
        ("0.0.0.0", False),
        ("::", False),
        ("10.0.0.5", False),
        ("lab.example", False),
        ("", False),
    ],
)
def test_which_addresses_are_for_this_machine_alone(host: str, is_ours: bool) -> None:
    assert Door(host=host, port=80).is_for_this_machine == is_ours


def test_a_taken_port_is_an_error_of_ours() -> None:
    with listen("127.0.0.1", 0) as first:
        port = first.getsockname()[1]
        with pytest.raises(AmorsimError, match=f"port {port}.*--port"):
            listen("127.0.0.1", port)


def test_an_answer_is_sent_at_once_and_does_not_wait_for_the_visitor_to_confirm_a_part() -> None:
    async def options() -> list[int]:
        found: list[int] = []

        def visited(_: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            found.append(writer.get_extra_info("socket").getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY))
            writer.close()

        async with await asyncio.start_server(visited, sock=listen("127.0.0.1", 0)) as server:
            reader, writer = await asyncio.open_connection(*server.sockets[0].getsockname())
            await reader.read()
            writer.close()
        return found

    assert asyncio.run(options()) == [1]


@pytest.mark.parametrize("host", ["no.such.host.invalid", "300.1.1.1", "192.0.2.1", "::ffff:192.0.2.1", "a b"])
def test_a_host_that_is_not_this_machines_is_an_error_that_names_host(host: str) -> None:
    with pytest.raises(
        AmorsimError, match=r"cannot listen on .*; choose another with --host, such as 127.0.0.1"
    ) as caught:
        listen(host, 0)
    assert "--port" not in str(caught.value)


def test_a_token_in_an_address_that_is_not_found_goes_into_no_log() -> None:
    seen: list[dict[str, Any]] = []

    async def app(scope: Any, receive: Any, send: Any) -> None:
        seen.append(dict(scope))

    async def nothing(*_: Any) -> None:
        raise AssertionError("refused")

    door = Door(port=80)
    cookie = f"{door.cookie_name}={door.cookie}".encode()
    token = door.new_address().partition("token=")[2]
    for query in (f"token={token}", f"x=1&token={token}", "every=100"):
        scope = {
            "type": "http",
            "method": "GET",
            "path": "/nothing",
            "query_string": query.encode(),
            "headers": [(b"host", b"127.0.0.1:80"), (b"cookie", cookie)],
        }
        aside(Guard(app, door)(scope, nothing, nothing))
    assert [scope["query_string"] for scope in seen] == [b"", b"", b"every=100"]
