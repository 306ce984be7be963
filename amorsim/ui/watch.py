"""A window for a simulation that a program steps itself: to watch it, and to change its errors."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from amorsim.array_types import Array
from amorsim.core.errors import AmorsimError
from amorsim.simulation.simulation import Simulation
from amorsim.ui.serve.launch_url import LaunchUrl
from amorsim.ui.simulator.frames.messages import COMMANDS
from amorsim.ui.simulator.in_process import Live
from amorsim.ui.simulator.show import check_extra

if TYPE_CHECKING:
    from amorsim.ui.serve.security import Door

__all__ = ["Watch"]


_OF_THE_PROGRAM = (
    *("run", "pause", "step", "speed", "reset", "scrub", "continue", "go_back", "forget", "hand_over", "drive"),
    *("command", "reload", "restart", "page", "save_run", "replica"),
)
_REFUSED = dict.fromkeys(_OF_THE_PROGRAM, "a program steps and drives this simulation; here it is watched")


class Watch:
    """Serves the Simulator's window from a thread of this process, for one simulation after the other.

    The program steps by `step` instead of the simulation's own, and calls `show` where it would draw. In between,
    windows read the simulation, and set its errors; `lock` keeps the two apart.

    Parameters
    ----------
    simulation
        Of one replica.
    name
        Of the page.
    goal_of
        The goal (x, y) [m] of a robot by its number, or None; it is drawn as the robot's path.
    browser
        Whether to open the window in the browser. Its address is printed in any case.

    Raises
    ------
    AmorsimError
        If the extra ``ui`` is not installed, or the simulation has several replicas.
    """

    def __init__(
        self,
        simulation: Simulation,
        *,
        name: str,
        goal_of: Callable[[int], Array | None] = lambda _: None,
        browser: bool = True,
    ) -> None:
        check_extra()
        self._goal_of = goal_of
        self.lock = threading.RLock()
        self._live = Live(simulation, self._take_frame, _REFUSED)
        self._name, self._browser = name, browser
        self._frame, self._number, self._next_window = b"", 0, 1
        self._due = 0.0
        self._ready = threading.Event()
        self._problem: AmorsimError | None = None
        self._thread = threading.Thread(target=self._serve, name="amorsim-window", daemon=True)
        self._thread.start()
        self._ready.wait()
        if self._problem is not None:
            raise self._problem

    @property
    def simulation(self) -> Simulation:
        """The simulation that is shown."""
        return self._live.simulation

    def take(self, simulation: Simulation) -> None:
        """Show another simulation, or the same one in another world, from where it is."""
        with self.lock:
            self._live.take(simulation)

    def step(self) -> None:
        """Step the simulation."""
        with self.lock:
            self._live.step()

    def show(self, period: float) -> None:
        """Show the simulation as it is, at the earliest a period [s] after it was shown last."""
        time.sleep(max(0.0, self._due - time.monotonic()))
        self._due = time.monotonic() + period
        with self.lock:
            self._live.show()

    def close(self) -> None:
        """Close the window's server; again if one likes."""
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._closing.set)
            self._thread.join()

    # -------------------------------------------------------------------------------------------------- in its thread

    def _serve(self) -> None:
        from amorsim.ui.serve.pages import Pages
        from amorsim.ui.serve.server import serve

        pages = Pages()
        pages.add("run", self._name, self)
        invitation = LaunchUrl(browser=self._browser, say=print, complain=print)

        def ready(door: Door) -> None:
            invitation.ready(door)
            self._ready.set()

        async def serving() -> None:
            self._loop = asyncio.get_running_loop()
            self._new = asyncio.Event()
            self._closing = asyncio.Event()
            await serve(pages, ready=ready, closing=self._closing)

        try:
            asyncio.run(serving())
        except AmorsimError as error:
            self._problem = error
        finally:
            invitation.forget()
            self._ready.set()

    def _take_frame(self, frame: bytes) -> None:
        self._frame, self._number = frame, int.from_bytes(frame[8:12], "little")
        self._loop.call_soon_threadsafe(self._new.set)

    # ------------------------------------------------------------------------------------------- as a server's session

    def open_window(self, tab: str = "") -> str:
        """A new window's name."""
        name, self._next_window = f"window-{self._next_window}", self._next_window + 1
        with self.lock:
            self._live.open_window(name)
        return name

    def close_window(self, window: str) -> None:
        """Let a window go."""
        with self.lock:
            self._live.close_window(window)

    async def newest_frame(self, after: int = 0, window: str = "") -> bytes:
        """The newest frame, as soon as its number is above `after`."""
        while self._number <= after:
            self._new.clear()
            await self._new.wait()
        with self.lock:
            self._live.received(window)
        return self._frame

    def only_asks(self, name: str) -> bool:
        """Whether a command only asks."""
        return name in COMMANDS and COMMANDS[name].asks

    async def ask(self, window: str, command: Mapping[str, Any]) -> dict[str, Any]:
        """The answer to a window's command."""
        with self.lock:
            answer = self._live.ask(window, command)
            if command.get("do") == "intended" and answer["ok"]:
                answer["intended"] = {**answer["intended"], "path": self._way(command.get("robot", 0))}
            return answer

    def _way(self, robot: int | str) -> list[list[float]] | None:
        """Straight from a robot, as it believes, to its goal."""
        number = self.simulation.names.index(robot) if isinstance(robot, str) else robot
        goal = self._goal_of(number)
        if goal is None:
            return None
        return [self.simulation.estimated_pose[number, :2].tolist(), goal.tolist()]
