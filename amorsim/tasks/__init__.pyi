from amorsim.tasks.follow_leader import FollowLeader
from amorsim.tasks.follow_line import FollowLine
from amorsim.tasks.park import Park
from amorsim.tasks.point_goal import PointGoal

__all__ = ["FollowLeader", "FollowLine", "Park", "PointGoal"]
