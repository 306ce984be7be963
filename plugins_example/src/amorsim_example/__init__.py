"""An example of a plugin for amorsim, one short file a component. Copy the one that is nearest to what you want."""

from __future__ import annotations

from amorsim_example.beacon import Beacon
from amorsim_example.compass_odometry import CompassOdometry
from amorsim_example.detour import Detour
from amorsim_example.drift import Drift
from amorsim_example.maze import Maze
from amorsim_example.tally import Tally
from amorsim_example.tricycle import Tricycle

__all__ = ["Beacon", "CompassOdometry", "Detour", "Drift", "Maze", "Tally", "Tricycle"]
