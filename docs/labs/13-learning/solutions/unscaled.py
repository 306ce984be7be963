"""Lab 13: the classical mistake: ranges in metres, where the policy learned with shares of the longest range."""

import functools
import math
from pathlib import Path

import numpy as np

import amorsim as am

HERE = Path(__file__).parent
GOAL = (2.25, 8.5)  # [m] in the world
SPEED, TURN_RATE = 0.4, 1.0  # [m/s] and [rad/s] of the actions 1
LONGEST, FARTHEST = 8.0, 22.5  # [m] range of the laser, and the distance of the goal that is observed at most


def observe(readings, estimate, last):
    """The goal from where the robot believes to be, the last action, and the ranges in metres."""
    x, y, heading = estimate.pose
    east, north = GOAL[0] - x, GOAL[1] - y
    bearing = math.atan2(north, east) - heading
    goal = (min(math.hypot(east, north), FARTHEST), math.cos(bearing), math.sin(bearing))
    ranges = np.minimum(np.nan_to_num(readings["laser"].measured, nan=LONGEST), LONGEST)
    return np.concatenate((goal, last, ranges))


class Drive:
    """Drives by the policy, ten times a second."""

    def __init__(self):
        self.last = np.zeros(2)

    def command(self, readings, estimate, clock):
        x, y, _ = estimate.pose
        if math.hypot(GOAL[0] - x, GOAL[1] - y) < 0.2:
            return am.Twist(0.0, 0.0)
        self.last = policy()(observe(readings, estimate, self.last))
        return am.Twist(SPEED * self.last[0], TURN_RATE * self.last[1])


@functools.cache
def policy():
    """What was learned: a function from observations to actions, from -1 to 1."""
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    session = onnxruntime.InferenceSession(str(HERE / "policy.onnx"), options, providers=["CPUExecutionProvider"])

    def act(seen):
        (actions,) = session.run(None, {"observation": np.asarray(seen, np.float32)[None]})
        return np.clip(actions[0].astype(float), -1.0, 1.0)

    return act
