"""Lab 2, solved: both slopes, and a draw for each pose and wheel."""

import math

import numpy as np

ANSWERS = {1: 0.0316, 2: "aside", 3: "aside", 4: "a point"}

METRES_PER_COUNT = 2.0 * math.pi * 0.0825 / 39400.0  # of a wheel
TRACK = 0.33  # [m] between the wheels
VARIANCE = 2e-4  # [m^2/m] by which a wheel's travel errs, for each metre of it
PARTICLES = 500


class Estimator:
    """Where the robot may be: a pose with an ellipse around it, and a cloud of poses."""

    def __init__(self, start):
        self.random = np.random.default_rng(1)
        self.counts = None  # of the encoder, left and right
        self.know(np.array(start, dtype=float))

    def know(self, pose):
        """Begin anew where the pose is known exactly."""
        self.pose = pose  # x, y [m], heading [rad]
        self.covariance = np.zeros((3, 3))
        self.cloud = np.tile(pose, (PARTICLES, 1))

    def update(self, readings, command, elapsed):
        counts = readings["encoder"].measured
        if self.counts is not None:
            left, right = (counts - self.counts) * METRES_PER_COUNT
            self.covariance = propagate(self.pose, self.covariance, left, right)
            self.cloud = sample(self.random, self.cloud, left, right)
            self.pose = move(self.pose, left, right)
        self.counts = counts
        if readings["tracker"].fresh:
            self.know(readings["tracker"].measured)
        return self.pose, self.covariance

    def beliefs(self):
        """What the window draws besides the pose and its ellipse."""
        return {"particles": self.cloud, "weights": np.full(PARTICLES, 1.0 / PARTICLES)}


def move(pose, left, right):
    """Poses (..., 3) after the wheels have rolled by `left` and `right` [m], which may be arrays, too."""
    ahead, turn = (left + right) / 2.0, (right - left) / TRACK
    middle = pose[..., 2] + turn / 2.0
    return pose + np.stack(np.broadcast_arrays(ahead * np.cos(middle), ahead * np.sin(middle), turn), axis=-1)


def propagate(pose, covariance, left, right):
    """The covariance (3, 3) of the pose after a step, from that before it."""
    ahead, middle = (left + right) / 2.0, pose[2] + (right - left) / TRACK / 2.0
    c, s = math.cos(middle), math.sin(middle)
    by_pose = np.array([[1.0, 0.0, -ahead * s], [0.0, 1.0, ahead * c], [0.0, 0.0, 1.0]])
    off = ahead / (2.0 * TRACK)
    by_wheels = np.array(
        [[c / 2 + off * s, c / 2 - off * s], [s / 2 - off * c, s / 2 + off * c], [-1 / TRACK, 1 / TRACK]]
    )
    wheels = VARIANCE * np.diag(np.abs([left, right]))
    return by_pose @ covariance @ by_pose.T + by_wheels @ wheels @ by_wheels.T


def sample(random, cloud, left, right):
    """The cloud (n, 3) after a step: each pose moved by a draw of its own of what the wheels may have done."""
    stds = np.sqrt(VARIANCE * np.abs([left, right]))
    drawn = np.array([left, right]) + stds * random.standard_normal((len(cloud), 2))
    return move(cloud, drawn[:, 0], drawn[:, 1])
