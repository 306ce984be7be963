"""What the child does with each command (see `amorsim.ui.simulator.protocol`)."""

from __future__ import annotations

import base64
import math
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from amorsim.core.errors import AmorsimError, RunError, did_you_mean
from amorsim.core.whole_files import copy_file
from amorsim.plugins.manager import default_registry
from amorsim.scenario.maps import MapFile, companions_of
from amorsim.scenario.names import name_from, rename_maps
from amorsim.scenario.spec import Scenario
from amorsim.scenario.write import resolved_table, write_table
from amorsim.ui.forms.live import forms_of, value_at
from amorsim.ui.simulator.inputs import Input
from amorsim.ui.simulator.pace import Pace
from amorsim.ui.simulator.player import Player
from amorsim.ui.simulator.protocol import State
from amorsim.ui.simulator.scenes import SceneBuilder, sensor_shapes

__all__ = ["Commands"]

Table = Mapping[str, Any]
Answer = dict[str, Any]

MOST_STEPS_AT_ONCE = 1000


class Commands:
    """Carries out commands on a player, and knows whether it runs.

    `is_ending` is asked whether to leave off. Files of the folder `passing` are not there for long (see `Recipe`).
    """

    def __init__(
        self,
        player: Player,
        builder: SceneBuilder,
        is_ending: Callable[[], bool] = lambda: False,
        *,
        passing: str = "",
    ) -> None:
        self._is_ending = is_ending
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
        return {"parameters": forms_of(simulation, robot), "sensors": sensor_shapes(simulation.robot(robot).true)}

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
        value = self._number(command, "value")
        before = _value_at(self.player.simulation.robot(robot).nominal, path)
        self._give("set", robot, int(value) if isinstance(before, int) and value.is_integer() else value, path)
        return {"value": _plain(_value_at(self.player.simulation.robot(robot).nominal, path))}

    def _restore(self, command: Table) -> None:
        """Set what was changed to what the scenario says."""
        robot = self._robot(command)
        specified = next(one for one in self.player.simulation.scenario.robots if one.name == robot)
        paths = [path for name, path in self.player.changes if name == robot]
        if command.get("path") is not None:
            paths = [path for path in paths if path == command["path"]]
        for path in paths:
            value = _value_at(specified, path)
            if value is None:  # ``value`` of an error, which takes the nominal value's place: the scenario has none
                continue
            self._give("set", robot, value, path)
            self.player.forget_change(robot, path)

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
        simulation = self.player.simulation
        names = [robot.name for robot in simulation.scenario.robots]
        robots = [simulation.robot(name).nominal for name in names]
        scenario = attrs.evolve(simulation.scenario, robots=robots, seed=simulation.seed)
        path = Path(str(command["file"]))
        document = resolved_table(scenario)
        _copy_maps(document, scenario, self._not_the_users(scenario), path)
        name_from(path.parent, document, scenario)
        write_table(document, path)

    def _not_the_users(self, scenario: Scenario) -> list[Path]:
        """The folders whose files a scenario of the user's should not name: they pass, or belong to a program."""
        registry = default_registry()
        bundled = {registry.file("scenario", name).parent for name in registry.names("scenario")}
        folders = {Path(self._passing)} if self._passing else set()
        if scenario.source is not None:
            folders |= {scenario.source.parent} & bundled
        return sorted(folders)

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


def _copy_maps(document: dict[str, Any], scenario: Scenario, folders: list[Path], path: Path) -> None:
    """Copy the maps that lie in some folders next to the file that is to be, named after it, and name the copies.

    Maps of several files stay where they are.
    """
    copies: dict[str, str] = {}
    maps = [scenario.map, *(robot.knowledge.map for robot in scenario.robots if robot.knowledge.map is not None)]
    files = [found.source for found in maps if isinstance(found.source, MapFile)]
    whole = {str(file.path.absolute()) for file in files if not companions_of(file)}

    def kept(name: str) -> str:
        file = Path(name)
        if name not in whole or not any(file.is_relative_to(folder) for folder in folders):
            return name
        if name not in copies:
            number, copy = 1, path.with_suffix(file.suffix)
            while not _is_copied(file, copy):
                number += 1
                copy = path.with_name(f"{path.stem}-{number}{file.suffix}")
            copies[name] = str(copy)
        return copies[name]

    rename_maps(document, kept)


def _is_copied(file: Path, copy: Path) -> bool:
    """Copy a file to where there is none; whether there was none. A link there, which may lead anywhere, is one."""
    try:
        copy.touch(exist_ok=False)
    except FileExistsError:
        return False
    except OSError as error:
        raise RunError(f"{copy}: cannot be written: {error.strerror or error}") from error
    try:
        copy_file(file, copy)
    except RunError:
        copy.unlink(missing_ok=True)
        raise
    return True


def _plain(value: Any) -> float | None:
    return float(value) if isinstance(value, (int, float)) else None
