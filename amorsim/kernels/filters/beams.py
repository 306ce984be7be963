"""How probable a scan is from a pose: the likelihood field, and the beam model.

Both take the beams of a scan as independent. Source: S. Thrun, W. Burgard, D. Fox, "Probabilistic Robotics" (2005),
6.3 (beams) and 6.4 (likelihood field).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from amorsim.array_types import Array, Ints32
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.grid.grid import Grid
from amorsim.kernels.raycast.rays import cast_ray, direction, to_frame

__all__ = ["Field", "Mixture", "Place", "Scan", "beam_probability", "weigh_by_beams", "weigh_by_field"]

# A component's parameter over rows, (N, 1) float64; declared as the number that it is for one row.
Column = Any

_FLAT = 1.0 / math.sqrt(2.0 * math.pi)
_VECTOR = 16  # numbers of 32 bits in the widest vector
_FAR = 1e9  # [cells]
_INDEX = np.uint32(0x7FFFFFFF)  # says that an index fits into 31 bits, for a wider look-up
_SMALL = 1e-200  # products below this are turned into logarithms, before they vanish


class Place(NamedTuple):
    """The pose of a map: its lower left corner in the world [m], and the cosine and sine of its yaw."""

    x: float
    y: float
    cos_yaw: float
    sin_yaw: float


class Field(NamedTuple):
    """The weight that a beam adds to a pose, for each cell of a grid in which the beam may end.

    In whole numbers: a sum of them is exact, so it may be taken in any order, many beams at a time.
    """

    steps: Ints32  # (rows * cols,) what a beam adds beyond `base`, in units of `unit`; 0 at the edge
    rows: int
    cols: int
    resolution: float  # [m]
    margin: float  # [m] by which the field reaches beyond the map
    unit: float
    base: float  # what a beam adds at the edge and beyond


class Scan(NamedTuple):
    """The beams of N rows, and the mounts of their sensors. A beam that is not used has the range nan."""

    ranges: Array  # (N, B) [m], inf for no return
    bearings: Array  # (N, B), or (1, B) for all rows [rad] from the sensor's heading
    x: Column  # [m]
    y: Column  # [m]
    heading: Column  # [rad]
    range_max: Column  # [m]


class Mixture(NamedTuple):
    """The shares of the causes of a range, and the numbers of each."""

    hit: Column  # the wall, with Gaussian noise
    short: Column  # something unexpected before it
    most: Column  # no return
    random: Column  # anything
    hit_std: float  # [m]
    short_rate: Column  # [1/m]


@kernel
def weigh_by_field(
    row: int, particles: Array, turns: Array, scan: Scan, field: Field, place: Place, cubed: bool, out: Array
) -> int:
    """Log-likelihoods of a row's scan from poses `particles` (n, 3), into `out`; returns how many beams counted.

    `turns` (2, n or more) has the sines and cosines of their headings. Beams without a return say nothing. With `cubed`
    the weight is ``1 + sum of p**3`` over the beams, as in Nav2, and the field has what they add to that.
    """
    beams = scan.ranges.shape[1]
    # Whole vectors of beams: the rest of them end far away, where they add nothing.
    ends = np.full((2, (beams + _VECTOR - 1) // _VECTOR * _VECTOR), np.float32(_FAR))
    bearings = scan.bearings[row % scan.bearings.shape[0]]
    per_cell = 1.0 / field.resolution
    count = 0
    for b in range(beams):
        r = scan.ranges[row, b]
        if 0.0 <= r < scan.range_max[row, 0]:  # neither nan, nor too near, nor without a return
            bearing = bearings[b] + scan.heading[row, 0]
            ends[0, count] = (scan.x[row, 0] + r * math.cos(bearing)) * per_cell
            ends[1, count] = (scan.y[row, 0] + r * math.sin(bearing)) * per_cell
            count += 1
    steps = field.steps
    cells = np.empty(ends.shape[1], dtype=np.uint32)
    nothing = np.float32(0.0)
    right = np.float32(field.cols - 1)
    top = np.float32(field.rows - 1)
    for p in range(particles.shape[0]):
        world_x, world_y = particles[p, 0], particles[p, 1]
        map_x, map_y = to_frame(world_x, world_y, place.x, place.y, place.cos_yaw, place.sin_yaw)
        x = np.float32((map_x + field.margin) * per_cell)
        y = np.float32((map_y + field.margin) * per_cell)
        cos_h = np.float32(turns[1, p] * place.cos_yaw + turns[0, p] * place.sin_yaw)
        sin_h = np.float32(turns[0, p] * place.cos_yaw - turns[1, p] * place.sin_yaw)
        # Two loops that compilers make many beams wide. Beams that leave the field end at its edge.
        for k in range(cells.shape[0]):
            at_x = max(nothing, min(x + (cos_h * ends[0, k] - sin_h * ends[1, k]), right))
            at_y = max(nothing, min(y + (sin_h * ends[0, k] + cos_h * ends[1, k]), top))
            cells[k] = np.int32(at_y) * field.cols + np.int32(at_x)
        total = np.int32(0)
        for k in range(cells.shape[0]):
            total += steps[cells[k] & _INDEX]
        added = count * field.base + field.unit * total
        out[p] = math.log(1.0 + added) if cubed else added
    return count


@part
def beam_probability(
    r: float,
    expected: float,
    range_max: float,
    hit: float,
    short: float,
    most: float,
    random: float,
    hit_std: float,
    short_rate: float,
) -> float:
    """The density [1/m] of a range where a wall is `expected`; of no return (inf) the probability."""
    if not r < range_max:
        # A wall out of range gives no return, and so does noise that carries a return out of range.
        beyond = 1.0 if not expected < range_max else 0.5 * math.erfc((range_max - expected) / hit_std * math.sqrt(0.5))
        return most + hit * beyond
    probability = random / range_max
    if expected < range_max:
        away = (r - expected) / hit_std
        probability += hit * _FLAT / hit_std * math.exp(-0.5 * away * away)
    nearest = min(expected, range_max)
    if short > 0.0 and r < nearest:
        probability += short * short_rate * math.exp(-short_rate * r) / (1.0 - math.exp(-short_rate * nearest))
    return probability


@kernel
def weigh_by_beams(
    row: int, particles: Array, scan: Scan, mixture: Mixture, grid: Grid, place: Place, cubed: bool, out: Array
) -> int:
    """Log-likelihoods of a row's scan from poses `particles` (n, 3) by the beam model, as `weigh_by_field` gives."""
    range_max = scan.range_max[row, 0]
    hit, short = mixture.hit[row, 0], mixture.short[row, 0]
    most, random = mixture.most[row, 0], mixture.random[row, 0]
    hit_std, short_rate = mixture.hit_std, mixture.short_rate[row, 0]
    reach = range_max + 6.0 * hit_std
    bearings = scan.bearings[row % scan.bearings.shape[0]]
    used = np.empty((scan.ranges.shape[1], 3))
    count = 0
    for b in range(scan.ranges.shape[1]):
        r = scan.ranges[row, b]
        if r >= 0.0:  # neither nan nor nearer than the sensor measures
            used[count, 0] = r
            bearing = bearings[b] + scan.heading[row, 0]
            used[count, 1] = math.cos(bearing)
            used[count, 2] = math.sin(bearing)
            count += 1
    for p in range(particles.shape[0]):
        c = math.cos(particles[p, 2])
        s = math.sin(particles[p, 2])
        world_x = particles[p, 0] + (c * scan.x[row, 0] - s * scan.y[row, 0])
        world_y = particles[p, 1] + (s * scan.x[row, 0] + c * scan.y[row, 0])
        x, y = to_frame(world_x, world_y, place.x, place.y, place.cos_yaw, place.sin_yaw)
        cos_h = c * place.cos_yaw + s * place.sin_yaw
        sin_h = s * place.cos_yaw - c * place.sin_yaw
        total = 0.0
        product = 1.0
        for k in range(count):
            dx, dy = direction(cos_h, sin_h, used[k, 1], used[k, 2])
            expected = cast_ray(grid, x, y, dx, dy, reach)
            probability = beam_probability(
                used[k, 0], expected, range_max, hit, short, most, random, hit_std, short_rate
            )
            if cubed:
                product += probability * probability * probability
            else:
                product *= probability
                if product < _SMALL:
                    total += math.log(product) if product > 0.0 else -math.inf
                    product = 1.0
        out[p] = total + math.log(product)
    return count
