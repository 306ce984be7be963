"""Lab 12: a solution. The free way of a strip as wide as the robot, and the heading that costs least."""

import math

import numpy as np

import amorsim as am

ANSWERS = {1: 3, 2: 0.052, 3: 0.524}

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
    speed = min(0.4, 0.8 * max(free - 0.3, 0.0)) * max(0.0, math.cos(2.0 * chosen))
    return am.Twist(speed, 1.5 * chosen)


def free_ahead(ranges, heading):
    """How far [m] the robot could drive in a heading [rad] before something is in its way."""
    along = ranges * np.cos(BEAMS - heading)
    aside = np.abs(ranges * np.sin(BEAMS - heading))
    in_the_way = (along > 0.0) & (aside < HALF_WIDTH)
    return along[in_the_way].min(initial=8.0)


def choose(free, goal):
    """The heading [rad], of HEADINGS, to take; `free` [m] is how far each is free, `goal` [rad] where the goal is."""
    ahead = np.minimum(free, 2.0)
    off = np.abs(np.array([math.remainder(each - goal, 2.0 * math.pi) for each in HEADINGS]))
    return HEADINGS[np.argmin(0.6 * off + 0.4 * np.abs(HEADINGS) + 1.5 * (2.0 - ahead))]
