"""A trailer that is drawn: how its hitch turns as the tractor moves."""

from __future__ import annotations

import math
from typing import Any

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel, part

__all__ = ["follow_hitch", "hitch_after"]

# A component's parameter over rows, (N, 1) float64; declared as the number that it is for one row.
Column = Any


@part
def hitch_after(hitch: float, v: float, w: float, length: float, offset: float, limit: float) -> float:
    """The hitch angle [rad] after a constant twist of `v` [m] forward and a turn `w` [rad]; see `follow_hitch`."""
    if v == 0.0 and w == 0.0:
        return hitch
    pull = -0.5 * v / length
    swing = 0.5 * offset * w / length
    turn = 0.5 * w
    square = pull * pull - turn * turn + swing * swing
    root = math.sqrt(abs(square))
    if root == 0.0:
        even = 1.0
        odd = 1.0
    elif square > 0.0:
        even = math.cosh(root)
        odd = math.sinh(root) / root
    else:
        even = math.cos(root)
        odd = math.sin(root) / root
    s = math.sin(0.5 * hitch)
    c = math.cos(0.5 * hitch)
    above = even * s + odd * (pull * s + (turn + swing) * c)
    below = even * c + odd * ((swing - turn) * s - pull * c)
    after = 2.0 * math.atan2(above, below)
    # The same turn of the trailer around the tractor: no jump as it folds under.
    after += 4.0 * math.pi * math.floor((hitch - after) / (4.0 * math.pi) + 0.5)
    # One that is beyond its end already, which may have been set nearer, does not jump there.
    return min(max(after, min(-limit, hitch)), max(limit, hitch))


@kernel
def follow_hitch(
    hitch: Array, twists: Array, trailer_length: Column, hitch_offset: Column, hitch_max: Column, out: Array
) -> None:
    """Hitch angles [rad] after constant twists (N, 3), into `out` (N, 1).

    The angle b is the tractor's heading less the trailer's. With v forward, w the turn, l the trailer's length and c
    how far behind the axle the hitch is, b' = w - (v / l) sin b + (c w / l) cos b. For (sin b/2, cos b/2), up to its
    length, that is linear, with a matrix whose square is a number times the identity: so its exponential is at hand.
    The equation holds no time, so b never turns back within a step: stopping it at `hitch_max` is to cut off what is
    beyond. A tractor that stands leaves the hitch as it is, to the bit.
    """
    for i in range(hitch.shape[0]):
        out[i, 0] = hitch_after(
            hitch[i, 0], twists[i, 0], twists[i, 2], trailer_length[i, 0], hitch_offset[i, 0], hitch_max[i, 0]
        )
