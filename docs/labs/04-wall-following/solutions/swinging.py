"""Lab 4: the classical mistake: the distance alone, with a large gain, so that the robot swings."""

import amorsim as am

SPEED = 0.3  # [m/s]
WANTED = 0.8  # [m] from the robot's middle to the wall


def drive(readings, estimate, clock):
    """The velocities of the robot: ahead [m/s], and turning [rad/s], to the left above 0."""
    sonar = readings["sonar"].measured.clip(max=3.0)
    beside = sonar[7] + 0.136  # at -90 degrees
    ahead = min(sonar[2:6])
    turn = 6.0 * (WANTED - beside)
    if ahead < 1.2:
        turn = max(turn, 0.8 * (1.2 - ahead) / 0.6)
    turn = min(max(turn, -0.6), 0.8)
    return am.Twist(SPEED if ahead > 0.5 else 0.1, turn)
