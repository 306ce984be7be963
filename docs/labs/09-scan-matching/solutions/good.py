"""Lab 9: scan matching. A solution."""

import math

import numpy as np

ANSWERS = {2: "larger", 3: "along", 4: "lines"}

BEARINGS = np.radians(np.arange(181) - 90.0)  # [rad] of the beams, to the left above 0
LONGEST = 8.0  # [m] of the laser
LASER_AHEAD = 0.017, 0.008  # [m] of the robot's middle, and to the left of it
METRES_PER_COUNT = 2.0 * math.pi * 0.0825 / 39400.0  # of a wheel
TRACK = 0.33  # [m] between the wheels
NEAR = 0.3  # [m] that a point and its partner may be apart


class Estimator:
    """Where the robot is: a pose (x, y, heading), by wheels and scans."""

    def __init__(self, start):
        self.pose = np.array(start, dtype=float)
        self.counts = None  # of the encoder, left and right
        self.since = 0.0  # [m or rad] driven since the last scan that was matched
        self.key = None  # the key scan: where it was taken, its points (n, 2) and their normals (n, 2)

    def update(self, readings, command, elapsed):
        self.move(readings["encoder"].measured)
        if self.key is None or self.since > 0.1:
            self.since = 0.0
            points = points_of(readings["laser"].measured)
            if self.key is not None:
                there, known, normals = self.key
                guess = relative(there, self.pose)
                self.pose = compose(there, self.align(points, known, normals, guess))
            if self.key is None or far(relative(self.key[0], self.pose)):
                self.key = self.pose.copy(), points, normals_of(points)
        return self.pose, 1e-3 * np.eye(3)

    def move(self, counts):
        """Move the pose by what the wheels have turned."""
        if self.counts is not None:
            left, right = (counts - self.counts) * METRES_PER_COUNT
            ahead, turn = (left + right) / 2.0, (right - left) / TRACK
            self.pose = compose(self.pose, (ahead * math.cos(turn / 2.0), ahead * math.sin(turn / 2.0), turn))
            self.since += abs(ahead) + abs(turn)
        self.counts = counts

    def align(self, points, known, normals, guess):
        """The pose from which `points` (m, 2) lie on the lines through `known` (n, 2), near `guess`: x, y, heading."""
        x, y, heading = guess
        for _ in range(20):
            c, s = math.cos(heading), math.sin(heading)
            moved = points @ np.array([[c, s], [-s, c]]) + (x, y)
            apart = np.hypot(*np.moveaxis(moved[:, None] - known, 2, 0))
            partner = apart.argmin(axis=1)
            taken = (apart.min(axis=1) < NEAR) & np.isfinite(normals[partner, 0])
            if taken.sum() < 10:
                break
            p, q, n = moved[taken], known[partner[taken]], normals[partner[taken]]
            off = ((q - p) * n).sum(axis=1)
            about = p - (x, y)
            slope = np.column_stack((n, about[:, 0] * n[:, 1] - about[:, 1] * n[:, 0]))
            step = np.linalg.lstsq(slope, off, rcond=1e-6)[0]
            x, y, heading = x + step[0], y + step[1], heading + step[2]
            if np.abs(step).max() < 1e-5:
                break
        return np.array([x, y, heading])


def points_of(ranges):
    """The points (n, 2) [m] that a scan has seen, from the robot."""
    seen = np.isfinite(ranges) & (ranges < LONGEST)
    x = LASER_AHEAD[0] + ranges[seen] * np.cos(BEARINGS[seen])
    y = LASER_AHEAD[1] + ranges[seen] * np.sin(BEARINGS[seen])
    return np.column_stack((x, y))


def normals_of(points):
    """The unit vectors (n, 2) across the wall at each point; nan where its neighbours are on no line with it."""
    before, after = np.roll(points, 1, axis=0), np.roll(points, -1, axis=0)
    along = after - before
    length = np.hypot(*along.T)
    normals = np.column_stack((-along[:, 1], along[:, 0])) / np.maximum(length, 1e-9)[:, None]
    off = np.abs(((points - before) * normals).sum(axis=1))
    normals[(length > 1.0) | (off > 0.05)] = np.nan
    return normals


def far(moved):
    """Whether a robot has moved so far from a key scan that it needs another one."""
    return math.hypot(moved[0], moved[1]) > 1.0 or abs(moved[2]) > math.radians(30.0)


def compose(pose, moved):
    """The pose after a displacement in its own frame."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return np.array([pose[0] + c * moved[0] - s * moved[1], pose[1] + s * moved[0] + c * moved[1], pose[2] + moved[2]])


def relative(pose, other):
    """Another pose in the frame of a pose."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    dx, dy = other[0] - pose[0], other[1] - pose[1]
    return np.array([c * dx + s * dy, c * dy - s * dx, math.remainder(other[2] - pose[2], 2.0 * math.pi)])
