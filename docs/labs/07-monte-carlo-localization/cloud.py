"""Lab 7: Monte Carlo localization. Fill in `weigh` and `resample`."""

import math

import numpy as np

# Answers to the handout's questions, by their numbers: numbers, or words in quotes.
ANSWERS = {1: None, 2: None, 3: None}

# The walls of the building (x1, y1, x2, y2) [m].
WALLS = np.array(
    [
        (0, 0, 10, 0), (10, 0, 10, 6), (10, 6, 7, 6), (7, 6, 7, 8), (7, 8, 0, 8), (0, 8, 0, 0),
        (0, 5, 1.5, 5), (3, 5, 4.5, 5), (4.5, 5, 4.5, 6.5), (6.5, 0, 6.5, 1.8), (6.5, 3, 6.5, 4.2),
        (8.5, 2.5, 9.2, 2.5), (9.2, 2.5, 9.2, 3.2), (9.2, 3.2, 8.5, 3.2), (8.5, 3.2, 8.5, 2.5),
    ],
    dtype=float,
)  # fmt: skip
LONGEST = 8.0  # [m] of the laser
TAKEN = np.arange(0, 181, 10)  # the beams that are used: every tenth
BEARINGS = np.radians(TAKEN - 90.0)  # [rad] of these, to the left above 0
LASER_AHEAD = 0.017  # [m] of the robot's middle
METRES_PER_COUNT = 2.0 * math.pi * 0.0825 / 39400.0  # of a wheel
TRACK = 0.33  # [m] between the wheels
FIRST, PARTICLES = 20_000, 2_000  # how many there are at first, and once they were drawn anew


class Estimator:
    """Where the robot is: a pose (x, y, heading) and its covariance."""

    def __init__(self, start):
        self.random = np.random.default_rng(1)
        self.particles = self.random.uniform((0.3, 0.3, -math.pi), (9.7, 7.7, math.pi), (FIRST, 3))
        self.weights = np.full(FIRST, 1.0 / FIRST)
        self.counts = None  # of the encoder, left and right
        self.since = 0.0  # [m or rad] driven since the last scan that was used

    def update(self, readings, command, elapsed):
        self.move(readings["encoder"].measured)
        if self.since > 0.1:
            self.since = 0.0
            ranges = np.nan_to_num(readings["laser"].measured[TAKEN], nan=LONGEST, posinf=LONGEST)
            self.weigh(np.minimum(ranges, LONGEST))
            self.resample()
        return self.mean()

    def beliefs(self):
        """The cloud, for the window to draw."""
        return {"particles": self.particles, "weights": self.weights}

    def move(self, counts):
        """Move each particle by what the wheels have turned, and by a draw of what they may have erred."""
        if self.counts is not None:
            travel = (counts - self.counts) * METRES_PER_COUNT
            travel = travel + self.random.normal(0.0, np.sqrt(1e-3 * np.abs(travel)), (len(self.particles), 2))
            ahead, turn = travel.mean(axis=1), (travel[:, 1] - travel[:, 0]) / TRACK
            middle = self.particles[:, 2] + turn / 2.0
            self.particles += np.column_stack((ahead * np.cos(middle), ahead * np.sin(middle), turn))
            self.since += abs(ahead.mean()) + abs(turn.mean())
        self.counts = counts

    def weigh(self, measured):
        """Give particles whose expected ranges fit the `measured` ones (beams,) more weight."""
        # Step 2 of the handout goes here: `expected_ranges(self.particles)` has a row for each particle.

    def resample(self):
        """Draw PARTICLES of the particles anew, each as often as its weight says."""
        # Step 3 of the handout goes here.

    def mean(self):
        """The mean pose, and the covariance of the cloud."""
        x, y = self.weights @ self.particles[:, :2]
        c, s = self.weights @ np.cos(self.particles[:, 2]), self.weights @ np.sin(self.particles[:, 2])
        off = self.particles - (x, y, math.atan2(s, c))
        off[:, 2] = np.arctan2(np.sin(off[:, 2]), np.cos(off[:, 2]))
        return np.array([x, y, math.atan2(s, c)]), (off.T * self.weights) @ off + 1e-9 * np.eye(3)


def expected_ranges(poses):
    """What the laser would measure from poses (n, 3): ranges (n, beams) [m], by the map."""
    angles = poses[:, 2:3] + BEARINGS
    dx, dy = np.cos(angles), np.sin(angles)
    x = (poses[:, 0] + LASER_AHEAD * np.cos(poses[:, 2]))[:, None]
    y = (poses[:, 1] + LASER_AHEAD * np.sin(poses[:, 2]))[:, None]
    ranges = np.full(angles.shape, LONGEST)
    for x1, y1, x2, y2 in WALLS:
        with np.errstate(divide="ignore", invalid="ignore"):
            across = dx * (y2 - y1) - dy * (x2 - x1)
            away = ((x1 - x) * (y2 - y1) - (y1 - y) * (x2 - x1)) / across  # along the beam
            along = ((x1 - x) * dy - (y1 - y) * dx) / across  # along the wall, from 0 to 1
        hit = (away > 0.0) & (along >= 0.0) & (along <= 1.0) & (away < ranges)
        ranges = np.where(hit, away, ranges)
    return ranges
