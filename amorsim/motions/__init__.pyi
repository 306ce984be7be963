from amorsim.motions.doors import SlidingDoor, SwingDoor
from amorsim.motions.pedestrian import Pedestrian
from amorsim.motions.routes import Loop, Oscillate, Waypoints
from amorsim.motions.track import Track
from amorsim.motions.user import ObstacleState, UserMotion
from amorsim.motions.wander import Wander

__all__ = [
    "Loop",
    "ObstacleState",
    "Oscillate",
    "Pedestrian",
    "SlidingDoor",
    "SwingDoor",
    "Track",
    "UserMotion",
    "Wander",
    "Waypoints",
]
