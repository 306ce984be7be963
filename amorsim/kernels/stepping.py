"""A step of robots of the commonest kind in one call: they move, sense, believe where they are, and are recorded.

To enter a kernel from Python takes 0.05 us for each array that it is handed, and to make one there 0.1 us: at one row
as long as the work. So what is known before is handed over in one table (`amorsim.kernels.known`), and what comes of a
step in few arrays.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.compile import kernel
from amorsim.kernels.concluding import RECKONING, conclude
from amorsim.kernels.known import known_at
from amorsim.kernels.rolling import ROLLING, roll_free
from amorsim.kernels.sensing import sense

__all__ = ["RECKONING", "ROLLING", "advance"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@kernel
def advance(
    rolls: bool,
    looks: bool,
    reads: bool,
    concludes: bool,
    first: int,
    end: int,
    table: Ints,
    room: Floats,
    ticks: Ints,
    tick: Ints,
    pose: Floats,
    twist: Floats,
    joints: Floats,
    rates: Floats,
    command: Floats,
    believed: Floats,
    covariance: Floats,
    reckoned: Floats,
    poses_out: Floats,
    joints_out: Floats,
    covariance_out: Floats,
    tick_out: Ints,
    time_out: Floats,
    values: Floats,
    fingerprint: NDArray[np.uint64],
) -> bool:
    """Make of a step what is asked for; False, and nothing is made, where it `rolls` and not all have room for that.

    Parameters
    ----------
    rolls, looks, reads, concludes
        Whether all rows roll (`rolling.roll_free`) and their time goes on; and whether rows first..end-1 look about and
        read (`sensing.sense`), and conclude (`concluding.conclude`).
    table
        What is known of the group, as `known.lay_out` lays it out; the ticks are written that draws count by.
    room
        As `roll_free` takes it.
    ticks
        (R,) of the replicas, 1 is added.
    tick
        (N, 1).
    pose, twist, joints, rates, command
        As they are before; what does not roll senses there.
    believed, covariance, reckoned
        The estimate before, and the wheels' angles then, as `conclude` takes them.
    poses_out
        (3, N, 3), gets true poses and twists of what rolls, and estimated poses.
    joints_out
        (3, N, 2), gets joints and their rates of what rolls, and the angles that were reckoned with.
    covariance_out
        (N, 3, 3), gets the estimates'.
    tick_out, time_out
        (N, 1), get the tick and the time [s] of what rolls.
    values
        (2, V * N), true and measured, as `sense` takes them.
    fingerprint
        (N, 2), as `conclude` takes it.
    """
    known = known_at(table)
    if rolls:
        if not roll_free(
            joints,
            rates,
            command,
            known.wheels[:ROLLING],
            known.dt,
            pose,
            room,
            joints_out[:2],
            poses_out[0],
            poses_out[1],
        ):
            return False
        pose = poses_out[0]
        twist = poses_out[1]
        joints = joints_out[0]
        for r in range(ticks.shape[0]):
            ticks[r] += 1
        for i in range(tick.shape[0]):
            tick_out[i, 0] = tick[i, 0] + 1
            # By multiplication, never by adding up: a billion steps later the time is still right.
            time_out[i, 0] = tick_out[i, 0] * known.dt
            known.counter[i, 2] = np.uint32(tick_out[i, 0])
    if looks or reads:
        sense(
            looks,
            reads,
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
            values[0],
            values[1],
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
            values[0],
            values[1],
            first,
            end,
            fingerprint,
        )
    return True
