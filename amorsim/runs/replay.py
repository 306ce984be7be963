"""Giving a simulation again what it was once given from outside: commands by hand, changes, poses."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from amorsim.core.errors import RunError
from amorsim.scenario.spec import Distribution
from amorsim.simulation.simulation import Simulation

__all__ = ["Replay", "read_rows", "revived"]

Row = dict[str, str]


class Replay:
    """What came from outside in a recorded run, to be given to a simulation before each of its steps.

    Raises
    ------
    RunError
        From each method, if a file of the run does not say what such files say.
    """

    def __init__(self, simulation: Simulation, folder: Path) -> None:
        self._simulation = simulation
        self._events = folder / "events.csv"
        self._commands = folder / "commands.csv"
        self._changes: dict[int, list[Row]] = {}
        try:
            for row in read_rows(self._events):
                if row["kind"] in ("parameter_set", "pose_set", "handed_over"):
                    self._changes.setdefault(int(row["tick"]), []).append(row)
        except (KeyError, ValueError, TypeError) as error:
            raise _damaged(self._events, error) from None
        # Others take no commands from outside.
        by_hand = {name for name in simulation.names if simulation.robot(name, simulation.replicas[0]).takes_commands}
        handed = (row["robot"] for rows in self._changes.values() for row in rows if row["kind"] == "handed_over")
        self._by_hand = by_hand.union(handed)
        self._rows = read_rows(self._commands) if self._by_hand else iter(())
        self._next = next(self._rows, None)

    def give(self) -> None:
        """Give what was given before the simulation's next step."""
        simulation = self._simulation
        for row in self._changes.get(simulation.tick, []):
            try:
                replica = int(row.get("replica", simulation.replicas[0]))
                value = revived(json.loads(row["value"]))
            except ValueError as error:
                raise _damaged(self._events, error) from None
            if row["kind"] == "pose_set":
                simulation.set_pose(row["robot"], value, replica=replica)
            elif row["kind"] == "handed_over":
                simulation.hand_over(row["robot"], value, replica=replica)
            else:
                simulation.set(row["robot"], row["path"], value, replica=replica)
        try:
            self._give_commands()
        except (KeyError, ValueError, TypeError) as error:
            raise _damaged(self._commands, error) from None

    def _give_commands(self) -> None:
        """Commands stand in the file at the tick that they led to."""
        simulation = self._simulation
        wanted = simulation.tick + 1
        while self._next is not None:
            row = self._next
            tick = round(float(row["time"]) / simulation.dt)
            if tick > wanted:
                return
            if tick == wanted and row["robot"] in self._by_hand:
                handle = simulation.robot(row["robot"], int(row.get("replica", simulation.replicas[0])))
                if handle.is_by_hand or (handle.takes_commands and handle.is_active):
                    handle.command(*(float(row[name]) for name in handle._group.channels))
            self._next = next(self._rows, None)


def revived(value: Any) -> Any:
    """A value read from JSON as `Simulation.set` takes it: tables may hold distributions."""
    if not isinstance(value, dict):
        return value
    if value.keys() == {"kind", "values"}:
        return Distribution(kind=value["kind"], values=tuple(value["values"]))
    return {name: revived(part) for name, part in value.items()}


def _damaged(path: Path, error: Exception) -> RunError:
    return RunError(f"{path}: is damaged ({type(error).__name__}: {error})")


def read_rows(path: Path) -> Iterator[Row]:
    """The rows of a run's text file, by column.

    Raises
    ------
    RunError
        If it cannot be read.
    """
    try:
        with path.open(encoding="utf-8", newline="") as file:
            yield from csv.DictReader(file)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise RunError(f"{path}: cannot be read ({error})") from None
