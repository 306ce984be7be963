"""Shared by motions: displacements given in the world, bodies that face their way, and the time that one is blocked."""

from __future__ import annotations

import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import State, View
from amorsim.core.poses import wrap_angle
from amorsim.kernels import elementary

__all__ = ["STANDS", "blocked_for", "displacement", "facing"]


STANDS = 1e-12  # [m] a way shorter than this has no direction


def displacement(view: View, dx: Array, dy: Array, turn: Array) -> Array:
    """The displacement `(N, 3)` in each body's own frame of a way in the world (dx, dy) [m] `(N, 1)` and a turn."""
    c, s = np.cos(view.body_pose[:, 2:]), np.sin(view.body_pose[:, 2:])
    return np.concatenate((c * dx + s * dy, c * dy - s * dx, turn), axis=1)


def facing(view: View, dx: Array, dy: Array, most: Array) -> Array:
    """The turn [rad] `(N, 1)`, at most `most`, towards a body's direction of motion.

    A body that was just blocked does not turn: its corners may touch the obstacle.
    """
    goes = (np.abs(dx) + np.abs(dy) > STANDS) & (view.free >= 1.0)
    turn = wrap_angle(elementary.arctan2(dy, dx) - view.body_pose[:, 2:])
    return np.asarray(np.where(goes, np.clip(turn, -most, most), 0.0))


def blocked_for(view: View, dt: float, state: State) -> Array:
    """The time [s] `(N, 1)` for which each has been blocked without a break, kept in ``state["blocked"]``."""
    state["blocked"] = np.where(view.free < 1.0, state["blocked"] + dt, 0.0)
    return state["blocked"]
