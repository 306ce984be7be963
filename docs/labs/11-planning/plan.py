"""Lab 11: planning. Fill in `find_path`."""

import math

import numpy as np

import amorsim as am

# Answers to the handout's questions, by their numbers: numbers, or words in quotes.
ANSWERS = {2: None, 3: None, 4: None, 5: None}

# The walls of the house (x1, y1, x2, y2) [m].
WALLS = np.array(
    [
        (0, 0, 14, 0), (14, 0, 14, 10), (14, 10, 0, 10), (0, 10, 0, 0),
        (4, 0, 4, 3.5), (4, 5, 4, 10), (0, 6, 2.5, 6),
        (5.4, 1.5, 7.6, 1.5), (7.6, 1.5, 7.6, 6.4), (7.6, 6.4, 5.4, 6.4), (7, 8, 7, 10),
        (9, 0, 9, 5.5), (9, 7, 9, 10),
        (11, 1.4, 11, 4), (11, 4, 14, 4), (10.5, 5.5, 12.5, 5.5), (10.5, 5.5, 10.5, 8),
    ],
    dtype=float,
)  # fmt: skip
SIDE = 0.1  # [m] of a cell
ROWS, COLUMNS = 100, 140
RADIUS = 0.36  # [m] of the robot, and a little room
GOAL = (12.5, 2.5)  # [m] in the world
AHEAD = 0.4  # [m] on the path of the place that it drives to
NEIGHBOURS = [(0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1)]  # (rows, columns) from a cell


class Driver:
    """Plans a way at the start, and drives along it."""

    def __init__(self):
        self.path = None  # places (n, 2) [m]

    def command(self, readings, estimate, clock):
        x, y, heading = estimate.pose
        if self.path is None:
            cells = find_path(free_cells(), cell_at(x, y), cell_at(*GOAL))
            self.path = np.array([*((column + 0.5, row + 0.5) for row, column in cells)]) * SIDE
        away = np.hypot(*(self.path - (x, y)).T)
        self.path = self.path[np.argmin(away) :]  # what lies behind is done
        if math.hypot(GOAL[0] - x, GOAL[1] - y) < 0.1:
            return am.Twist(0.0, 0.0)
        there = self.path[min(int(AHEAD / SIDE), len(self.path) - 1)]
        turn = math.remainder(math.atan2(there[1] - y, there[0] - x) - heading, 2.0 * math.pi)
        return am.Twist(0.5 if abs(turn) < 0.5 else 0.0, 2.0 * turn)


def find_path(free, start, goal):
    """The cells (row, column) of a shortest path over `free` cells (ROWS, COLUMNS), from `start` to `goal`."""
    # Steps 2 and 3 of the handout go here. Until then it drives straight on.
    return [start, goal]


def free_cells():
    """Which cells (ROWS, COLUMNS) the robot's middle may be in: those that are far enough from each wall."""
    rows, columns = np.mgrid[:ROWS, :COLUMNS]
    x, y = (columns + 0.5) * SIDE, (rows + 0.5) * SIDE
    free = np.ones((ROWS, COLUMNS), dtype=bool)
    for x1, y1, x2, y2 in WALLS:
        along = ((x - x1) * (x2 - x1) + (y - y1) * (y2 - y1)) / ((x2 - x1) ** 2 + (y2 - y1) ** 2)
        along = np.clip(along, 0.0, 1.0)
        free &= np.hypot(x - x1 - along * (x2 - x1), y - y1 - along * (y2 - y1)) > RADIUS
    return free


def cell_at(x, y):
    """The cell (row, column) at a place [m]."""
    return int(y / SIDE), int(x / SIDE)
