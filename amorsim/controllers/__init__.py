"""What robots do: commands made of readings and estimates."""

from __future__ import annotations

from amorsim.controllers.goto import GoTo
from amorsim.controllers.manual import Manual
from amorsim.controllers.square import Square
from amorsim.controllers.user import Twist, UserController, WheelSpeeds
from amorsim.controllers.wander import Wander

__all__ = ["GoTo", "Manual", "Square", "Twist", "UserController", "Wander", "WheelSpeeds"]
