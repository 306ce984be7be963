"""Lab 3: sensors. Put the gyro right in `turn_rate`."""

import math

import numpy as np

# Answers to the handout's questions, by their numbers: numbers, or words in quotes.
ANSWERS = {1: None, 2: None, 3: None, 4: None}

METRES_PER_COUNT = 2.0 * math.pi * 0.0825 / 39400.0  # of a wheel


class Estimator:
    """Where the robot is: a pose (x, y, heading), its way by the wheels and its heading by the gyro."""

    def __init__(self, start):
        self.pose = np.array(start, dtype=float)
        self.counts = None  # of the encoder, left and right

    def update(self, readings, command, elapsed):
        counts = readings["encoder"].measured
        if self.counts is not None:
            ahead = (counts - self.counts).mean() * METRES_PER_COUNT
            turn = self.turn_rate(readings["gyro"].measured[0]) * elapsed
            middle = self.pose[2] + turn / 2.0
            self.pose += (ahead * math.cos(middle), ahead * math.sin(middle), turn)
        self.counts = counts
        return self.pose, 1e-3 * np.eye(3)

    def turn_rate(self, measured):
        """The turn rate [rad/s] of the robot, of what the gyro has measured [rad/s]."""
        # Step 3 of the handout goes here. Until then the gyro is believed.
        return measured
