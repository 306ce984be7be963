"""An example of a plugin for amorsim, one short file a component. Copy the one that is nearest to what you want."""

from __future__ import annotations

from amorsim_example.beacon import Beacon
from amorsim_example.bounce import Bounce
from amorsim_example.compass_odometry import CompassOdometry
from amorsim_example.course import Course
from amorsim_example.detour import Detour
from amorsim_example.drift import Drift
from amorsim_example.flood import Flood
from amorsim_example.maze import Maze
from amorsim_example.posts import Posts
from amorsim_example.roam import Roam
from amorsim_example.shuttle import Shuttle
from amorsim_example.tally import Tally
from amorsim_example.tricycle import Tricycle

__all__ = [
    "Beacon",
    "Bounce",
    "CompassOdometry",
    "Course",
    "Detour",
    "Drift",
    "Flood",
    "Maze",
    "Posts",
    "Roam",
    "Shuttle",
    "Tally",
    "Tricycle",
]
