"""Who gets in: an ASGI middleware before every path of the window's server, HTTP and WebSocket.

A page elsewhere can make the user's browser ask this server for anything, and by DNS rebinding even read the answers as
its own. So each request must name a `Host` that is ours (a rebound name is not), an `Origin` that is that very host (a
page elsewhere cannot help sending its own), and a cookie, which a browser is given for the token of an opening address.
Each token works once.
"""

from __future__ import annotations

import hmac
import ipaddress
import re
import secrets
from collections.abc import Awaitable, Callable, Iterable, MutableMapping
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs, urlsplit

import attrs

__all__ = ["LONGEST_HEAD", "Door", "Guard"]

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

LONGEST_HEAD = 32 * 1024  # [bytes] of a request: a browser sends the cookies of all that is served on this host
LOOPBACK = ("127.0.0.1", "localhost", "::1")
HEADERS = (
    (b"x-content-type-options", b"nosniff"),
    (b"x-frame-options", b"DENY"),
    (b"referrer-policy", b"no-referrer"),
    (b"cross-origin-resource-policy", b"same-origin"),
    (b"cross-origin-opener-policy", b"same-origin"),
)
# Scripts and styles are files of ours, or have the answer's own nonce: no text becomes a script.
POLICY = (
    "default-src 'none'; script-src 'self'{0}; style-src 'self'{0}; img-src 'self' data: blob:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
OPEN = "Open the address that the terminal printed last; each works once."
# The cookie is `SameSite=Strict`: after a redirect from a page elsewhere (a terminal in the browser) it would not be
# sent. A page of our own that goes on by itself is of the same site.
WELCOME = (
    b'<!doctype html><html lang="en"><meta charset="utf-8"><meta http-equiv="refresh" content="0; url=/">'
    b'<link rel="icon" href="data:,"><title>amorsim</title>'
)


@attrs.frozen(kw_only=True)
class Door:
    """The credentials of a visitor: one of our names as host, and a token or the cookie given for it.

    `host` is what the server is bound to. A port in `Host` is not looked at, for a forwarded one differs; in `Origin`
    it must be that of `Host`.
    """

    host: str = "127.0.0.1"
    port: int
    cookie: str = attrs.field(factory=lambda: secrets.token_urlsafe(24), repr=False)
    _tokens: dict[str, Callable[[], None]] = attrs.field(factory=dict, init=False, repr=False)

    def new_address(self, used: Callable[[], None] = lambda: None) -> str:
        """A new address with a token that works once; `used` is called when it was used."""
        token = secrets.token_urlsafe(24)
        self._tokens[token] = used
        host = "127.0.0.1" if self._is_wildcard else self.host
        return f"http://{f'[{host}]' if ':' in host else host}:{self.port}/?token={token}"

    def knows_token(self, given: str) -> bool:
        """Whether a token opens the door, as one that has not been spent does."""
        return self._token(given) is not None

    def spend(self, given: str) -> bool:
        """Use up a token; returns whether it was valid."""
        token = self._token(given)
        used = None if token is None else self._tokens.pop(token, None)
        if used is None:
            return False
        used()
        return True

    def _token(self, given: str) -> str | None:
        # Each is compared in a time that does not depend on how much of it is right.
        found = [token for token in tuple(self._tokens) if hmac.compare_digest(given.encode(), token.encode())]
        return found[0] if found else None

    @property
    def is_for_this_machine(self) -> bool:
        """Whether only this machine can reach the server."""
        return self.host in LOOPBACK or (_is_address(self.host) and ipaddress.ip_address(self.host).is_loopback)

    @property
    def cookie_name(self) -> str:
        """Its port is in the name, for the ports of a host share their cookies."""
        return f"amorsim-{self.port}"

    @property
    def _is_wildcard(self) -> bool:
        return self.host in ("0.0.0.0", "::", "")

    def knows_host(self, host: str) -> bool:
        """Whether a `Host` header names this server; by DNS rebinding it would be another's name."""
        name = _host_name(host)
        if name is None:
            return False
        if name in LOOPBACK or name == self.host.lower():
            return True
        # Bound to all addresses: any of them may be meant, and a number cannot be rebound.
        return self._is_wildcard and _is_address(name)


def _head_size(scope: Scope) -> int:
    """How long the head of a request was [bytes], but for the words that every request has."""
    lines = sum(len(name) + len(value) + len(b": \r\n") for name, value in scope["headers"])
    return len(scope.get("raw_path") or b"") + len(scope.get("query_string", b"")) + lines


class Guard:
    """The middleware: passes on what the door allows, and refuses the rest with one line of text."""

    def __init__(self, app: App, door: Door) -> None:
        self.app = app
        self.door = door

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a request through, or refuse it."""
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        if _head_size(scope) > LONGEST_HEAD:  # the library looks only at one that comes in parts
            await _refuse(scope, send, 431, f"The request's head is longer than {LONGEST_HEAD} bytes.")
            return
        headers = _Headers(scope)
        token = self._token_in(scope, headers)
        if problem := self._stranger(scope, headers, token):
            await _refuse(scope, send, 403, problem)
            return
        if not self._has_cookie(headers):
            if self.door.spend(token):
                await self._welcome(send)
            else:
                await _refuse(scope, send, 401, OPEN)
            return
        # What is not found is written into the log with its address.
        if b"token=" in scope.get("query_string", b""):
            scope["query_string"] = b""
        nonce = scope["nonce"] = secrets.token_urlsafe(16)
        await self.app(scope, receive, send if scope["type"] == "websocket" else _with_headers(send, nonce))

    def _stranger(self, scope: Scope, headers: _Headers, token: str) -> str:
        """Why this request is not from a page of this server; empty if it is."""
        host = headers.one("host")
        if host is None or not self.door.knows_host(host):
            return "This host is not ours."
        origins = headers.all("origin")
        is_page = scope["type"] == "http" and scope["method"] in ("GET", "HEAD")
        if not origins and not is_page:
            return "An origin is wanted."
        if any(not _same(origin, host) for origin in origins):
            return "This origin is not ours."
        site = headers.one("sec-fetch-site")
        # Another port of this host is of the same site, and gets the cookie: not asked for, not let in.
        if site in ("cross-site", "same-site") and not self.door.knows_token(token):
            return f"A page elsewhere asked for this. {OPEN}"
        return ""

    @staticmethod
    def _token_in(scope: Scope, headers: _Headers) -> str:
        """The token in a request to open the page; empty if there is none."""
        if scope["type"] != "http" or scope["method"] != "GET" or scope["path"] != "/":
            return ""
        if headers.one("sec-fetch-dest") not in (None, "document"):
            return ""
        given = parse_qs(scope.get("query_string", b"").decode("latin-1")).get("token", [])
        return given[0] if len(given) == 1 else ""

    def _has_cookie(self, headers: _Headers) -> bool:
        for header in headers.all("cookie"):
            try:
                jar = SimpleCookie(header)
            except CookieError:
                continue
            if self.door.cookie_name in jar:
                given = jar[self.door.cookie_name].value
                return hmac.compare_digest(given.encode(), self.door.cookie.encode())
        return False

    async def _welcome(self, send: Send) -> None:
        cookie = f"{self.door.cookie_name}={self.door.cookie}; Path=/; HttpOnly; SameSite=Strict"
        headers = [
            (b"content-type", b"text/html; charset=utf-8"),
            (b"content-length", str(len(WELCOME)).encode()),
            (b"cache-control", b"no-store"),
            (b"set-cookie", cookie.encode()),
        ]
        await _with_headers(send)({"type": "http.response.start", "status": 200, "headers": headers})
        await send({"type": "http.response.body", "body": WELCOME})


class _Headers:
    def __init__(self, scope: Scope) -> None:
        self._pairs: Iterable[tuple[bytes, bytes]] = list(scope.get("headers", ()))

    def all(self, name: str) -> list[str]:
        wanted = name.encode()
        return [value.decode("latin-1") for key, value in self._pairs if key.lower() == wanted]

    def one(self, name: str) -> str | None:
        """The header's value; None if it is missing, or repeated, which no browser does."""
        found = self.all(name)
        return found[0] if len(found) == 1 else None


def _host_name(host: str) -> str | None:
    """The name in a `Host` header, lower case, without its port and brackets; None if malformed."""
    match = re.fullmatch(r"(\[[0-9a-fA-F:.]+\]|[A-Za-z0-9._-]+)(:\d{1,5})?", host)
    return None if match is None else match.group(1).strip("[]").lower()


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def _same(origin: str, host: str) -> bool:
    """Whether an `Origin` is `http(s)://<host>`, port included."""
    try:
        parts = urlsplit(origin)
    except ValueError:
        return False
    is_origin = parts.scheme in ("http", "https") and origin == f"{parts.scheme}://{parts.netloc}"
    return is_origin and parts.netloc.lower() == host.lower()


def _with_headers(send: Send, nonce: str = "") -> Send:
    """Answers have our headers; in them scripts and styles with the nonce are allowed."""
    own = f" 'nonce-{nonce}'" if nonce else ""
    headers = (*HEADERS, (b"content-security-policy", POLICY.format(own).encode()))

    async def guarded(message: MutableMapping[str, Any]) -> None:
        if message["type"] == "http.response.start":
            ours = {name for name, _ in headers}
            kept = [(key, value) for key, value in message.get("headers", ()) if key.lower() not in ours]
            message = {**message, "headers": [*kept, *headers]}
        await send(message)

    return guarded


async def _refuse(scope: Scope, send: Send, status: int, problem: str) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1008, "reason": problem})
        return
    body = problem.encode() + b"\n"
    headers = [
        (b"content-type", b"text/plain; charset=utf-8"),
        (b"content-length", str(len(body)).encode()),
        (b"cache-control", b"no-store"),
        (b"connection", b"close"),  # what more it would send is not waited for
    ]
    await _with_headers(send)({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": body})
