"""Lower bounds on the memory and space that bodies need, checked before they are created."""

from __future__ import annotations

import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Noise
from amorsim.core.arguments import whole
from amorsim.core.error_text import RAISED
from amorsim.core.maps.map import Map
from amorsim.core.rows import stack
from amorsim.scenario.random_start import RandomStart
from amorsim.scenario.spec import MountedSensor, Obstacle, Robot

__all__ = ["least_bytes", "most_room", "samples_under_way"]

_BODY = 1000  # [bytes]
_VALUE = 100  # [bytes]: a sensor's value, true, measured and held, and what its chain works in
_LATE = 1e-9  # of a step: 0.3 s at 0.1 s are three of them, though 0.3 / 0.1 need not be 3
_WAITING = 32  # [bytes]: a value of a sample under way, true and measured, and both once more while a step is made


def samples_under_way(longest: Array, dt: float) -> int:
    """The largest number of samples of a sensor in transit at once, if each takes up to `(N, 1)` [s]."""
    return int(np.ceil(longest / dt - _LATE).max())


def _waiting(unit: MountedSensor, size: int, dt: float) -> int:
    """How much memory the readings of `size` values take that are under way [bytes]."""
    longest = np.array([[unit.latency]])
    for element in unit.noise:
        if type(element.noise).delay is not Noise.delay:
            longest = longest + stack([element.noise]).longest_delay()
    return _WAITING * size * samples_under_way(longest, dt)


def least_bytes(body: Robot | Obstacle, dt: float | None = None) -> int:
    """How much memory a body takes in one replica [bytes]: a little less than was measured of those that ship.

    With the step `dt` [s], its sensors' readings that are under way are counted too.

    Taken for its readings and for itself; what a plugin's estimator or controller keeps is not known.
    """
    if isinstance(body, Obstacle):
        return _BODY
    values = waiting = 0
    for unit in body.sensors.values():
        try:
            size = whole(unit.sensor.size(body.drive), "size()", "a whole number >= 1", least=1)
            late = 0 if dt is None else _waiting(unit, size, dt)
        except RAISED:  # reported where the sensor is made
            continue
        values += size
        waiting += late
    return _BODY + _VALUE * values + waiting


def most_room(world: Map, start: RandomStart, reach: float) -> float:
    """The largest area [m^2] that the footprints of bodies, no larger than `reach`, can cover together."""
    width, height = world.size
    room = width * height
    if start.box is None:
        return room
    left, low, right, high = start.box
    return min(room, (right - left + 2.0 * reach) * (high - low + 2.0 * reach))
