"""The end of a step among other bodies in one call, that may be shared: to look about, meet bodies, read, conclude."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.bodies import Bodies
from amorsim.kernels.body_hash import BodyHash
from amorsim.kernels.body_rays import cast_bodies
from amorsim.kernels.compile import kernel
from amorsim.kernels.concluding import conclude
from amorsim.kernels.known import known_at
from amorsim.kernels.rolling import ROLLING
from amorsim.kernels.sensing import LIMITS, sense
from amorsim.kernels.shares import offer, spread, take_rows

__all__ = ["FINDER_COLUMNS", "sense_among"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Of a range finder: how many values and places there are of the devices before it; how many places it looks from; how
# many values it has; where its beams begin, and how many they are.
_VALUES, _PLACES, _FROM, _SIZE, _BEAMS, _RAYS = range(6)
FINDER_COLUMNS = 6


@kernel
def _sense_among(
    share: int,
    concludes: bool,
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
    table: Ints,
    pose: Floats,
    twist: Floats,
    joints: Floats,
    command: Floats,
    believed: Floats,
    covariance: Floats,
    reckoned: Floats,
    poses_out: Floats,
    joints_out: Floats,
    covariance_out: Floats,
    values: Floats,
    fingerprint: NDArray[np.uint64],
) -> None:
    """The share of a thread of `sense_among`."""
    rows = pose.shape[0]
    known = known_at(table)
    true = values[0]
    measured = values[1]
    limits = known.floats[known.ints[LIMITS] : known.ints[LIMITS + 1]]
    nobody_asks = np.empty((0, 0), dtype=np.int64)
    first, end = take_rows(share, rows, 0)
    while first < end:
        for phase in range(2):
            if phase == 1:
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
                        known.places[begin:stop],
                        cos_b[beams : beams + rays].reshape((1, rays)),
                        sin_b[beams : beams + rays].reshape((1, rays)),
                        limits[begin:stop],
                        true[at + first * size : at + end * size].reshape((stop - begin, size // per_row)),
                        nobody_asks,
                    )
            sense(
                phase == 0,
                phase == 1,
                known.grid,
                known.lines,
                known.origin_x,
                known.origin_y,
                known.yaw,
                known.ints,
                known.floats,
                known.counter,
                pose,
                twist,
                joints,
                first,
                end,
                known.places,
                true,
                measured,
            )
        if concludes:
            conclude(
                known.encoder,
                known.wheels[ROLLING:],
                believed,
                covariance,
                reckoned,
                joints_out[2],
                poses_out[2],
                covariance_out,
                pose,
                joints,
                command,
                known.ints,
                true,
                measured,
                first,
                end,
                fingerprint,
            )
        first, end = take_rows(share, rows, end)


@kernel
def sense_among(
    share: int,
    concludes: bool,
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
    table: Ints,
    pose: Floats,
    twist: Floats,
    joints: Floats,
    command: Floats,
    believed: Floats,
    covariance: Floats,
    reckoned: Floats,
    poses_out: Floats,
    joints_out: Floats,
    covariance_out: Floats,
    values: Floats,
    fingerprint: NDArray[np.uint64],
) -> None:
    """What `sensing.sense` does to look, `body_rays.cast_bodies` of all range finders, and `sense` to read.

    And then, if it `concludes`, what `concluding.conclude` does.

    Parameters
    ----------
    share
        `ALONE`, or for `shares.spread`.
    bodies, body_pose, edge_rows, by_place, widest
        As `cast_bodies` takes them.
    finders
        (F, FINDER_COLUMNS), the range finders.
    own, replica
        (L * N,): of each place that is looked from, the body that it is on, and the replica.
    cos_b, sin_b
        Of the finders' beams, one device after another, as `cast_bodies` takes them.
    table, ..., fingerprint
        As `stepping.advance` takes them.
    """
    given = (
        concludes,
        bodies,
        body_pose,
        edge_rows,
        by_place,
        widest,
        finders,
        own,
        replica,
        cos_b,
        sin_b,
        table,
        pose,
        twist,
        joints,
        command,
        believed,
        covariance,
        reckoned,
        poses_out,
        joints_out,
        covariance_out,
        values,
        fingerprint,
    )
    spread(share, pose.shape[0], offer(_sense_among, given))
