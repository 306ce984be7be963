"""The columns of one robot in the tables of a run, which have the columns of all its robots."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from amorsim.analysis.run_files import RunFiles, Table
from amorsim.array_types import Array
from amorsim.core.errors import RunError
from amorsim.core.unknown_names import no_such
from amorsim.scenario.spec import Robot
from amorsim.simulation.fleet.grouping import channels_of, reading_size

__all__ = ["own_channels", "own_commands", "own_readings"]


def own_channels(files: RunFiles, robot: str, columns: Collection[str]) -> tuple[str, ...]:
    """A robot's channels, in their order, all of them among the columns of ``commands.csv``.

    Raises
    ------
    RunError
        If one is missing.
    """
    channels = channels_of(_specified(files, robot))
    _check_columns(files, "commands", columns, channels)
    return channels


def own_commands(files: RunFiles, robot: str, replica: int | None) -> tuple[Table, Array]:
    """The lines of a robot in ``commands.csv``, and its commands `(lines, channels)`, in the order of its channels.

    Raises
    ------
    RunError
        If the file is damaged or lacks a channel, or the run has no such robot or replica.
    """
    table = files.table("commands", robot=robot, replica=replica)
    return table, _values(table, own_channels(files, robot, table))


def own_readings(files: RunFiles, robot: str, sensor: str, replica: int | None) -> tuple[Table, Array]:
    """The lines of a robot's sensor in its file, and what was measured `(samples, values)`.

    Raises
    ------
    RunError
        If the file is damaged or lacks a value, or the run has no such robot or replica.
    """
    name = f"sensors/{sensor}"
    table = files.table(name, robot=robot, replica=replica)
    keys = [f"measured_{i}" for i in range(reading_size(_specified(files, robot), sensor))]
    _check_columns(files, name, table, keys)
    return table, _values(table, keys)


def _specified(files: RunFiles, robot: str) -> Robot:
    return next(each for each in files.scenario.robots if each.name == robot)


def _check_columns(files: RunFiles, name: str, columns: Collection[str], keys: Sequence[str]) -> None:
    for key in keys:
        if key not in columns:
            raise RunError(f"{files.folder / name}.csv, line 1: {no_such('column', key, columns)}")


def _values(table: Table, keys: Sequence[str]) -> Array:
    return np.stack([table[key] for key in keys], axis=1)
