"""Lab 1: odometry. Fill in `move`, then put in what you have measured."""

import math

import numpy as np

# Answers to the handout's questions, by their numbers: numbers, or words in quotes.
ANSWERS = {1: None, 2: None, 3: None}

COUNTS_PER_TURN = 39400.0  # of a wheel's encoder
RADIUS_LEFT, RADIUS_RIGHT = 0.0825, 0.0825  # [m] of the wheels, by the data sheet
TRACK = 0.33  # [m] between the wheels, by the data sheet


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
        # Step 2 of the handout goes here. Until then the robot believes that it never moves.
