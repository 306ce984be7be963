"""Replaying a run's outside inputs to a simulation: commands by hand, changes, poses."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from amorsim.core.errors import AmorsimError, RunError
from amorsim.core.files.json_files import parse_json
from amorsim.runs.tables import Line, read_lines
from amorsim.scenario.reading.chains import is_chain
from amorsim.scenario.reading.faults import shown
from amorsim.scenario.spec import Distribution
from amorsim.simulation.simulation import MAX_REPLICA, Simulation

__all__ = ["Replay", "revived"]

_CHANGES = ("parameter_set", "pose_set", "handed_over")


class Replay:
    """The outside inputs of a recorded run, to be given to a simulation before each of its steps.

    Parameters
    ----------
    simulation
        At its start.
    folder
        Of the run.
    before
        How many changes were made before it was recorded: they are made here, so that its start shows them.

    Raises
    ------
    RunError
        From each method, if a file of the run is damaged; it names file, line and column.
    """

    def __init__(self, simulation: Simulation, folder: Path, before: int = 0) -> None:
        self._simulation = simulation
        self._changes: dict[int, list[Line]] = {}
        handed = set()
        for line in read_lines(folder / "events.csv"):
            if (kind := line.text("kind")) in _CHANGES:
                self._changes.setdefault(line.whole("tick"), []).append(line)
                if kind == "handed_over":
                    handed.add(line.text("robot"))
        # Others take no commands from outside.
        by_hand = {name for name in simulation.names if simulation.robot(name, simulation.replicas[0]).takes_commands}
        self._by_hand = by_hand | handed
        self._lines = read_lines(folder / "commands.csv") if self._by_hand else iter(())
        self._next = next(self._lines, None)
        at_start = self._changes.get(0, [])
        for line in at_start[:before]:
            self._change(line)
        del at_start[:before]

    def give(self) -> None:
        """Give the recorded inputs that came before the simulation's next step."""
        for line in self._changes.get(self._simulation.tick, []):
            self._change(line)
        self._give_commands()

    def _change(self, line: Line) -> None:
        simulation, kind = self._simulation, line.text("kind")
        robot, replica, value = line.text("robot"), self._replica(line), _value(line)
        try:
            if kind == "pose_set":
                simulation.set_pose(robot, _pose(line, value), replica=replica)
            elif kind == "handed_over":
                simulation.hand_over(robot, value, replica=replica)
            elif not is_chain(path := line.text("path")):
                simulation.set(robot, path, value, replica=replica)
            elif replica == simulation.replicas[0]:  # a chain changes in all replicas at once
                simulation.set(robot, path, value)
        except RunError:
            raise
        except AmorsimError as error:
            raise line.damaged("value", str(error)) from None
        except (TypeError, ValueError, AttributeError, OverflowError):
            # Simulations take what amorsim wrote; what else may stand here has any type.
            raise line.damaged("value", f"no parameter takes {shown(value)}") from None

    def _replica(self, line: Line) -> int:
        """The number of the replica that a line is of."""
        first = self._simulation.replicas[0]
        replica = line.whole("replica") if "replica" in line.cells else first
        if replica > MAX_REPLICA or replica not in self._simulation.replicas:
            raise line.damaged("replica", f"there is no replica {replica}")
        return replica

    def _give_commands(self) -> None:
        """Give the commands of a tick: the file has them at the tick that they led to."""
        simulation = self._simulation
        wanted = simulation.tick + 1
        while self._next is not None:
            line = self._next
            tick = line.real("time") / simulation.dt
            if math.isinf(tick):
                raise line.damaged("time", f"expected a time of the run [s], got {line.text('time')[:60]}")
            if round(tick) > wanted:
                return
            if round(tick) == wanted and line.text("robot") in self._by_hand:
                self._command(line)
            self._next = next(self._lines, None)

    def _command(self, line: Line) -> None:
        replica = self._replica(line)
        try:
            handle = self._simulation.robot(line.text("robot"), replica)
        except AmorsimError as error:
            raise line.damaged("robot", str(error)) from None
        if handle.is_by_hand or (handle.takes_commands and handle.is_active):
            handle.command(*(line.real(name) for name in handle.channels))


def _value(line: Line) -> Any:
    """The value of a change, as `Simulation.set` takes it."""
    try:
        return revived(parse_json(line.text("value")))
    except (ValueError, AmorsimError) as error:
        raise line.damaged("value", f"expected a value as JSON ({error})") from None


def revived(value: Any) -> Any:
    """A value read from JSON as `Simulation.set` takes it: tables may hold distributions."""
    if not isinstance(value, dict):
        return value
    if value.keys() == {"kind", "values"}:
        if not isinstance(value["values"], list):
            raise ValueError(f"expected a list of numbers under 'values', got {shown(value['values'])}")
        return Distribution(kind=value["kind"], values=tuple(value["values"]))
    return {name: revived(part) for name, part in value.items()}


def _pose(line: Line, value: Any) -> list[float]:
    is_pose = isinstance(value, list) and len(value) == 3
    if not is_pose or not all(type(part) in (int, float) and abs(part) < math.inf for part in value):
        raise line.damaged("value", f"expected a pose of three finite numbers, got {shown(value)}")
    return value  # type: ignore[no-any-return]
