from amorsim.controllers.among import Among, Hrvo, HumanLike, Orca, SocialForce
from amorsim.controllers.avoider import Avoider
from amorsim.controllers.braitenberg import Braitenberg
from amorsim.controllers.bugs import Bug2, NearnessDiagram, TangentBug
from amorsim.controllers.dwa import Dwa
from amorsim.controllers.follow import Follow
from amorsim.controllers.goto import GoTo
from amorsim.controllers.headed import Headed, PotentialField, VfhPlus
from amorsim.controllers.manual import Manual
from amorsim.controllers.mppi import Mppi
from amorsim.controllers.navigate import Navigate
from amorsim.controllers.path_pursuit import PathPursuit
from amorsim.controllers.policy import Policy
from amorsim.controllers.pursuit import Pursuit
from amorsim.controllers.square import Square
from amorsim.controllers.user import Twist, UserController, WheelSpeeds
from amorsim.controllers.wall import FollowWall
from amorsim.controllers.wander import Wander

__all__ = [
    "Among",
    "Avoider",
    "Braitenberg",
    "Bug2",
    "Dwa",
    "Follow",
    "FollowWall",
    "GoTo",
    "Headed",
    "Hrvo",
    "HumanLike",
    "Manual",
    "Mppi",
    "Navigate",
    "NearnessDiagram",
    "Orca",
    "PathPursuit",
    "Policy",
    "PotentialField",
    "Pursuit",
    "SocialForce",
    "Square",
    "TangentBug",
    "Twist",
    "UserController",
    "VfhPlus",
    "Wander",
    "WheelSpeeds",
]
