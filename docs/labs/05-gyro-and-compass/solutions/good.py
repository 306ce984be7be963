"""Lab 5: the heading from a gyro and a compass. A solution."""

import math

import numpy as np

ANSWERS = {1: 12.2, 2: 1.54, 3: "west", 4: 5}

METRES_PER_COUNT = 2.0 * math.pi * 0.0825 / 39400.0  # of a wheel
GYRO_STD = math.radians(5.0)  # [rad/s] of a reading
COMPASS_STD = math.radians(5.0)  # [rad]


class Estimator:
    """The heading and its variance; the place follows from the heading and the wheels."""

    def __init__(self, start):
        self.x, self.y, self.heading = start
        self.variance = 0.0  # [rad^2] of the heading
        self.counts = None  # of the encoder, left and right

    def update(self, readings, command, elapsed):
        self.predict(readings["gyro"].measured[0], elapsed)
        if readings["compass"].fresh:
            self.correct(readings["compass"].measured[0])
        counts = readings["encoder"].measured
        if self.counts is not None:
            ahead = (counts - self.counts).mean() * METRES_PER_COUNT
            self.x += ahead * math.cos(self.heading)
            self.y += ahead * math.sin(self.heading)
        self.counts = counts
        return np.array([self.x, self.y, self.heading])

    def predict(self, rate, elapsed):
        """Turn by what the gyro measured [rad/s]; each reading adds to the variance."""
        self.heading += rate * elapsed
        self.variance += (GYRO_STD * elapsed) ** 2

    def correct(self, compass):
        """Correct the heading by that of the compass [rad]."""
        innovation = math.remainder(compass - self.heading, 2.0 * math.pi)
        gain = self.variance / (self.variance + COMPASS_STD**2)
        self.heading += gain * innovation
        self.variance *= 1.0 - gain
