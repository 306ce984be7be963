"""Lab 12: cross a field of cylinders to a goal, by a laser. Fill in `free_ahead` and `choose`."""

import math

import numpy as np

import amorsim as am

# Answers to the handout's questions, by their numbers: numbers, or words in quotes.
ANSWERS = {1: None, 2: None, 3: None}

GOAL = (2.25, 8.5)  # [m] in the world
HALF_WIDTH = 0.3  # [m] of the robot, and some room
BEAMS = np.radians(np.arange(-90, 91))  # [rad] of the laser's ranges, to the left above 0
HEADINGS = np.radians(np.arange(-90, 91, 5))  # [rad] that the robot may choose, from where it points


def drive(readings, estimate, clock):
    """The velocities of the robot: ahead [m/s], and turning [rad/s], to the left above 0."""
    x, y, heading = estimate.pose
    away = math.hypot(GOAL[0] - x, GOAL[1] - y)
    if away < 0.2:
        return am.Twist(0.0, 0.0)
    goal = math.remainder(math.atan2(GOAL[1] - y, GOAL[0] - x) - heading, 2.0 * math.pi)
    ranges = np.minimum(np.nan_to_num(readings["laser"].measured, nan=8.0), 8.0)
    chosen = choose([free_ahead(ranges, each) for each in HEADINGS], goal)
    free = free_ahead(ranges, 0.0)
    speed = 0.4 if abs(chosen) < 0.5 and free > 0.5 else 0.0
    return am.Twist(speed, 1.5 * chosen if abs(chosen) > 0.02 else 0.0)


def free_ahead(ranges, heading):
    """How far [m] the robot could drive in a heading [rad] before something is in its way."""
    return ranges[len(ranges) // 2]  # step 2 of the handout goes here: this sees the middle beam alone


def choose(free, goal):
    """The heading [rad], of HEADINGS, to take; `free` [m] is how far each is free, `goal` [rad] where the goal is."""
    return goal  # step 3 of the handout goes here
