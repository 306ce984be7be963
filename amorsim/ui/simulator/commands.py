"""What the child does with each command (see `amorsim.ui.simulator.protocol`)."""

from __future__ import annotations

import base64
import functools
import math
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from amorsim.core.errors import AmorsimError, did_you_mean
from amorsim.scenario.chains import chain_at, is_chain, tables_of
from amorsim.scenario.spec import Robot
from amorsim.ui.forms.chains import chains_of, noises_for, targets_of, with_element, without
from amorsim.ui.forms.live import forms_of, value_at
from amorsim.ui.forms.origins import Origins
from amorsim.ui.forms.values import deviation_of, number_of, plain
from amorsim.ui.scene.robots import sensor_shapes
from amorsim.ui.simulator.inputs import Input
from amorsim.ui.simulator.intended import intended_of
from amorsim.ui.simulator.mapped import mapped_of
from amorsim.ui.simulator.pace import Pace
from amorsim.ui.simulator.player import Player
from amorsim.ui.simulator.protocol import State
from amorsim.ui.simulator.saved_scenario import save_scenario
from amorsim.ui.simulator.scenes import SceneBuilder

__all__ = ["Commands"]

Table = Mapping[str, Any]
Answer = dict[str, Any]

MOST_STEPS_AT_ONCE = 1000


class Commands:
    """Carries out commands on a player, and knows whether it runs.

    `is_ending` is asked whether to leave off. The scenario was read with `changes`, and files of the folder `passing`
    are not there for long (see `Recipe`).
    """

    def __init__(
        self,
        player: Player,
        builder: SceneBuilder,
        is_ending: Callable[[], bool] = lambda: False,
        *,
        changes: Sequence[str] = (),
        passing: str = "",
    ) -> None:
        self._is_ending = is_ending
        self._changes = changes
        self._passing = passing
        self.player = player
        self.pace = Pace()
        self.is_running = False
        self.has_ended = False  # whether it was paused because the scenario's duration is over
        self._builder = builder
        self._does: dict[str, Callable[[Table], Answer | None]] = {
            "state": self._state,
            "parameters": self._parameters,
            "history": self._history,
            "events": self._events,
            "image": self._image,
            "mapped": self._mapped,
            "intended": self._intended,
            "run": self._run,
            "pause": self._pause,
            "step": self._step,
            "speed": self._speed,
            "reset": self._reset,
            "scrub": self._scrub,
            "continue": self._continue,
            "go_back": self._go_back,
            "hand_over": self._hand_over,
            "drive": self._drive,
            "command": self._command,
            "stop": self._stop,
            "set": self._set,
            "restore": self._restore,
            "noises": self._noises,
            "add": self._add,
            "remove": self._remove,
            "changes": self._all_changes,
            "folder": lambda _: {"folder": str(player.folder) if player.folder else ""},
            "forgive": lambda _: player.forgive(),
            "job": self._job,
            "write_scenario": self._write_scenario,
            "remark": self._remark,
        }

    def carry_out(self, command: Table) -> Answer:
        """The answer to a command; a user's mistake is answered with ``ok`` false."""
        try:
            does = self._does.get(str(command.get("do")))
            if does is None:
                known = list(self._does)
                name = command.get("do")
                raise AmorsimError(f"there is no command {name!r}.{did_you_mean(str(name), known)}")
            return {"ok": True, **(does(command) or {})}
        except AmorsimError as error:
            return {"ok": False, "error": str(error)}

    # ------------------------------------------------------------------------------------------------------- arguments

    def _robot(self, command: Table) -> str:
        names = self.player.simulation.names
        robot = command.get("robot")
        if isinstance(robot, int) and not isinstance(robot, bool) and 0 <= robot < len(names):
            return names[robot]
        if isinstance(robot, str):
            return self.player.simulation.robot(robot).name
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
        """How it stands."""
        player = self.player
        names = player.simulation.names
        faults = [line for line in player.remarks if line["kind"] == "fault"]
        return {
            "ok": True,
            "version": self._builder.scene["version"],
            "epoch": player.epoch,
            "status": self.status,
            "tick": player.tick,
            "newest": player.newest,
            "time": player.tick * player.simulation.dt,
            "speed": self.pace.factor,
            "achieved": self.achieved,
            "by_hand": [names[i] for i in np.flatnonzero(player.simulation.by_hand).tolist()],
            "can_continue": not player.is_past or not player.reason,
            "reason": player.reason if player.is_past else player.snapshots.reason,
            "fault": faults[-1] if player.fault is not None and faults else None,
        }

    @property
    def status(self) -> str:
        """How it stands, in a word of the protocol."""
        if self.player.fault is not None:
            return "fault"
        if self.is_running:
            return "running"
        if self.player.is_past:
            return "scrubbed"
        return "ended" if self.has_ended else "paused"

    @property
    def achieved(self) -> float:
        """The speed of late."""
        return self.pace.achieved(time.monotonic()) if self.is_running else 0.0

    def _parameters(self, command: Table) -> Answer:
        robot = self._robot(command)
        simulation = self.player.simulation
        handle = simulation.robot(robot)
        return {
            "parameters": forms_of(simulation, robot, self._origins),
            "chains": chains_of(handle.nominal, self._specified(robot)),
            "targets": targets_of(handle.nominal),
            "sensors": sensor_shapes(handle.true),
        }

    @functools.cached_property
    def _origins(self) -> Origins:
        return Origins(self.player.simulation.scenario)

    def _history(self, command: Table) -> Answer:
        robot = self.player.simulation.names.index(self._robot(command))
        most = self._whole(command, "max_points", 1000)
        ticks, poses = self.player.paths.track(robot, most)
        true, estimated = poses[:, :3].tolist(), poses[:, 3:].tolist()
        past = self.player.pasts.told(robot, most)
        return {"epoch": self.player.epoch, "ticks": ticks, "true": true, "estimated": estimated, "past": past}

    def _events(self, command: Table) -> Answer:
        after = self._whole(command, "after", 0)
        lines = self.player.events()
        return {"epoch": self.player.epoch, "events": lines[after:], "next": len(lines)}

    def _image(self, command: Table) -> Answer:
        try:
            png = self._builder.picture(str(command.get("name")))
        except LookupError as error:
            raise AmorsimError(str(error.args[0])) from None
        return {"png": base64.b64encode(png).decode()}

    def _mapped(self, command: Table) -> Answer:
        robot, player = self._robot(command), self.player
        return {"mapped": mapped_of(player.simulation, robot), "epoch": player.epoch, "tick": player.tick}

    def _intended(self, command: Table) -> Answer:
        robot, player = self._robot(command), self.player
        is_known = player.poses_only is None  # of other moments of the past, what it intended is not kept
        intended = intended_of(player.simulation, robot, is_known=is_known)
        return {"intended": intended, "epoch": player.epoch, "tick": player.tick}

    # ------------------------------------------------------------------------------------------------------------ time

    def _run(self, _: Table) -> None:
        if self.player.fault is not None:
            raise AmorsimError("a controller has failed; take its robot over by hand, or reset")
        if self.player.is_past:
            self.player.scrub(None)
        self.is_running, self.has_ended = True, False
        self.pace.start(time.monotonic())

    def _pause(self, _: Table) -> None:
        self.is_running = False

    def _step(self, command: Table) -> Answer:
        self.is_running = False
        if self.player.is_past:
            self.player.scrub(None)
        made = 0
        for _ in range(min(self._whole(command, "steps", 1), MOST_STEPS_AT_ONCE)):
            if self._is_ending() or not self.player.step():
                break
            made += 1
        return {"tick": self.player.tick, "steps": made}

    def _speed(self, command: Table) -> None:
        if command.get("factor") is None:
            self.pace.factor = None
        else:
            factor = self._number(command, "factor")
            if not 0.001 <= factor <= 1e6:
                raise AmorsimError(f"factor: expected a number from 0.001 to 1e6, got {factor!r}")
            self.pace.factor = factor
        self.pace.start(time.monotonic())

    def _reset(self, _: Table) -> None:
        self.is_running = self.has_ended = False
        self.player.reset()

    def _scrub(self, command: Table) -> Answer:
        self.is_running = False
        wanted = command.get("tick")
        tick = self.player.scrub(None if wanted is None else self._whole(command, "tick"))
        reason = self.player.reason
        exact = self.player.is_exact
        return {"tick": tick, "exact": exact, "can_continue": not reason, "reason": reason}

    def _continue(self, command: Table) -> Answer:
        if command.get("tick") is not None and self._whole(command, "tick") != self.player.tick:
            self._scrub(command)
        self.has_ended = False
        return {"tick": self.player.go_on()}

    def _go_back(self, _: Table) -> Answer:
        self.is_running = self.has_ended = False
        return {"tick": self.player.go_back()}

    # --------------------------------------------------------------------------------------------------------- driving

    def _give(self, do: str, robot: str, value: Any, path: str = "") -> None:
        self.player.give(Input(tick=self.player.tick, do=do, robot=robot, value=value, path=path))

    def _hand_over(self, command: Table) -> None:
        self._give("hand_over", self._robot(command), command.get("to", "hand"))

    def _drive(self, command: Table) -> Answer:
        robot = self._robot(command)
        parts = [self._number(command, part, 0.0) for part in ("forward", "turn", "left")]
        channels = self.player.simulation.robot(robot).command_for(*parts)
        self._give("command", robot, channels)
        return {"channels": channels}

    def _command(self, command: Table) -> None:
        channels = command.get("channels")
        if not isinstance(channels, list) or not all(
            isinstance(part, (int, float)) and not isinstance(part, bool) for part in channels
        ):
            raise AmorsimError(f"channels: expected a list of numbers, got {channels!r}")
        self._give("command", self._robot(command), [float(part) for part in channels])

    def _stop(self, command: Table) -> None:
        """Let robots stand: what is stopped when a window loses the keyboard, or is gone."""
        if self.player.is_past:
            return
        simulation = self.player.simulation
        if command.get("robot") is not None:
            names = [self._robot(command)]
        else:
            names = [simulation.names[i] for i in np.flatnonzero(simulation.by_hand).tolist()]
        for name in names:
            robot = simulation.robot(name)
            if robot.takes_commands:
                self._give("command", name, [0.0] * len(robot.channels))

    # ------------------------------------------------------------------------------------------------------ parameters

    def _set(self, command: Table) -> Answer:
        robot, path = self._robot(command), str(command.get("path"))
        self._give("set", robot, self._given(robot, path, command.get("value")), path)
        return {"value": plain(_value_at(self.player.simulation.robot(robot).nominal, path))}

    def _given(self, robot: str, path: str, value: Any) -> Any:
        """A value from a window as `Simulation.set` takes it."""
        if path.startswith("errors.") and isinstance(value, dict):
            return deviation_of(value)
        if isinstance(value, dict):
            return number_of(value)
        if isinstance(value, float) and value.is_integer():
            before = _value_at(self.player.simulation.robot(robot).nominal, path)
            return int(value) if isinstance(before, int) else value
        return value

    def _restore(self, command: Table) -> None:
        """Set what was changed to what the scenario says: all of a robot, or what is at a path and in it."""
        robot = self._robot(command)
        specified = self._specified(robot)
        paths = [path for name, path in self.player.changes if name == robot]
        if (wanted := command.get("path")) is not None:
            # A number of an error goes with the error, but one of an element alone, and not with its chain.
            paths = [path for path in paths if _is_at(path, wanted) or (_is_at(wanted, path) and not is_chain(path))]
            paths = paths or [wanted]
        for path in paths:
            if wanted is None and (robot, path) not in self.player.changes:  # it went with a chain
                continue
            value = tables_of(specified, path) if is_chain(path) else _value_at(specified, path)
            if value is None and path.endswith(".value"):  # of an error: the scenario has none
                continue
            self._give("set", robot, value, path)
            self.player.forget_change(robot, path)

    def _specified(self, robot: str) -> Robot:
        """A robot as the scenario has it."""
        return next(one for one in self.player.simulation.scenario.robots if one.name == robot)

    def _noises(self, command: Table) -> Answer:
        nominal = self.player.simulation.robot(self._robot(command)).nominal
        return {"choices": noises_for(nominal, _chain_path(command))}

    def _add(self, command: Table) -> Answer:
        """Put an element into a chain of noise."""
        robot, path, value = self._robot(command), _chain_path(command), command.get("value")
        if not isinstance(value, dict):
            raise AmorsimError(f"value: expected a table, as {{'use': 'gaussian', 'std': 0.01}}, got {value!r}")
        index = None if command.get("index") is None else self._whole(command, "index")
        handle = self.player.simulation.robot(robot)
        self._give("set", robot, with_element(handle.nominal, path, value, index), path)
        elements = chain_at(self.player.simulation.robot(robot).nominal, path)
        return {"path": f"{path}.{elements[-1 if index is None else min(index, len(elements) - 1)].name}"}

    def _remove(self, command: Table) -> None:
        """Take an element out of a chain of noise."""
        robot = self._robot(command)
        path, tables = without(self.player.simulation.robot(robot).nominal, str(command.get("path")))
        self._give("set", robot, tables, path)

    def _all_changes(self, _: Table) -> Answer:
        return {"changes": [[robot, path, value] for (robot, path), value in self.player.changes.items()]}

    def _job(self, _: Table) -> Answer:
        """What another process needs to simulate the same again; the digest only where the present is shown."""
        player = self.player
        inputs = [one.to_json() for one in player.inputs]
        digest = None if player.is_past else player.simulation.digest()
        return {"inputs": inputs, "tick": player.newest, "digest": digest}

    def _write_scenario(self, command: Table) -> None:
        """Write the scenario with what was changed into `file`, which the session has looked at."""
        save_scenario(self.player.simulation, Path(str(command["file"])), changes=self._changes, passing=self._passing)

    def _remark(self, command: Table) -> None:
        self.player.remark(
            str(command.get("kind", "note")),
            str(command.get("text", "")),
            robot=str(command.get("robot", "")),
            stack=str(command.get("stack", "")),
        )


def _value_at(robot: Any, path: str) -> Any:
    try:
        return value_at(robot, path)
    except (LookupError, AttributeError) as error:
        raise AmorsimError(f"{path}: {error.args[0]}") from None


def _is_at(path: str, other: str) -> bool:
    """Whether a path is another one, or leads into it."""
    return path == other or path.startswith(f"{other}.")


def _chain_path(command: Table) -> str:
    path = command.get("path")
    if not is_chain(path):
        raise AmorsimError(f"path: expected 'ground' or a sensor's chain, as 'sensors.laser.noise', got {path!r}")
    return str(path)
