"""A controller: what one robot does, step by step, from what it measured and believes. It never sees the truth."""

import amorsim as am


def drive(readings, estimate, clock, speed=0.3):
    """Drive straight on; turn away to the freer side where something is near ahead."""
    ranges = readings["laser"].measured  # [m], 181 beams from right to left
    right, ahead, left = ranges[:60].min(), ranges[50:131].min(), ranges[121:].min()
    if ahead > 0.8:
        return am.Twist(speed, 0.0)  # [m/s] forward, [rad/s] anticlockwise
    return am.Twist(0.0, 0.8 if left > right else -0.8)
