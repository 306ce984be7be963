"""Lab 8, solved: free along the beams, occupied at their ends, and each cell once in a scan."""

import math

import numpy as np

ANSWERS = {1: 0.818, 2: 4, 4: 1.15}

SIDE = 0.1  # [m] of a cell
LEFT, LOW = -1.05, -1.05  # [m] where the map begins in the world
ROWS, COLUMNS = 100, 120
LONGEST = 4.0  # [m] of the laser: such a range means that there was no echo
BEARINGS = np.radians(np.arange(181) - 90.0)  # [rad] of the beams, to the left above 0
LASER_AHEAD = 0.017  # [m] of the robot's middle
METRES_PER_COUNT = 2.0 * math.pi * 0.0825 / 39400.0  # of a wheel
TRACK = 0.33  # [m] between the wheels
HIT, MISS, MOST = 1.5, -0.7, 5.0  # log-odds that an echo and a beam that went through add; at most, and at least -MOST
POSES = "tracker"  # or "wheels", which drift


class Estimator:
    """A map of the building, drawn at the poses of a tracker or of the wheels."""

    def __init__(self, start):
        self.log_odds = np.zeros((ROWS, COLUMNS))
        self.reckoned = np.array(start, dtype=float)
        self.counts = None  # of the encoder, left and right
        self.since = 1.0  # [m or rad] driven since the last scan that was added

    def update(self, readings, command, elapsed):
        self.move(readings["encoder"].measured)
        pose = readings["tracker"].measured if POSES == "tracker" else self.reckoned
        if self.since > 0.1:
            self.since = 0.0
            x, y, heading = pose
            ranges = np.nan_to_num(readings["laser"].measured, nan=LONGEST, posinf=LONGEST)
            self.add(x + LASER_AHEAD * math.cos(heading), y + LASER_AHEAD * math.sin(heading), heading, ranges)
        return pose, 1e-6 * np.eye(3)

    def add(self, x, y, heading, ranges):
        """Add a scan of `ranges` (181,) [m], taken by a laser at x, y [m] that looks to `heading` [rad]."""
        echo = ranges < LONGEST
        angle = heading + BEARINGS
        c, s = np.cos(angle), np.sin(angle)
        ends = cells(x + ranges[echo] * c[echo], y + ranges[echo] * s[echo])
        way = np.arange(0.0, LONGEST, SIDE / 2.0)
        before = way < ranges[:, None]  # (beams, places along them)
        along = cells((x + c[:, None] * way)[before], (y + s[:, None] * way)[before])
        flat = self.log_odds.ravel()
        flat[np.setdiff1d(along, ends)] += MISS
        flat[ends] += HIT
        np.clip(self.log_odds, -MOST, MOST, out=self.log_odds)

    def beliefs(self):
        """The map, which the window draws and the rubric judges: probabilities, nan where nothing was seen."""
        occupancy = 1.0 / (1.0 + np.exp(-self.log_odds))
        occupancy[self.log_odds == 0.0] = np.nan
        return {
            "occupancy": occupancy,
            "occupancy_origin": np.array([LEFT, LOW]),
            "occupancy_resolution": np.array(SIDE),
        }

    def move(self, counts):
        """Reckon the pose by the wheels, as in lab 1."""
        if self.counts is not None:
            left, right = (counts - self.counts) * METRES_PER_COUNT
            ahead, turn = (left + right) / 2.0, (right - left) / TRACK
            middle = self.reckoned[2] + turn / 2.0
            self.reckoned += (ahead * math.cos(middle), ahead * math.sin(middle), turn)
            self.since += abs(ahead) + abs(turn)
        self.counts = counts


def cells(x, y):
    """The cells at places x, y [m]: places in `log_odds.ravel()`, each once, and none outside the map."""
    row, column = np.floor((y - LOW) / SIDE).astype(int), np.floor((x - LEFT) / SIDE).astype(int)
    inside = (row >= 0) & (row < ROWS) & (column >= 0) & (column < COLUMNS)
    return np.unique((row * COLUMNS + column)[inside])
