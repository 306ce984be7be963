"""Places where a robot was put elsewhere in the middle of an episode, which it did not drive."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Episode

__all__ = ["Jump", "before_steps", "jumps"]


_KINDS = ("pose_set", "kidnapped")


class Jump(NamedTuple):
    """A robot that was put elsewhere: the last time before it, the row, and the pose (x [m], y [m], heading [rad])."""

    place: int  # in `Episode.time`: there the robot is still where it was, and one step later it has left `pose`
    row: int
    pose: Any


def jumps(episode: Episode) -> list[Jump]:
    """All jumps of an episode, in order; those after its last step are left out."""
    rows = {replica: row for row, replica in enumerate(episode.replicas)}
    found = []
    for event in episode.events:
        if event.kind in _KINDS and len(episode.time) > 1:
            # Not by the length of a step: in files it is rounded, which adds up to whole steps in half an hour.
            place = int(np.abs(episode.time - event.time).argmin())
            if place < len(episode.time) - 1:
                found.append(Jump(place, rows[event.replica], event.value))
    return found


def before_steps(episode: Episode) -> Array:
    """The true poses `(S - 1, R, 3)` from which each step began; after a jump, the pose it led to."""
    poses = episode.kept["true_pose"][:-1].copy()
    for jump in jumps(episode):
        poses[jump.place, jump.row] = jump.pose
    return poses
