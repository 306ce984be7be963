"""Lab 1: odometry. A solution, with what five squares in each direction have shown."""

import math

import numpy as np

ANSWERS = {1: 0.0283, 2: 0.23, 3: 0.3402}

COUNTS_PER_TURN = 39400.0  # of a wheel's encoder
ED, EB = 0.9986, 1.02  # the right wheel to the left one, and the track to that of the data sheet, by UMBmark
RADIUS_LEFT, RADIUS_RIGHT = 0.0825 * 2.0 / (ED + 1.0), 0.0825 * 2.0 / (1.0 / ED + 1.0)  # [m]
TRACK = 0.33 * EB  # [m] between the wheels


class Estimator:
    """Where the robot is: a pose (x, y, heading), by the wheels alone."""

    def __init__(self, start):
        self.pose = np.array(start, dtype=float)
        self.counts = None  # of the encoder, left and right

    def update(self, readings, command, elapsed):
        counts = readings["encoder"].measured
        if self.counts is not None:
            left, right = 2.0 * math.pi * (counts - self.counts) / COUNTS_PER_TURN
            self.move(RADIUS_LEFT * left, RADIUS_RIGHT * right)
        self.counts = counts
        return self.pose, 1e-4 * np.eye(3)

    def move(self, left, right):
        """Move the pose by the ways [m] that the left and the right wheel have rolled."""
        ahead, turn = (left + right) / 2.0, (right - left) / TRACK
        middle = self.pose[2] + turn / 2.0
        self.pose += (ahead * math.cos(middle), ahead * math.sin(middle), turn)
