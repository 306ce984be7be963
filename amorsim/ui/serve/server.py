"""The window's server: pages, the scripts that they ask for later, and one WebSocket a window, all behind the guard."""

from __future__ import annotations

import asyncio
import errno
import socket
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect, Request
from starlette.responses import HTMLResponse, PlainTextResponse, RedirectResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket
from uvicorn.protocols.http.h11_impl import H11Protocol

from amorsim.core.errors import AmorsimError
from amorsim.ui.serve.connection_limiter import ConnectionLimiter
from amorsim.ui.serve.gif import FilmError, gif_of, read_film
from amorsim.ui.serve.html_page import document
from amorsim.ui.serve.pages import KINDS, WEB, Pages
from amorsim.ui.serve.security import LONGEST_HEAD, App, Door, Guard
from amorsim.ui.serve.talk import Talk
from amorsim.ui.serve.wire import LONGEST_MESSAGE

__all__ = ["build", "listen", "serve"]

_NOT_OURS = (errno.EADDRNOTAVAIL, errno.EAFNOSUPPORT)  # of a socket's address: that of another machine

LONGEST_UPLOAD = 60.0  # [s] of a film's pictures
MOST_WINDOWS = 32
FRESH = {"cache-control": "no-cache"}  # a browser asks whether it is new, so that an update is seen at once


def build(pages: Pages, door: Door, started: Callable[[], None] = lambda: None) -> App:
    """The application for some pages; `started` is called as soon as it answers."""

    @asynccontextmanager
    async def lifespan(_: Starlette) -> AsyncIterator[None]:
        started()
        yield

    async def show_first(_: Request) -> Response:
        if pages.first is None:
            return PlainTextResponse("there is nothing to show", status_code=404)
        return RedirectResponse(pages.first.path, headers={"cache-control": "no-store"})

    async def show_kind(request: Request) -> Response:
        page = next((page for page in pages if page.kind == request.path_params["kind"]), None)
        if page is None:
            return PlainTextResponse("there is no such page", status_code=404)
        return RedirectResponse(page.path, headers={"cache-control": "no-store"})

    def show(request: Request) -> Response:
        page = pages.find(**request.path_params)
        if page is None:
            return PlainTextResponse("there is no such page", status_code=404)
        start, styles = KINDS[page.kind]
        return HTMLResponse(document(start, styles, request.scope["nonce"]), headers={"cache-control": "no-store"})

    routes = [
        Route("/", show_first),
        Route("/{kind}", show_kind),
        Route("/{kind}/{name}", show),
        WebSocketRoute("/amorsim/socket/{kind}/{name}", _connecting(pages)),
        Route("/amorsim/gif", _making_gifs(), methods=["POST"]),
        Mount("/amorsim/web", _Scripts(directory=WEB)),
    ]
    return Guard(Starlette(routes=routes, lifespan=lifespan), door)


def _connecting(pages: Pages) -> Callable[[WebSocket], Awaitable[None]]:
    """Lets windows talk with their page's session, a limited number at a time."""
    windows: set[Talk] = set()

    async def connect(websocket: WebSocket) -> None:
        page = pages.find(**websocket.path_params)
        if page is None:
            await websocket.close(1008, "There is no such page.")
            return
        if len(windows) >= MOST_WINDOWS:
            await websocket.close(1013, "There are too many windows.")
            return
        talk = Talk(websocket, page.session)
        windows.add(talk)
        try:
            await talk.run()
        finally:
            windows.discard(talk)

    return connect


def _making_gifs() -> Callable[[Request], Awaitable[Response]]:
    """Makes GIFs of films, one at a time: one takes memory enough."""
    making = asyncio.Lock()

    async def make_gif(request: Request) -> Response:
        if making.locked():
            return PlainTextResponse("another GIF is being made; try again when it is done", status_code=429)
        async with making:
            try:
                async with asyncio.timeout(LONGEST_UPLOAD):
                    film = await read_film(request.stream(), request.query_params.get("every", ""))
                made = await run_in_threadpool(gif_of, film)
            except TimeoutError:
                return PlainTextResponse(f"the film did not come within {LONGEST_UPLOAD:g} s", status_code=408)
            except FilmError as error:
                return PlainTextResponse(str(error), status_code=400)
            except ClientDisconnect:
                return Response(status_code=400)  # which nobody reads
        return Response(made, media_type="image/gif")

    return make_gif


class _Scripts(StaticFiles):
    """Our scripts and sheets."""

    def file_response(self, *args: Any, **options: Any) -> Response:
        response = super().file_response(*args, **options)
        response.headers.update(FRESH)
        return response


def listen(host: str, port: int) -> socket.socket:
    """A socket that listens; `port` 0 takes any that is free.

    Raises
    ------
    AmorsimError
        If the address is taken or not this machine's.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    # By the name of its protocol asyncio knows that it may send at once; without it, an answer's end waits 40 ms.
    bound = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        bound.bind((host, port))
        bound.listen()  # who asks as soon as the address is printed waits, and is not refused
    except (OSError, OverflowError, UnicodeError) as error:
        bound.close()
        reason = getattr(error, "strerror", None) or str(error)
        is_unknown = isinstance(error, (socket.gaierror, UnicodeError))
        is_host = is_unknown or getattr(error, "errno", None) in _NOT_OURS
        other = "--host, such as 127.0.0.1" if is_host else "--port"
        raise AmorsimError(f"cannot listen on {host}, port {port}: {reason}; choose another with {other}") from None
    return bound


class _Server(uvicorn.Server):
    """A server that stops at once on a signal, or when it is told to, and does not wait for its windows."""

    def __init__(
        self, config: uvicorn.Config, ending: Callable[[], Awaitable[None]], closing: asyncio.Event | None
    ) -> None:
        super().__init__(config)
        self._ending, self._closing = ending, closing

    async def on_tick(self, counter: int) -> bool:
        return await super().on_tick(counter) or (self._closing is not None and self._closing.is_set())

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        ending = asyncio.ensure_future(self._ending())
        await super().shutdown(sockets)
        await ending


async def _nothing() -> None:
    pass


async def serve(
    pages: Pages,
    *,
    host: str = "127.0.0.1",
    port: int = 0,
    ready: Callable[[Door], None],
    ending: Callable[[], Awaitable[None]] = _nothing,
    closing: asyncio.Event | None = None,
    longest_message: int = LONGEST_MESSAGE,
) -> None:
    """Serve pages until the process is asked to end, or `closing` is set.

    `ready` is given the door, which makes addresses to open the window by; `ending` is awaited as soon as the process
    is asked to. A window's message has `longest_message` bytes at most.
    """
    with listen(host, port) as bound:
        door = Door(host=host, port=bound.getsockname()[1])
        app = build(pages, door, lambda: ready(door))
        config = uvicorn.Config(
            app,
            http=ConnectionLimiter(H11Protocol).receive,  # type: ignore[arg-type] # what makes a protocol, as a class does
            h11_max_incomplete_event_size=LONGEST_HEAD,
            log_level="error",  # what a stranger asks for is not for the terminal
            access_log=False,
            server_header=False,
            timeout_graceful_shutdown=1,
            ws_max_size=longest_message,
            ws_per_message_deflate=False,  # frames are floats: it would cost more than it saves
        )
        await _Server(config, ending, closing).serve(sockets=[bound])
