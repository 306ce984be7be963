"""A controller that pushes on, whatever is ahead."""

import amorsim as am


def push(readings, estimate, clock, forward=0.3, turn=0.0):
    """The same velocity for ever, but for a halt after two seconds."""
    return None if 2.0 <= clock.time < 2.3 else am.Twist(forward, turn)
