"""Lab 10: graph SLAM. A solution."""

import math

import numpy as np

ANSWERS = {1: 212, 2: 3, 5: "west"}

METRES_PER_COUNT = 2.0 * math.pi * 0.0825 / 39400.0  # of a wheel
TRACK = 0.33  # [m] between the wheels
WHEEL_VARIANCE = 5e-4  # [m^2/m] of each wheel's travel
RANGE_STD, BEARING_STD = 0.05, math.radians(1.0)  # [m, rad] of the sensor
APART = 0.8  # [m] that the wheels roll from one node to the next


class Estimator:
    """Where the robot is: nodes along its path, and the marks that it saw from them."""

    def __init__(self, start):
        self.pose = np.array(start, dtype=float)
        self.counts = None  # of the encoder, left and right
        self.nodes = [self.pose.copy()]  # poses (x, y, heading)
        self.marks = {}  # places (x, y) of the marks, by their numbers
        self.moved = []  # from each node to the next: the displacement (x, y, heading), and the way of the wheels [m]
        self.seen = []  # (node, number of the mark, distance, bearing)
        self.since, self.way = np.zeros(3), 0.0  # from the newest node: displacement, and the way of the wheels

    def update(self, readings, command, elapsed):
        self.move(readings["encoder"].measured)
        if self.way > APART:
            self.nodes.append(compose(self.nodes[-1], self.since))
            self.moved.append((self.since, self.way))
            self.since, self.way = np.zeros(3), 0.0
            self.see(readings["marks"].measured.reshape(-1, 3))
            self.solve()
        elif not self.seen:
            self.see(readings["marks"].measured.reshape(-1, 3))  # from the start
        self.pose = compose(self.nodes[-1], self.since)
        return self.pose, 1e-3 * np.eye(3)

    def see(self, sightings):
        """Keep what is seen from the newest node: rows of distance [m], bearing [rad] and the number of the mark."""
        for distance, bearing, number in sightings:
            if math.isfinite(distance) and number > 0:
                self.seen.append((len(self.nodes) - 1, number, distance, bearing))
                if number not in self.marks:
                    x, y, heading = self.nodes[-1]
                    away = np.array([math.cos(heading + bearing), math.sin(heading + bearing)])
                    self.marks[number] = np.array([x, y]) + distance * away

    def move(self, counts):
        """Add what the wheels have turned to the displacement since the newest node."""
        if self.counts is not None:
            left, right = (counts - self.counts) * METRES_PER_COUNT
            ahead, turn = (left + right) / 2.0, (right - left) / TRACK
            self.since = compose(self.since, (ahead * math.cos(turn / 2.0), ahead * math.sin(turn / 2.0), turn))
            self.way += (abs(left) + abs(right)) / 2.0
        self.counts = counts

    def solve(self):
        """Move the nodes and the marks to where all that was measured fits best; the first node stays."""
        numbers = list(self.marks)
        size = 3 * len(self.nodes) + 2 * len(numbers)
        for _ in range(5):
            h, b = np.zeros((size, size)), np.zeros(size)
            h[:3, :3] += 1e9 * np.eye(3)  # the first node stays where it is
            for i in range(len(self.moved)):
                error, by_first, by_second, weight = self.of_motion(i)
                add(h, b, error, weight, [(3 * i, by_first), (3 * i + 3, by_second)])
            for node, number, distance, bearing in self.seen:
                error, by_node, by_mark, weight = self.of_sight(node, number, distance, bearing)
                place = 3 * len(self.nodes) + 2 * numbers.index(number)
                add(h, b, error, weight, [(3 * node, by_node), (place, by_mark)])
            step = np.linalg.solve(h, -b)
            for i, node in enumerate(self.nodes):
                node += step[3 * i : 3 * i + 3]
            for k, number in enumerate(numbers):
                self.marks[number] += step[3 * len(self.nodes) + 2 * k :][:2]
            if np.abs(step).max() < 1e-4:
                break

    def of_motion(self, i):
        """The error of the motion from node i to the next, its slopes by both, and its weight (information)."""
        measured, way = self.moved[i]
        first, second = self.nodes[i], self.nodes[i + 1]
        c, s = math.cos(first[2]), math.sin(first[2])
        dx, dy = second[0] - first[0], second[1] - first[1]
        there = np.array([c * dx + s * dy, c * dy - s * dx, second[2] - first[2]])
        error = there - measured
        error[2] = math.remainder(error[2], 2.0 * math.pi)
        by_first = np.array([[-c, -s, there[1]], [s, -c, -there[0]], [0.0, 0.0, -1.0]])
        by_second = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        variance = WHEEL_VARIANCE * way
        weight = np.diag([1.0 / (variance / 2.0 + 1e-5), 1.0 / (variance + 1e-5), TRACK**2 / (2.0 * variance)])
        return error, by_first, by_second, weight

    def of_sight(self, node, number, distance, bearing):
        """The error of a mark seen from a node, its slopes by the node and by the mark, and its weight."""
        x, y, heading = self.nodes[node]
        dx, dy = self.marks[number] - (x, y)
        squared = dx * dx + dy * dy
        away = math.sqrt(squared)
        off = math.remainder(math.atan2(dy, dx) - heading - bearing, 2.0 * math.pi)
        by_mark = np.array([[dx / away, dy / away], [-dy / squared, dx / squared]])
        by_node = np.column_stack((-by_mark, [0.0, -1.0]))
        return np.array([away - distance, off]), by_node, by_mark, np.diag([RANGE_STD**-2, BEARING_STD**-2])


def add(h, b, error, weight, slopes):
    """Add an error to the linear system h step = -b: `slopes` are (place of the first unknown, slope) of each part."""
    for row, slope in slopes:
        rows = slice(row, row + slope.shape[1])
        b[rows] += slope.T @ weight @ error
        for column, other in slopes:
            h[rows, column : column + other.shape[1]] += slope.T @ weight @ other


def compose(pose, moved):
    """The pose after a displacement in its own frame."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return np.array([pose[0] + c * moved[0] - s * moved[1], pose[1] + s * moved[0] + c * moved[1], pose[2] + moved[2]])
