"""Controllers: commands computed from readings and estimates."""

from __future__ import annotations

from amorsim.controllers.avoider import Avoider
from amorsim.controllers.braitenberg import Braitenberg
from amorsim.controllers.dwa import Dwa
from amorsim.controllers.follow import Follow
from amorsim.controllers.goto import GoTo
from amorsim.controllers.manual import Manual
from amorsim.controllers.navigate import Navigate
from amorsim.controllers.pursuit import Pursuit
from amorsim.controllers.square import Square
from amorsim.controllers.user import Twist, UserController, WheelSpeeds
from amorsim.controllers.wall import FollowWall
from amorsim.controllers.wander import Wander

__all__ = [
    "Avoider",
    "Braitenberg",
    "Dwa",
    "Follow",
    "FollowWall",
    "GoTo",
    "Manual",
    "Navigate",
    "Pursuit",
    "Square",
    "Twist",
    "UserController",
    "Wander",
    "WheelSpeeds",
]
