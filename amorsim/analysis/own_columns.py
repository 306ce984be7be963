"""What is a robot's own in the tables of a run, whose columns are those of all its robots together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from amorsim.analysis.files import RunFiles, Table
from amorsim.core.errors import RunError
from amorsim.scenario.spec import Robot
from amorsim.simulation.alike import channels_of, reading_size

__all__ = ["own_commands", "own_readings"]

Array = npt.NDArray[np.float64]


def own_commands(files: RunFiles, robot: str, replica: int | None) -> tuple[Table, Array]:
    """The lines of a robot in ``commands.csv``, and its commands `(lines, channels)`, in the order of its channels.

    Raises
    ------
    RunError
        If the file is damaged or lacks a channel, or the run has no such robot or replica.
    """
    table = files.table("commands", robot=robot, replica=replica)
    return table, _columns(files, "commands", table, channels_of(_specified(files, robot)))


def own_readings(files: RunFiles, robot: str, sensor: str, replica: int | None) -> tuple[Table, Array]:
    """The lines of a robot's sensor in its file, and what was measured `(samples, values)`.

    Raises
    ------
    RunError
        If the file is damaged or lacks a value, or the run has no such robot or replica.
    """
    name = f"sensors/{sensor}"
    table = files.table(name, robot=robot, replica=replica)
    size = reading_size(_specified(files, robot), sensor)
    return table, _columns(files, name, table, [f"measured_{i}" for i in range(size)])


def _specified(files: RunFiles, robot: str) -> Robot:
    return next(each for each in files.scenario.robots if each.name == robot)


def _columns(files: RunFiles, name: str, table: Table, keys: Sequence[str]) -> Array:
    for key in keys:
        if key not in table:
            raise RunError(f"{files.folder / name}.csv, line 1: there is no column {key!r}, but: {', '.join(table)}")
    return np.stack([table[key] for key in keys], axis=1)
