"""A step of sensing among other bodies: rows look about, meet bodies and read in one call, and may be shared."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.bodies import Bodies
from amorsim.kernels.body_hash import BodyHash
from amorsim.kernels.body_rays import cast_bodies
from amorsim.kernels.compile import kernel
from amorsim.kernels.sensing import sense
from amorsim.kernels.shares import take_rows

__all__ = ["FINDER_COLUMNS", "sense_among"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Of a range finder: how many values and places there are of the devices before it; how many places it looks from; how
# many values it has; where its beams begin, and how many they are.
_VALUES, _PLACES, _FROM, _SIZE, _BEAMS, _RAYS = range(6)
FINDER_COLUMNS = 6


@kernel
def sense_among(
    share: int,
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
    resolution: float,
    cell_rows: int,
    cell_cols: int,
    super_cols: int,
    supers: NDArray[np.int32],
    tables: NDArray[np.int32],
    pages: NDArray[np.uint64],
    room: NDArray[np.uint16],
    boxes: Floats,
    blocks_first: Ints,
    line_walls: Floats,
    origin_x: float,
    origin_y: float,
    yaw: float,
    table: Ints,
    mounts: Floats,
    numbers: Floats,
    ring: Floats,
    limits: Floats,
    half_angles: Floats,
    edges: Floats,
    sorted_cos: Floats,
    sorted_sin: Floats,
    order: Ints,
    starts: Ints,
    chains: Ints,
    parts: Floats,
    keys: NDArray[np.uint64],
    counter: NDArray[np.uint32],
    body: Floats,
    twist: Floats,
    joints: Floats,
    places: Floats,
    true: Floats,
    measured: Floats,
) -> None:
    """What `sensing.sense` does to look, `body_rays.cast_bodies` of all range finders, and `sense` to read.

    Parameters
    ----------
    share
        Of the rows, see `shares.take_rows`.
    bodies, body_pose, edge_rows, by_place, widest
        As `cast_bodies` takes them.
    finders
        (F, FINDER_COLUMNS), the range finders.
    own, replica
        (L * N,): of each place that is looked from, the body that it is on, and the replica.
    cos_b, sin_b
        Of the finders' beams, one device after another, as `cast_bodies` takes them.
    resolution, ..., measured
        As `sense` takes them.
    """
    rows = body.shape[0]
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
                        places[begin:stop],
                        cos_b[beams : beams + rays].reshape((1, rays)),
                        sin_b[beams : beams + rays].reshape((1, rays)),
                        limits[begin:stop],
                        true[at + first * size : at + end * size].reshape((stop - begin, size // per_row)),
                        nobody_asks,
                    )
            sense(
                phase == 0,
                phase == 1,
                resolution,
                cell_rows,
                cell_cols,
                super_cols,
                supers,
                tables,
                pages,
                room,
                boxes,
                blocks_first,
                line_walls,
                origin_x,
                origin_y,
                yaw,
                table,
                mounts,
                numbers,
                ring,
                limits,
                half_angles,
                edges,
                sorted_cos,
                sorted_sin,
                order,
                starts,
                chains,
                parts,
                keys,
                counter,
                body,
                twist,
                joints,
                first,
                end,
                places,
                true,
                measured,
            )
        first, end = take_rows(share, rows, end)
