"""Response curves given as tables, and the poses of the elements of a ring."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Aim, View
from amorsim.core.parameters import ParameterError
from amorsim.kernels.sensing import readings
from amorsim.sensors.beam_poses import poses_at

__all__ = ["check_table", "ring_poses", "ring_size"]


def check_table(distances: tuple[float, ...], values: tuple[float, ...], names: tuple[str, str]) -> None:
    """Raise `ParameterError` unless the two are columns of one table with increasing distances."""
    if len(values) != len(distances):
        raise ParameterError(
            names[1], f"expected {len(distances)} values, one for each of {names[0]}, got {len(values)}"
        )
    if not distances or any(b <= a for a, b in itertools.pairwise(distances)):
        raise ParameterError(names[0], f"expected one distance at least, each larger than the one before: {distances}")


def ring_size(ring: Any) -> int:
    """Number of elements of a ring: a tuple of mounts, or over rows a table of arrays `(N, k)`."""
    return int(ring.x.shape[1]) if hasattr(ring, "x") else len(ring)


def ring_poses(view: View, ring: Any, aim: Aim) -> Array:
    """World poses `(N * k, 3)` of the elements of a ring, row by row.

    `ring` is a table of mounts over rows: x, y and heading `(N, k)`.
    """
    origins = np.empty((ring.x.size, 3))
    readings.place_ring(view.pose, ring.x, ring.y, ring.heading, origins)
    if aim.bearing is not None:
        origins[:, 2] += aim.bearing.reshape(-1)
    if aim.time is not None:  # each element from where it was when it looked
        origins = poses_at(view.body_pose, view.twist, origins, aim.time)
    return origins
