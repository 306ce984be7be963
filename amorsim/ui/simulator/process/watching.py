"""The child's commands that look at a source, or move in its time."""

from __future__ import annotations

import abc
import base64
import math
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from amorsim.core.errors import AmorsimError, did_you_mean
from amorsim.core.unknown_names import no_such
from amorsim.ui.scene.wire import Scene
from amorsim.ui.simulator.frames.protocol import State
from amorsim.ui.simulator.process.pace import Pace
from amorsim.ui.simulator.sources.source import Source, Track

__all__ = ["Answer", "Table", "Watching"]

Table = Mapping[str, Any]
Answer = dict[str, Any]

MOST_STEPS_AT_ONCE = 1000


class Watching(abc.ABC):
    """Carries out commands that look at a source or move in its time; keeps whether it plays.

    `is_ending` is asked whether to leave off.
    """

    def __init__(self, source: Source, is_ending: Callable[[], bool] = lambda: False) -> None:
        self._is_ending = is_ending
        self.source = source
        self.pace = Pace()
        self.is_running = False
        self.has_ended = False  # whether it was paused because the scenario's duration is over
        self._does: dict[str, Callable[[Table], Answer | None]] = {
            "state": self._state,
            "history": self._history,
            "events": self._events,
            "image": self._image,
            "mapped": self._mapped,
            "intended": self._intended,
            "run": self._run,
            "pause": self._pause,
            "step": self._step,
            "speed": self._speed,
            "scrub": self._scrub,
            "folder": lambda _: {"folder": str(source.folder) if source.folder else ""},
            "remark": self._remark,
        }

    @property
    @abc.abstractmethod
    def scene(self) -> Scene:
        """All that stays as it is while the source is played."""

    @abc.abstractmethod
    def picture(self, name: str) -> bytes:
        """The PNG that a map's shape names; raises as `MapShapes.picture`."""

    def carry_out(self, command: Table) -> Answer:
        """The answer to a command; a user's mistake is answered with ``ok`` false."""
        try:
            name = str(command.get("do"))
            does = self._does.get(name)
            if does is None:
                raise AmorsimError(self._refusal(name))
            return {"ok": True, **(does(command) or {})}
        except AmorsimError as error:
            return {"ok": False, "error": str(error)}

    def _refusal(self, name: str) -> str:
        """The answer to a command that is not known here."""
        return f"there is no command {name!r}.{did_you_mean(name, list(self._does))}"

    # ------------------------------------------------------------------------------------------------------- arguments

    def robot_of(self, command: Table) -> str:
        """The name of the robot that a command is for."""
        names = self.source.names
        robot = command.get("robot")
        if isinstance(robot, int) and not isinstance(robot, bool) and 0 <= robot < len(names):
            return names[robot]
        if isinstance(robot, str):
            if robot not in names:
                raise AmorsimError(no_such("robot", robot, names))
            return robot
        raise AmorsimError(f"expected a robot's name or its place from 0 to {len(names) - 1}, got {robot!r}")

    @staticmethod
    def _number(command: Table, name: str, default: float | None = None) -> float:
        value = command.get(name, default)
        if not isinstance(value, (int, float)) or isinstance(value, bool) or not math.isfinite(value):
            raise AmorsimError(f"{name}: expected a finite number, got {value!r}")
        return float(value)

    @staticmethod
    def _whole(command: Table, name: str, default: int | None = None) -> int:
        value = command.get(name, default)
        if not isinstance(value, int) or isinstance(value, bool) or value < 0:
            raise AmorsimError(f"{name}: expected a whole number >= 0, got {value!r}")
        return value

    # --------------------------------------------------------------------------------------------------------- looking

    def _state(self, _: Table) -> Answer:
        return dict(self.state())

    def state(self) -> State:
        """Its state."""
        source = self.source
        faults = [line for line in source.remarks if line["kind"] == "fault"]
        return {
            "ok": True,
            "version": self.scene["version"],
            "epoch": source.epoch,
            "status": self.status,
            "tick": source.tick,
            "newest": source.newest,
            "time": source.tick * source.dt,
            "speed": self.pace.factor,
            "achieved": self.achieved,
            "by_hand": source.by_hand,
            "can_continue": not source.is_past or not source.reason,
            "reason": source.reason,
            "fault": faults[-1] if source.fault is not None and faults else None,
        }

    @property
    def status(self) -> str:
        """Its state, in a word of the protocol."""
        if self.source.fault is not None:
            return "fault"
        if self.is_running:
            return "running"
        if self.source.is_past:
            return "scrubbed"
        return "ended" if self.has_ended else "paused"

    @property
    def achieved(self) -> float:
        """The speed of late."""
        return self.pace.achieved(time.monotonic()) if self.is_running else 0.0

    def _history(self, command: Table) -> Answer:
        robot = self.source.names.index(self.robot_of(command))
        most = self._whole(command, "max_points", 1000)
        return {"epoch": self.source.epoch, **self.path_of(self.source.track(robot, most))}

    @staticmethod
    def path_of(track: Track) -> Answer:
        """The past of a robot, as windows read it."""
        ticks, poses, past = track
        known: npt.NDArray[np.object_] = poses.astype(object)
        known[~np.isfinite(poses)] = None  # JSON has no nan
        return {"ticks": ticks, "true": known[:, :3].tolist(), "estimated": known[:, 3:].tolist(), "past": past}

    def _events(self, command: Table) -> Answer:
        after = self._whole(command, "after", 0)
        lines = self.source.events()
        return {"epoch": self.source.epoch, "events": lines[after:], "next": len(lines)}

    def _image(self, command: Table) -> Answer:
        try:
            png = self.picture(str(command.get("name")))
        except LookupError as error:
            raise AmorsimError(str(error.args[0])) from None
        return {"png": base64.b64encode(png).decode()}

    def _mapped(self, command: Table) -> Answer:
        source = self.source
        return {"mapped": source.mapped(self.robot_of(command)), "epoch": source.epoch, "tick": source.tick}

    def _intended(self, command: Table) -> Answer:
        source = self.source
        return {"intended": source.intended(self.robot_of(command)), "epoch": source.epoch, "tick": source.tick}

    # ------------------------------------------------------------------------------------------------------------ time

    def _run(self, _: Table) -> None:
        if self.source.fault is not None:
            raise AmorsimError("a controller has failed; take its robot over by hand, or reset")
        self.source.begin_playing()
        self.is_running, self.has_ended = True, False
        self.pace.start(time.monotonic())

    def _pause(self, _: Table) -> None:
        self.is_running = False

    def _step(self, command: Table) -> Answer:
        self.is_running = False
        self.source.begin_playing()
        made = 0
        for _ in range(min(self._whole(command, "steps", 1), MOST_STEPS_AT_ONCE)):
            if self._is_ending() or not self.source.step():
                break
            made += 1
        return {"tick": self.source.tick, "steps": made}

    def _speed(self, command: Table) -> None:
        if command.get("factor") is None:
            self.pace.factor = None
        else:
            factor = self._number(command, "factor")
            if not 0.001 <= factor <= 1e6:
                raise AmorsimError(f"factor: expected a number from 0.001 to 1e6, got {factor!r}")
            self.pace.factor = factor
        self.pace.start(time.monotonic())

    def _scrub(self, command: Table) -> Answer:
        self.is_running = False
        wanted = command.get("tick")
        tick = self.source.scrub(None if wanted is None else self._whole(command, "tick"))
        reason = self.source.reason
        exact = self.source.is_exact
        return {"tick": tick, "exact": exact, "can_continue": not reason, "reason": reason}

    def _remark(self, command: Table) -> None:
        self.source.remark(
            str(command.get("kind", "note")),
            str(command.get("text", "")),
            robot=str(command.get("robot", "")),
            stack=str(command.get("stack", "")),
        )
