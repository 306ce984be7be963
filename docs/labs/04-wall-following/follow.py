"""Lab 4: follow the wall on the right by sonar. Fill in the turn."""

import amorsim as am

# Answers to the handout's questions, by their numbers: numbers, or words in quotes.
ANSWERS = {1: None, 2: None, 4: None}

SPEED = 0.3  # [m/s]
WANTED = 0.8  # [m] from the robot's middle to the wall


def drive(readings, estimate, clock):
    """The velocities of the robot: ahead [m/s], and turning [rad/s], to the left above 0."""
    sonar = readings["sonar"].measured.clip(max=3.0)
    beside = sonar[7] + 0.136  # [m] to the right of the middle: this sonar looks at -90 degrees
    ahead = min(sonar[2:6])  # [m] between 30 degrees to the left and to the right
    turn = 0.0 * (WANTED - beside)  # step 2 of the handout goes here
    return am.Twist(SPEED if ahead > 0.4 else 0.0, turn)
