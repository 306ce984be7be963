"""The readings that a robot received in a recorded run, for an estimator without the simulator."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from amorsim.analysis.own_columns import own_commands, own_readings
from amorsim.analysis.run_files import RunFiles
from amorsim.array_types import Array
from amorsim.core.errors import AnalysisError
from amorsim.scenario.spec import Robot

__all__ = ["LogEntry", "entries_of_run"]


class LogEntry(NamedTuple):
    """The readings that arrived at one time, as `EstimatorRunner.update` takes them."""

    time: float
    """[s] when it was received."""
    readings: dict[str, Array]
    """By sensor."""
    command: Array | None
    """Given before that time; None before the first."""
    ages: dict[str, float]
    """[s] since each reading was measured."""


def entries_of_run(folder: Path, robot: Robot, replica: int | None) -> Iterator[LogEntry]:
    """An entry for each step of a run: its readings and the command of the step that ended then.

    Raises
    ------
    RunError
        If the folder is not a run's, a file is damaged, or the run has no such robot or replica.
    AnalysisError
        If the run has not written the readings of a sensor that the robot had.
    """
    files = RunFiles(folder)
    commands, given = own_commands(files, robot.name, replica)
    own = next(each for each in files.scenario.robots if each.name == robot.name)
    unwritten = [name for name in robot.sensors if name in own.sensors and name not in files.sensors]
    if unwritten:
        raise AnalysisError(
            f"{folder}: the readings of {', '.join(unwritten)} were not written; to write them, also of more than 32 "
            "replicas, run it again with recording.sensors = 'all', or pass the robot without these sensors"
        )
    times = commands["time"].tolist()
    entries = {
        time: LogEntry(time, {}, command if step else None, {})
        for step, (time, command) in enumerate(zip(times, given, strict=True))
    }
    for name in files.sensors:
        if name not in robot.sensors or name not in own.sensors:
            continue
        table, measured = own_readings(files, robot.name, name, replica)
        for time, stamp, values in zip(table["time"].tolist(), table["stamp"].tolist(), measured, strict=True):
            if time in entries:  # of a run that was killed, the last step may not be whole
                entries[time].readings[name] = values
                entries[time].ages[name] = max(0.0, time - stamp)
    yield from entries.values()
