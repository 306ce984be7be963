"""How obstacles move: along routes, at random, as recorded, on timetables, as people walk."""

from __future__ import annotations

from amorsim.motions.doors import SlidingDoor, SwingDoor
from amorsim.motions.routes import Loop, Oscillate, Waypoints
from amorsim.motions.wander import Wander

__all__ = ["Loop", "Oscillate", "SlidingDoor", "SwingDoor", "Wander", "Waypoints"]
