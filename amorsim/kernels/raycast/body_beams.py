"""Single beams against the outlines of bodies: the same as `body_rays.cast_bodies` for one beam, faster.

A line of sight is one beam: there is no order among its beams to use, so each body near it is tested by itself.
"""

from __future__ import annotations

import math

import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.kernels.collision.body_hash import BodyHash, run_of_bodies, window
from amorsim.kernels.collision.footprints import Bodies, rounding_slack
from amorsim.kernels.compile import kernel
from amorsim.kernels.raycast.meet_body import BEAM_ROWS, DX, DY, FOUND, meet_body

__all__ = ["cast_beams"]


@kernel
def cast_beams(
    bodies: Bodies,
    body_pose: Array,
    edge_rows: int,
    table: BodyHash,
    widest: float,
    replica: Ints,
    own: Ints,
    origins: Array,
    cos_b: Array,
    sin_b: Array,
    range_max: Array,
    out: Array,
    hit: Ints,
) -> None:
    """Lower each range to where its beam meets another body of the same replica, where that is nearer.

    Arguments and results are those of `body_rays.cast_bodies`, to the bit, with one beam a row: `out` is (N, 1).
    """
    edges = np.empty((edge_rows, 5))
    beam = np.empty((BEAM_ROWS, 1))
    for i in range(out.shape[0]):
        limit = range_max[min(i, range_max.shape[0] - 1)]
        far = min(out[i, 0], limit)
        row = min(i, cos_b.shape[0] - 1)
        cos_h, sin_h = math.cos(origins[i, 2]), math.sin(origins[i, 2])
        dx = cos_h * cos_b[row, 0] - sin_h * sin_b[row, 0]
        dy = sin_h * cos_b[row, 0] + cos_h * sin_b[row, 0]
        beam[DX, 0], beam[DY, 0] = dx, dy
        origin_x, origin_y = origins[i, 0], origins[i, 1]
        slack = rounding_slack(abs(origin_x) + abs(origin_y))
        around = widest * (1.0 + 1e-9) + slack
        half_x, half_y = 0.5 * far * dx, 0.5 * far * dy
        row0, rows = window(origin_y + half_y, abs(half_y) + around, table.side, table.rows)
        col0, cols = window(origin_x + half_x, abs(half_x) + around, table.side, table.cols)
        for run in range(2 * rows if col0 + cols > table.cols else rows):
            first, last = run_of_bodies(table, replica[i], row0, rows, col0, cols, run)
            for place in range(first, last):
                x = table.disc[place, 0] - origin_x
                y = table.disc[place, 1] - origin_y
                # A circle around the body, larger than it needs to be by far more than rounding can matter.
                circle = table.disc[place, 2] * (1.0 + 1e-9) + slack + 1e-9 * (abs(x) + abs(y))
                along = dx * x + dy * y
                # Conditions that are true of nan, whose body is tested.
                misses = (abs(dx * y - dy * x) > circle) | (along < -circle) | (along - circle > far)
                if misses | (table.owner[place] == own[i]):
                    continue
                body = table.body[place]
                meet_body(bodies, body, body_pose[body], x, y, edges, beam, 0, 1)
                found = beam[FOUND, 0]
                if not found <= limit:
                    continue
                # In whatever order bodies come, the same one wins.
                if found < out[i, 0]:
                    out[i, 0] = far = found
                    if hit.shape[1] > 0:
                        hit[i, 0] = body
                elif hit.shape[1] > 0 and found == out[i, 0] and body < hit[i, 0]:
                    hit[i, 0] = body
