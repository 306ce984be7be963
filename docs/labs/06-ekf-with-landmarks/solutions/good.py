"""Lab 6: an extended Kalman filter with landmarks. A solution."""

import math

import numpy as np

ANSWERS = {1: 8.5, 2: 6.28, 3: "across", 4: "consistent", 5: "up"}

LANDMARKS = {1: (5.0, 0.3), 2: (9.7, 4.0), 3: (5.0, 7.7), 4: (0.3, 4.0)}  # [m] by their numbers
METRES_PER_COUNT = 2.0 * math.pi * 0.0825 / 39400.0  # of a wheel
TRACK = 0.33  # [m] between the wheels
WHEEL_VARIANCE = 5e-5  # [m^2/m] of each wheel's travel
RANGE_STD, BEARING_STD = 0.05, math.radians(1.0)  # [m, rad] of the sensor


class Estimator:
    """Where the robot is: a pose (x, y, heading) and its covariance."""

    def __init__(self, start):
        self.pose = np.array(start, dtype=float)
        self.covariance = np.zeros((3, 3))
        self.counts = None  # of the encoder, left and right

    def update(self, readings, command, elapsed):
        self.predict(readings["encoder"].measured)
        if readings["marks"].fresh:
            for distance, bearing, number in readings["marks"].measured.reshape(-1, 3):
                if number in LANDMARKS:
                    self.correct(LANDMARKS[number], distance, bearing)
        return self.pose, self.covariance

    def predict(self, counts):
        """Move the pose by what the wheels have turned, and let the covariance grow."""
        if self.counts is not None:
            left, right = (counts - self.counts) * METRES_PER_COUNT
            ahead, turn = (left + right) / 2.0, (right - left) / TRACK
            middle = self.pose[2] + turn / 2.0
            c, s = math.cos(middle), math.sin(middle)
            by_pose = np.array([[1.0, 0.0, -ahead * s], [0.0, 1.0, ahead * c], [0.0, 0.0, 1.0]])
            aside = ahead / (2.0 * TRACK)
            by_wheels = np.array(
                [
                    [c / 2.0 + aside * s, c / 2.0 - aside * s],
                    [s / 2.0 - aside * c, s / 2.0 + aside * c],
                    [-1.0 / TRACK, 1.0 / TRACK],
                ]
            )
            noise = WHEEL_VARIANCE * np.diag([abs(left), abs(right)])
            self.pose += (ahead * c, ahead * s, turn)
            self.covariance = by_pose @ self.covariance @ by_pose.T + by_wheels @ noise @ by_wheels.T
        self.counts = counts

    def correct(self, landmark, distance, bearing):
        """Correct the pose by the distance [m] and bearing [rad] of a landmark at a known place."""
        dx, dy = landmark[0] - self.pose[0], landmark[1] - self.pose[1]
        squared = dx * dx + dy * dy
        expected = np.array([math.sqrt(squared), math.atan2(dy, dx) - self.pose[2]])
        innovation = np.array([distance, bearing]) - expected
        innovation[1] = math.remainder(innovation[1], 2.0 * math.pi)
        slope = np.array([[-dx / expected[0], -dy / expected[0], 0.0], [dy / squared, -dx / squared, -1.0]])
        spread = slope @ self.covariance @ slope.T + np.diag([RANGE_STD**2, BEARING_STD**2])
        gain = self.covariance @ slope.T @ np.linalg.inv(spread)
        self.pose += gain @ innovation
        self.covariance -= gain @ spread @ gain.T
