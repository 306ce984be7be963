"""The child's commands that change a simulation (see `amorsim.ui.simulator.frames.protocol`)."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from amorsim.core.errors import AmorsimError
from amorsim.plugins.manager import default_registry
from amorsim.scenario.reading.chains import chain_at, is_chain, tables_of
from amorsim.scenario.spec import Robot
from amorsim.ui.forms.chains import chains_of, noises_for, targets_of, with_element, without
from amorsim.ui.forms.json_values import deviation_of, number_of, plain
from amorsim.ui.forms.manuals import components_of, manual_of
from amorsim.ui.forms.origins import Origins
from amorsim.ui.forms.running_robot import forms_of, value_at
from amorsim.ui.scene.drawn_robots import sensor_shapes
from amorsim.ui.scene.wire import Scene
from amorsim.ui.simulator.frames.scenes import SceneBuilder
from amorsim.ui.simulator.process.watching import Answer, Table, Watching
from amorsim.ui.simulator.saved_scenario import save_scenario
from amorsim.ui.simulator.sources.inputs import Input
from amorsim.ui.simulator.sources.player import Player

__all__ = ["Commands"]


class Commands(Watching):
    """Carries out commands on a simulation.

    The scenario was read with `changes`, and files of the folder `passing` are temporary (see `Recipe`).
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
        super().__init__(player, is_ending)
        self._builder = builder
        self.player = player
        self._changes = changes
        self._passing = passing
        self._does |= {
            "parameters": self._parameters,
            "reset": self._reset,
            "continue": self._continue,
            "futures": self._futures,
            "forget": self._forget,
            "go_back": self._go_back,
            "hand_over": self._hand_over,
            "drive": self._drive,
            "command": self._command,
            "stop": self._stop,
            "set": self._set,
            "restore": self._restore,
            "noises": self._noises,
            "manual": lambda command: {"manual": manual_of(command["kind"], command["name"], default_registry())},
            "add": self._add,
            "remove": self._remove,
            "changes": self._all_changes,
            "forgive": lambda _: player.forgive(),
            "job": self._job,
            "write_scenario": self._write_scenario,
        }

    @property
    def scene(self) -> Scene:
        """All that stays as it is while the simulation runs."""
        return self._builder.scene

    def picture(self, name: str) -> bytes:
        """The PNG that a map's shape names; raises as `MapShapes.picture`."""
        return self._builder.picture(name)

    # ------------------------------------------------------------------------------------------------------ time

    def _reset(self, _: Table) -> None:
        self.is_running = self.has_ended = False
        self.player.reset()

    def _parameters(self, command: Table) -> Answer:
        robot = self.robot_of(command)
        simulation = self.player.simulation
        handle = simulation.robot(robot)
        return {
            "parameters": forms_of(simulation, robot, self._origins),
            "chains": chains_of(handle.nominal, self._specified(robot)),
            "targets": targets_of(handle.nominal),
            "components": components_of(handle.nominal, default_registry()),
            "sensors": sensor_shapes(handle.true),
        }

    @functools.cached_property
    def _origins(self) -> Origins:
        return Origins(self.player.simulation.scenario)

    def _continue(self, command: Table) -> Answer:
        if command.get("tick") is not None and self._whole(command, "tick") != self.player.tick:
            self._scrub(command)
        self.has_ended = False
        return {"tick": self.player.go_on()}

    def _go_back(self, command: Table) -> Answer:
        self.is_running = self.has_ended = False
        number = None if command.get("number") is None else self._whole(command, "number")
        return {"tick": self.player.go_back(number)}

    def _futures(self, command: Table) -> Answer:
        player, name = self.player, self.robot_of(command)
        robot, most = player.names.index(name), self._whole(command, "max_points", 1000)
        others: list[Answer] = [
            {
                "number": other.number,
                "since": other.since,
                "newest": other.newest,
                "changes": other.changes_of(name),
                **self.path_of(other.track(robot, most)),
            }
            for other in player.others
        ]
        facts: Answer = {"epoch": player.epoch, "number": player.number, "can_go_back": player.can_go_back}
        return facts | {"others": others}

    def _forget(self, command: Table) -> None:
        self.player.forget(self._whole(command, "number"))

    # --------------------------------------------------------------------------------------------------------- driving

    def _give(self, do: str, robot: str, value: Any, path: str = "") -> None:
        self.player.give(Input(tick=self.player.tick, do=do, robot=robot, value=value, path=path))

    def _hand_over(self, command: Table) -> None:
        self._give("hand_over", self.robot_of(command), command.get("to", "hand"))

    def _drive(self, command: Table) -> Answer:
        robot = self.robot_of(command)
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
        self._give("command", self.robot_of(command), [float(part) for part in channels])

    def _stop(self, command: Table) -> None:
        """Stop robots that are driven by hand: the window lost the keyboard, or was closed."""
        if self.player.is_past:
            return
        simulation = self.player.simulation
        if command.get("robot") is not None:
            names = [self.robot_of(command)]
        else:
            names = [simulation.names[i] for i in np.flatnonzero(simulation.by_hand).tolist()]
        for name in names:
            robot = simulation.robot(name)
            if robot.takes_commands:
                self._give("command", name, [0.0] * len(robot.channels))

    # ------------------------------------------------------------------------------------------------------ parameters

    def _set(self, command: Table) -> Answer:
        robot, path = self.robot_of(command), str(command.get("path"))
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
        """Set changed values to the scenario's: all of a robot, or those at a path and below."""
        robot = self.robot_of(command)
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
        nominal = self.player.simulation.robot(self.robot_of(command)).nominal
        written = command.get("value")
        return {"choices": noises_for(nominal, _chain_path(command), written if isinstance(written, dict) else None)}

    def _add(self, command: Table) -> Answer:
        """Put an element into a chain of noise."""
        robot, path, value = self.robot_of(command), _chain_path(command), command.get("value")
        if not isinstance(value, dict):
            raise AmorsimError(f"value: expected a table, as {{'use': 'gaussian', 'std': 0.01}}, got {value!r}")
        index = None if command.get("index") is None else self._whole(command, "index")
        handle = self.player.simulation.robot(robot)
        self._give("set", robot, with_element(handle.nominal, path, value, index), path)
        elements = chain_at(self.player.simulation.robot(robot).nominal, path)
        return {"path": f"{path}.{elements[-1 if index is None else min(index, len(elements) - 1)].name}"}

    def _remove(self, command: Table) -> None:
        """Take an element out of a chain of noise."""
        robot = self.robot_of(command)
        path, tables = without(self.player.simulation.robot(robot).nominal, str(command.get("path")))
        self._give("set", robot, tables, path)

    def _all_changes(self, _: Table) -> Answer:
        return {"changes": [[robot, path, value] for (robot, path), value in self.player.changes.items()]}

    def _job(self, _: Table) -> Answer:
        """All that another process needs to simulate the same again; the digest only where the present is shown."""
        player = self.player
        inputs = [one.to_json() for one in player.inputs]
        digest = None if player.is_past else player.simulation.digest()
        return {"inputs": inputs, "tick": player.newest, "digest": digest}

    def _write_scenario(self, command: Table) -> None:
        """Write the scenario with its changes into `file`, a path that the session has checked."""
        save_scenario(self.player.simulation, Path(str(command["file"])), changes=self._changes, passing=self._passing)


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
