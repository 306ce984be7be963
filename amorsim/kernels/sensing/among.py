"""Sensing among other bodies in one call: look at the walls, meet bodies, read."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.collision.body_hash import BodyHash
from amorsim.kernels.collision.footprints import Bodies
from amorsim.kernels.compile import kernel
from amorsim.kernels.raycast.body_rays import cast_bodies
from amorsim.kernels.sensing.together import LIMITS, Layout, sense

__all__ = ["FINDER_COLUMNS", "sense_among"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Of a range finder: how many values and places there are of the devices before it; how many places it looks from; how
# many values it has; where its beams begin, and how many they are.
_VALUES, _PLACES, _FROM, _SIZE, _BEAMS, _RAYS = range(6)
FINDER_COLUMNS = 6


@kernel
def sense_among(
    first: int,
    end: int,
    body: Floats,
    twist: Floats,
    joints: Floats,
    layout: Layout,
    counter: NDArray[np.uint32],
    true: Floats,
    measured: Floats,
    bodies: Bodies,
    body_pose: Floats,
    edge_rows: int,
    by_place: BodyHash,
    widest: float,
    finders: Ints,
    own: Ints,
    replica: Ints,
    cos_b: Floats,
    sin_b: Floats,
) -> None:
    """What `sensing.sense` does, with other bodies between the range finders and the walls.

    Parameters
    ----------
    first, ..., measured
        As `sense` takes them.
    bodies, body_pose, edge_rows, by_place, widest
        As `cast_bodies` takes them.
    finders
        (F, FINDER_COLUMNS), the range finders.
    own, replica
        (L * N,): of each place that is looked from, the body that it is on, and the replica.
    cos_b, sin_b
        Of the finders' beams, one device after another, as `cast_bodies` takes them.
    """
    rows = body.shape[0]
    limits = layout.floats[layout.ints[LIMITS] : layout.ints[LIMITS + 1]]
    nobody_asks = np.empty((0, 0), dtype=np.int64)
    sense(first, end, True, False, body, twist, joints, layout, counter, true, measured)
    for f in range(finders.shape[0]):
        per_row = finders[f, _FROM]
        size = finders[f, _SIZE]
        rays = finders[f, _RAYS]
        beams = finders[f, _BEAMS]
        at = finders[f, _PLACES] * rows
        begin = at + first * per_row
        stop = at + end * per_row
        at = finders[f, _VALUES] * rows
        cast_bodies(
            bodies,
            body_pose,
            edge_rows,
            by_place,
            widest,
            replica[begin:stop],
            own[begin:stop],
            layout.places[begin:stop],
            cos_b[beams : beams + rays].reshape((1, rays)),
            sin_b[beams : beams + rays].reshape((1, rays)),
            limits[begin:stop],
            true[at + first * size : at + end * size].reshape((stop - begin, size // per_row)),
            nobody_asks,
        )
    sense(first, end, False, True, body, twist, joints, layout, counter, true, measured)
