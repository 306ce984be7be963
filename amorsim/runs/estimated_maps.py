"""The maps that a run's robots drew, as files for ROS."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from amorsim.contracts import Frame
from amorsim.core.errors import AmorsimError
from amorsim.core.maps.estimated_map import estimated_map
from amorsim.core.maps.map import Map
from amorsim.scenario.files.maps import save_map
from amorsim.simulation.simulation import Simulation

__all__ = ["write_estimated_maps"]

FOLDER = "estimated-maps"
_MOST_ROBOTS = 64  # in all replicas: beliefs are of all of them at once


def write_estimated_maps(simulation: Simulation, folder: Path) -> None:
    """Write ``estimated-maps/ROBOT-ESTIMATOR.yaml`` and its picture for each map in the first replica, if any.

    There are none of groups of more than 64 robots, and none after a run that broke off in the middle of a step: what
    was believed then is gone.
    """
    for frame in simulation.frames():
        if len(frame.names) > _MOST_ROBOTS:
            continue
        for name, found in _maps(frame, int(simulation.replicas[0])):
            (folder / FOLDER).mkdir(exist_ok=True)
            save_map(found, folder / FOLDER / f"{name}.yaml")


def _maps(frame: Frame, replica: int) -> Iterator[tuple[str, Map]]:
    """The maps of a replica's robots in a frame, by robot and estimator."""
    rows = [row for row in range(len(frame.names)) if int(frame.replica[row]) == replica]
    for estimator in frame.beliefs:
        try:
            beliefs = frame.beliefs[estimator]
        except AmorsimError:  # looked up after its step
            continue
        if "occupancy" in beliefs:
            for row in rows:
                yield f"{frame.names[row]}-{estimator}", estimated_map(beliefs, row, name=estimator)
