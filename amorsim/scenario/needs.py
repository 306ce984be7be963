"""What bodies need at the least, of memory and of room; asked before they are made by the million."""

from __future__ import annotations

from amorsim.core.map import Map
from amorsim.core.trouble import RAISED
from amorsim.scenario.spec import Obstacle, RandomStart, Robot

__all__ = ["least_bytes", "most_room"]

_BODY = 1000  # [bytes]
_VALUE = 100  # [bytes]: a sensor's value, true, measured and held, and what its chain works in


def least_bytes(body: Robot | Obstacle) -> int:
    """How much memory a body takes in one replica [bytes]: a little less than was measured of those that ship.

    Taken for its readings and for itself; what a plugin's estimator or controller keeps is not known.
    """
    if isinstance(body, Obstacle):
        return _BODY
    values = 0
    for unit in body.sensors.values():
        try:
            values += unit.sensor.size(body.drive)
        except RAISED:  # said where the sensor is made
            continue
    return _BODY + _VALUE * values


def most_room(world: Map, start: RandomStart, reach: float) -> float:
    """The area [m^2] that the footprints of bodies, no larger than `reach`, can cover together at the most."""
    width, height = world.size
    room = width * height
    if start.box is None:
        return room
    left, low, right, high = start.box
    return min(room, (right - left + 2.0 * reach) * (high - low + 2.0 * reach))
