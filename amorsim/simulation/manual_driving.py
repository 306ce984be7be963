"""Driving a robot from outside, in all replicas at once."""

from __future__ import annotations

from typing import Any

import numpy as np

from amorsim.array_types import Array
from amorsim.contracts.joints import joints_of
from amorsim.controllers.abilities import command_along
from amorsim.controllers.manual import limited
from amorsim.core.error_text import in_words
from amorsim.core.errors import AmorsimError
from amorsim.core.parameters import LARGEST
from amorsim.core.unknown_names import no_such
from amorsim.simulation.fleet.fleet import Fleet

__all__ = ["drive_all"]


def drive_all(fleet: Fleet, name: str, forward: Any, left: Any, turn: Any) -> None:
    """Set the velocity of the robot `name` in every replica, as `RobotHandle.drive` does in one.

    Raises
    ------
    AmorsimError
        If there is no such robot, it is not driven from outside, or these are not finite numbers for each replica.
    """
    if not isinstance(name, str) or name not in fleet.names:  # an array is not to be compared with names
        raise AmorsimError(no_such("robot", name, fleet.names))
    twists = _twists(name, len(fleet.replicas), forward, left, turn)
    for group in fleet.groups:
        own = group.rows_of(name)
        if not len(own):
            continue
        rows = slice(None) if len(own) == group.rows else own  # no copies of all rows
        driver = group.driver
        by_hand, state = driver.by_hand[rows, 0], driver.state.get("command")
        if state is None and np.count_nonzero(by_hand) < len(by_hand):
            raise AmorsimError(
                f"robot {name!r}: only the 'manual' controller takes commands from outside, and this is "
                f"{type(driver.controller).__name__}; take the robot over with hand_over({name!r}) first"
            )
        wanted = np.zeros((group.rows, 3))
        wanted[rows] = twists[fleet.world.replica_index[group.bodies[rows]]]
        joints = joints_of(group.robot, group.readings)
        along = command_along(group.robot, limited(driver.controller, wanted), joints)[rows]
        for held, takes in ((driver.hand, by_hand), (state, ~by_hand)):
            if np.count_nonzero(takes):
                assert held is not None
                channels = slice(along.shape[1])
                held[rows, channels] = np.where(takes[:, None], along, held[rows, channels])


def _twists(name: str, replicas: int, *parts: Any) -> Array:
    """Forward, left and turn of each replica `(R, 3)`."""
    twists = np.empty((replicas, 3))
    try:
        for column, part in enumerate(parts):
            twists[:, column] = part
        is_fine = np.count_nonzero(np.abs(twists) <= LARGEST) == twists.size
    except (TypeError, ValueError, OverflowError):
        is_fine = False
    if not is_fine:
        raise AmorsimError(
            f"robot {name!r}: expected for forward, left and turn a finite number, or one for each of {replicas} "
            f"replicas, at most {LARGEST:g}; got {in_words(parts)}"
        )
    return twists
