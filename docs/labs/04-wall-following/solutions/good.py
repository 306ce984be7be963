"""Lab 4: a solution. Distance and angle of the wall from two sonars; a turn to the left before a wall ahead."""

import math

import amorsim as am

ANSWERS = {1: 0.5, 2: 0.98, 4: "smooth"}

SPEED = 0.3  # [m/s]
WANTED = 0.8  # [m] from the robot's middle to the wall


def drive(readings, estimate, clock):
    """The velocities of the robot: ahead [m/s], and turning [rad/s], to the left above 0."""
    sonar = readings["sonar"].measured.clip(max=3.0)
    beside = sonar[7] + 0.136  # at -90 degrees
    before = 0.119 + sonar[6] * math.sin(math.radians(50.0))  # the same, of the one at -50 degrees
    along = 0.045 + sonar[6] * math.cos(math.radians(50.0))
    angle = math.atan2(before - beside, along)  # of the wall, as seen from the robot
    ahead = min(sonar[2:6])
    turn = 0.8 * (WANTED - beside) - 1.0 * angle
    if ahead < 1.2:
        turn = max(turn, 0.8 * (1.2 - ahead) / 0.6)
    turn = min(max(turn, -0.6), 0.8)
    return am.Twist(SPEED if ahead > 0.5 else 0.1, turn)
