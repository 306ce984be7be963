"""Short experiments for the Editor: errors on a square, the scatter of readings, random starts."""

from __future__ import annotations

from typing import Any

import numpy as np

from amorsim.array_types import Array
from amorsim.core.errors import AmorsimError
from amorsim.scenario.reading.partial import Partial
from amorsim.scenario.spec import Robot, Scenario
from amorsim.simulation.fleet.starting import drawn_starts
from amorsim.studies.preview import preview_noise, preview_square

__all__ = ["noise_bars", "square_paths", "starts_by_name"]


SIDE, REPLICAS = 10.0, 20  # m
MOST_POINTS = 120  # of a path
BARS = 31


def square_paths(scenario: Scenario, name: str) -> dict[str, Any]:
    """The estimates of twenty replicas on a square of 10 m, and where they really end."""
    found = preview_square(scenario, _robot(scenario, name), side=SIDE, replicas=REPLICAS)
    step = max(1, found.estimated.shape[1] // MOST_POINTS)
    ends = found.ends
    far = np.hypot(ends[:, 0], ends[:, 1])
    return {
        "side": SIDE,
        "true": [_thinned(path, step) for path in found.true],
        "estimated": [_thinned(path, step) for path in found.estimated],
        "ends": ends.round(4).tolist(),
        "mean": float(far.mean()),
        "most": float(far.max()),
    }


def _thinned(path: Array, step: int) -> list[list[float]]:
    return [*path[::step].round(4).tolist(), path[-1].round(4).tolist()]


def noise_bars(scenario: Scenario, name: str, sensor: str) -> dict[str, Any]:
    """A histogram of a sensor's errors: edges and counts of its bars, mean and standard deviation."""
    errors = preview_noise(scenario, name, sensor)
    if not errors.size:
        raise AmorsimError("it reads nothing where it stands")
    unit = _robot(scenario, name).sensors[sensor].sensor.unit
    low, high = np.quantile(errors, (0.002, 0.998)).tolist()
    if high - low < 1e-12:
        low, high = low - 0.5e-3, high + 0.5e-3
    counts, edges = np.histogram(np.clip(errors, low, high), bins=BARS, range=(low, high))
    return {
        "unit": unit,
        "edges": edges.tolist(),
        "counts": counts.tolist(),
        "of": int(errors.size),
        "mean": float(errors.mean()),
        "std": float(errors.std()),
    }


def starts_by_name(partial: Partial) -> dict[str, list[float]]:
    """Where a run would let those start that are placed at random: x, y [m] and heading [rad]. No program is run.

    Raises
    ------
    AmorsimError
        If it has faults, or some find no place.
    """
    if partial.faults or partial.map is None:
        raise AmorsimError("it has faults; mend them first")
    return drawn_starts(partial, partial.map, partial.seed)


def _robot(scenario: Scenario, name: str) -> Robot:
    for robot in scenario.robots:
        if robot.name == name:
            return robot
    raise AmorsimError(f"there is no robot {name!r}")
