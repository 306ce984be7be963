"""The window's server: a page, its scripts, and one WebSocket a window, all behind the guard."""

from __future__ import annotations

import asyncio
import socket
import threading
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from types import FrameType
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket
from uvicorn.protocols.http.h11_impl import H11Protocol

from amorsim.core.errors import AmorsimError
from amorsim.ui.serve.film import FilmError, gif_of, read_film
from amorsim.ui.serve.lobby import Lobby
from amorsim.ui.serve.security import App, Door, Guard
from amorsim.ui.serve.talk import Simulated, Talk
from amorsim.ui.simulator.messages import LONGEST_MESSAGE

__all__ = ["build", "listen", "serve"]

LONGEST_HEAD = 32 * 1024  # [bytes] of a request: a browser sends the cookies of all that is served on this host
LONGEST_UPLOAD = 60.0  # [s] of a film's pictures
MOST_WINDOWS = 32
WEB = Path(__file__).parent.parent / "web"


def build(session: Simulated, door: Door, started: Callable[[], None] = lambda: None) -> App:
    """The whole application for a session; `started` is called once it can be asked."""

    @asynccontextmanager
    async def lifespan(_: Starlette) -> AsyncIterator[None]:
        started()
        yield

    windows: set[Talk] = set()

    async def connect(websocket: WebSocket) -> None:
        if len(windows) >= MOST_WINDOWS:
            await websocket.close(1013, "There are too many windows.")
            return
        talk = Talk(websocket, session)
        windows.add(talk)
        try:
            await talk.run()
        finally:
            windows.discard(talk)

    making = asyncio.Lock()

    async def make_gif(request: Request) -> Response:
        if making.locked():  # one takes memory enough
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

    async def show_page(_: Request) -> Response:
        return FileResponse(WEB / "simulator" / "page.html", headers={"cache-control": "no-cache"})

    routes = [
        Route("/", show_page),
        WebSocketRoute("/amorsim/socket", connect),
        Route("/amorsim/gif", make_gif, methods=["POST"]),
        Mount("/amorsim/web", _Scripts(directory=WEB)),
    ]
    app = Starlette(routes=routes, lifespan=lifespan)
    return Guard(app, door)


class _Scripts(StaticFiles):
    """Our scripts and sheets; a browser asks whether they are new, so that an update is seen at once."""

    def file_response(self, *args: Any, **options: Any) -> Response:
        response = super().file_response(*args, **options)
        response.headers["cache-control"] = "no-cache"
        return response


def listen(host: str, port: int) -> socket.socket:
    """A socket that listens; `port` 0 takes any that is free.

    Raises
    ------
    AmorsimError
        If the address is taken or not this machine's.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    bound = socket.socket(family, socket.SOCK_STREAM)
    bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        bound.bind((host, port))
        bound.listen()  # who asks as soon as the address is printed waits, and is not refused
    except (OSError, OverflowError) as error:
        bound.close()
        reason = getattr(error, "strerror", None) or str(error)
        raise AmorsimError(f"cannot listen on {host}, port {port}: {reason}; choose another with --port") from None
    return bound


class _Server(uvicorn.Server):
    """Ends what it serves at once when a signal comes, not after its windows have gone."""

    def __init__(self, config: uvicorn.Config, ending: Callable[[], None]) -> None:
        super().__init__(config)
        self._ending = ending

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        threading.Thread(target=self._ending, name="amorsim-ending").start()
        super().handle_exit(sig, frame)


def serve(
    session: Simulated,
    *,
    host: str = "127.0.0.1",
    port: int = 0,
    ready: Callable[[Door], None],
    ending: Callable[[], None] = lambda: None,
) -> None:
    """Serve a session's window until the process is told to end.

    `ready` is given the door, which makes addresses to open the window by; `ending` is called in a thread as soon as
    the process is told.
    """
    with listen(host, port) as bound:
        door = Door(host=host, port=bound.getsockname()[1])
        app = build(session, door, lambda: ready(door))
        config = uvicorn.Config(
            app,
            http=Lobby(H11Protocol).receive,  # type: ignore[arg-type] # what makes a protocol, as a class does
            h11_max_incomplete_event_size=LONGEST_HEAD,
            log_level="error",  # what a stranger asks for is not for the terminal
            access_log=False,
            server_header=False,
            timeout_graceful_shutdown=1,
            ws_max_size=LONGEST_MESSAGE,
            ws_per_message_deflate=False,  # frames are floats: it would cost more than it saves
        )
        _Server(config, ending).run(sockets=[bound])
