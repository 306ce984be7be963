"""A simulation of this very process, shown in a window: that of a notebook's cells, or of a program's own loop.

The window of `amorsim view` plays a simulation in a process of its own. Here it is an object of a notebook or a
program, and both use it in turn: while a cell runs the window waits, and shows afterwards what the cell did.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from amorsim.core.errors import AmorsimError
from amorsim.core.files.reading import is_there
from amorsim.simulation.simulation import Simulation
from amorsim.simulation.state.snapshot import Snapshot
from amorsim.ui.simulator.frames.messages import check
from amorsim.ui.simulator.frames.packing import Bundle, FrameFlag, pack_bundle
from amorsim.ui.simulator.frames.scenes import SceneBuilder
from amorsim.ui.simulator.process.commands import Commands
from amorsim.ui.simulator.process.step_faults import Fault
from amorsim.ui.simulator.project import free_places, place_for
from amorsim.ui.simulator.sources.player import Player

__all__ = ["Live"]

MOST_IN_FLIGHT = 2  # frames on their way to a window
LONGEST_WAIT = 1.0  # [s] for a window to get it: then it has gone
LEAST_BETWEEN_FRAMES = 0.025  # [s]
LONGEST_TURN = 0.02  # [s] of steps, between which the kernel sees to its messages
LONGEST_SLEEP = 0.05  # [s]
Table = Mapping[str, Any]


class _InPlace(Player):
    """A player that keeps the same simulation object when it begins again."""

    _start: Snapshot | None = None

    def _new(self) -> Simulation:
        if self._start is None:
            raise AmorsimError(f"it cannot begin again: {self.snapshots.reason}")
        self.simulation.restore(self._start)
        return self.simulation

    def begin_here(self) -> None:
        """Take the simulation as it is for the beginning."""
        self._begin(self.simulation)
        nearest = self.snapshots.before(self.simulation.tick)
        self._start = None if nearest is None else nearest[1]

    def step_or_raise(self) -> None:
        """Make a step; what fails is raised, as by the simulation itself."""
        self._look_back()
        self.simulation.step()
        self._stepped(watched=True)


class Live:
    """Plays a simulation for windows that send commands and are sent frames.

    Parameters
    ----------
    simulation
        Of one replica.
    send_frame
        Called with each frame for all windows.
    refused
        Commands that this simulation does not carry out, each with the reason, for the user.

    Raises
    ------
    AmorsimError
        If the simulation has several replicas.
    """

    def __init__(
        self,
        simulation: Simulation,
        send_frame: Callable[[bytes], None],
        refused: Mapping[str, str] | None = None,
    ) -> None:
        self._send_frame = send_frame
        self._refused = refused or {}
        self._version = 0
        self._windows: dict[str, int] = {}  # how many frames are on their way to each
        self._robot = 0
        self._number = 0
        self._last_frame = -LONGEST_WAIT
        self._is_stale = True  # whether something has changed since the last frame
        self._playing: asyncio.Task[None] | None = None
        self.take(simulation)

    @property
    def simulation(self) -> Simulation:
        """The simulation that is shown."""
        return self._player.simulation

    def take(self, simulation: Simulation) -> None:
        """Show another simulation, or the same one in another world, from where it is."""
        if len(simulation.replicas) > 1:
            raise AmorsimError(
                f"expected a simulation of one replica, got one of {len(simulation.replicas)}: "
                "am.Simulation(scenario, replicas=[3]) is replica 3 alone"
            )
        self._player = _InPlace(simulation)
        self._player.begin_here()
        self._tick = simulation.tick  # where this has left it
        self._version += 1  # so that windows ask for the new scene
        self._does = Commands(self._player, SceneBuilder(simulation, self._version))
        self._robot = min(self._robot, len(self._player.names) - 1)
        self._is_stale = True

    def step(self) -> None:
        """Make a step for the program that this simulation belongs to; errors are raised as by its own `step`."""
        self._player.watched = (self._robot,)
        self._player.step_or_raise()
        self._tick = self.simulation.tick
        self._is_stale = True

    # ------------------------------------------------------------------------------------------------------ commands

    def open_window(self, window: str) -> None:
        """Let a window watch."""
        self._windows[window] = 0
        self._is_stale = True
        self.show()

    def close_window(self, window: str) -> None:
        """Let a window go; without one the simulation waits."""
        self._windows.pop(window, None)
        if not self._windows:
            self._does.is_running = False

    def received(self, window: str) -> None:
        """Note that a window has got a frame."""
        if window in self._windows:
            self._windows[window] = max(0, self._windows[window] - 1)
        self.show()

    def ask(self, window: str, command: Table) -> dict[str, Any]:
        """The answer to a window's command (see `amorsim.ui.simulator.frames.messages`)."""
        try:
            self._is_stale = self._is_stale or not check(command).asks
            self._follow()
            answer = self._carry_out(window, command)
        except AmorsimError as error:
            answer = {"ok": False, "error": str(error)}
        except KeyboardInterrupt:  # the kernel's own, in a controller that did not return
            answer = {"ok": False, "error": "it was broken off"}
        self._tick = self._player.simulation.tick
        self.show()
        if self._does.is_running and (self._playing is None or self._playing.done()):
            self._playing = asyncio.get_running_loop().create_task(self._play())
        return answer

    def _carry_out(self, window: str, command: Table) -> dict[str, Any]:
        name = command["do"]
        if name in self._refused:
            raise AmorsimError(self._refused[name])
        if name == "scene":
            return {"ok": True, "scene": self._does.scene}
        if name == "controls":
            return {"ok": True, "holder": window, "asking": []}
        if name == "select":
            self._robot = list(self._player.names).index(self._does.robot_of(command))
            return {"ok": True}
        if name == "places":
            project = Path.cwd()
            return {"ok": True, "project": str(project), **free_places(project, self._does.scene["scenario"])}
        if name == "save_scenario":
            file = place_for(Path.cwd(), command["name"], ".toml")
            if is_there(file) and not command.get("overwrite"):
                raise AmorsimError(f"{file.name} is there already; name another file")
            return self._does.carry_out({"do": "write_scenario", "file": str(file)}) | {"file": str(file)}
        answer = self._does.carry_out({"robot": self._robot, **command})
        if name == "state":
            answer |= {"selected": self._robot, "changed": False, "holder": window, "asking": []}
        return answer

    def _follow(self) -> None:
        """Where a cell has moved the simulation, its past begins there."""
        if self._player.simulation.tick != self._tick:
            self._player.begin_here()
            self._tick = self._player.simulation.tick
            self._does.has_ended = False
            self._is_stale = True

    # ------------------------------------------------------------------------------------------------------- playing

    async def _play(self) -> None:
        """Step as the clock demands, and let the kernel see to its messages in between, until it is paused."""
        while self._does.is_running:
            self._follow()
            try:
                self._turn()
            except KeyboardInterrupt:
                self._player.fail(Fault(robots=(), text="a step was interrupted", stack=""))
                self._does.is_running = False
            self._tick = self._player.simulation.tick
            self.show()
            pause = min(LONGEST_SLEEP, self._does.pace.wait(time.monotonic()))
            await asyncio.sleep(pause if self._does.is_running else 0.0)
        self._is_stale = True
        self.show()

    def _turn(self) -> None:
        does, player = self._does, self._player
        until = time.monotonic() + LONGEST_TURN
        while does.is_running and does.pace.wait(now := time.monotonic()) <= 0.0:
            player.watched = (self._robot,)
            if not player.step():
                does.is_running = False
            does.pace.stepped(now, player.dt)
            self._is_stale = True
            if player.tick == player.last:
                does.is_running, does.has_ended = False, True
            if now >= until:
                return

    def show(self) -> None:
        """Send a frame if there is something new, and a window that can take it."""
        now = time.monotonic()
        waited = now - self._last_frame
        if not self._windows or not self._is_stale or (waited < LEAST_BETWEEN_FRAMES and self._does.is_running):
            return
        if min(self._windows.values()) >= MOST_IN_FLIGHT:
            if waited < LONGEST_WAIT:
                return
            self._windows = dict.fromkeys(self._windows, 0)
        self._follow()
        does = self._does
        self._is_stale = False
        self._number += 1
        self._last_frame = now
        self._windows = {window: count + 1 for window, count in self._windows.items()}
        flags = (FrameFlag.RUNNING if does.is_running else 0) | (FrameFlag.ENDED if does.has_ended else 0)
        speed = float("inf") if does.pace.factor is None else does.pace.factor
        self._player.watched = (self._robot,)
        moments = self._player.frames(
            version=does.scene["version"], number=self._number, speed=speed, achieved=does.achieved, flags=flags
        )
        frame = Bundle(pack_bundle(moments)).frame(self._robot, self._number)
        assert frame is not None  # of the one robot that is watched
        self._send_frame(frame)
