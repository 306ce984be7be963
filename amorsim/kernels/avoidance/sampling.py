"""Model predictive path integral control (MPPI): many noisy simulated drives, weighted by their costs."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from amorsim.array_types import Array
from amorsim.kernels.avoidance.dynamic_window import Abilities, moved_on
from amorsim.kernels.avoidance.guide import Guide, find_leg, to_go
from amorsim.kernels.behaviours.free_space import Sight, see_points
from amorsim.kernels.compile import kernel, part

__all__ = ["Costs", "Field", "distances", "roll_out"]

Column = Any


class Field(NamedTuple):
    """A window of square cells around a robot, with its heading: the distance of each to the nearest point."""

    cells: int
    """Cells in a line."""
    side: float
    """Of a cell [m]."""


class Costs(NamedTuple):
    """The costs of simulated drives, each (N, 1)."""

    temperature: Column
    """Cost by which a run may be worse than the best and still count."""
    path_weight: Column
    """How many metres along the path a metre off it counts."""
    obstacle_weight: Column
    """[m] of way that standing against something for the whole run costs; half at half of `obstacle_distance`."""
    obstacle_distance: Column
    """[m] from the margin within which things cost."""
    collision_weight: Column
    """[m] of way that a run costs which meets something."""
    margin: Column
    """[m] kept around the footprint."""


@part
def distances(points: Array, field: Field, out: Array) -> None:
    """The distance [m] from the middle of each cell (S, S) to the nearest point (3, p), 1 m at most, into `out`.

    Of points in one cell the last counts as its middle: two sweeps of a chamfer, within 4.2 % of the distance.
    """
    count, side = field.cells, field.side
    out[:, :] = 1.0
    for n in range(points.shape[1]):
        x, y = points[0, n], points[1, n]
        if abs(x) < math.inf and abs(y) < math.inf:
            col = math.floor(x / side) + count // 2
            row = math.floor(y / side) + count // 2
            if 0 <= col < count and 0 <= row < count:
                out[row, col] = 0.0
    straight, diagonal = side * 0.96194, side * 1.36039
    for row in range(count):
        for col in range(count):
            best = out[row, col]
            if col > 0:
                best = min(best, out[row, col - 1] + straight)
            if row > 0:
                best = min(best, out[row - 1, col] + straight)
                if col > 0:
                    best = min(best, out[row - 1, col - 1] + diagonal)
                if col < count - 1:
                    best = min(best, out[row - 1, col + 1] + diagonal)
            out[row, col] = best
    for back_row in range(count):
        row = count - 1 - back_row
        for back_col in range(count):
            col = count - 1 - back_col
            best = out[row, col]
            if col < count - 1:
                best = min(best, out[row, col + 1] + straight)
            if row < count - 1:
                best = min(best, out[row + 1, col] + straight)
                if col > 0:
                    best = min(best, out[row + 1, col - 1] + diagonal)
                if col < count - 1:
                    best = min(best, out[row + 1, col + 1] + diagonal)
            out[row, col] = best


@part
def _room(far: Array, field: Field, x: float, y: float) -> float:
    """The distance [m] at a place; that of far away outside the window."""
    col = math.floor(x / field.side) + field.cells // 2
    row = math.floor(y / field.side) + field.cells // 2
    if 0 <= col < field.cells and 0 <= row < field.cells:
        return float(far[row, col])
    return 1.0


@kernel
def roll_out(
    sight: Sight,
    age: Array,
    pose: Array,
    discs: Array,
    field: Field,
    guide: Guide,
    able: Abilities,
    costs: Costs,
    noise: Array,
    step: float,
    moving: Array,
    first: int,
    end: int,
    plan: Array,
) -> None:
    """Better plans of twists for the rows from `first` to `end`, into `plan` (N, T, 2): v [m/s] and w [rad/s].

    Each of K runs ahead adds noise to the plan of T twists of `step` [s], within the drive's abilities. The new plan
    is the mean of the runs, weighted by ``exp(-cost / temperature)``.

    Parameters
    ----------
    sight, age, pose, guide, able
        As of `choose_twists`.
    discs
        (D, 3) x, y and radius [m] of discs that hold the footprint.
    field
        The window in which distances are looked up.
    costs
        What runs cost.
    noise
        (N, K, T, 2) standard normal draws times the standard deviations of v and w.
    moving
        (N, 2) the twists now, by the robots' own reckoning.
    """
    points = np.empty((3, sight.ranges.shape[1] * sight.samples))
    far = np.empty((field.cells, field.cells))
    runs, steps = noise.shape[1], noise.shape[2]
    cost = np.empty(runs)
    for i in range(first, end):
        see_points(sight.ranges[i], sight.beams[i], sight.half_angle[i, 0], points)
        moved_on(points, moving[i, 0], moving[i, 1], age[i, 0])
        distances(points, field, far)
        path, along, count = guide.path[i], guide.along[i], guide.size[i]
        leg, here = find_leg(path, along, count, guide.leg[i], 3.0, pose[i, 0], pose[i, 1])
        guide.leg[i] = leg
        limits = able.limits[i]
        fastest = min(able.speed[i, 0], limits[0])
        turning = min(able.turn_rate[i, 0], limits[1])
        until = here + fastest * step * steps + 1.0
        c0, s0 = math.cos(pose[i, 2]), math.sin(pose[i, 2])
        gain, spin = limits[2] * step, limits[3] * step
        least = math.inf
        for k in range(runs):
            x, y, heading = 0.0, 0.0, 0.0
            v0, w0 = moving[i, 0], moving[i, 1]
            total = 0.0
            for t in range(steps):
                v = plan[i, t, 0] + noise[i, k, t, 0]
                w = plan[i, t, 1] + noise[i, k, t, 1]
                v = min(max(v, -able.back[i, 0]), fastest)
                w = min(max(w, -turning), turning)
                v = min(max(v, v0 - gain), v0 + gain)
                w = min(max(w, w0 - spin), w0 + spin)
                # What is kept is the noise that the drive can follow.
                noise[i, k, t, 0] = v - plan[i, t, 0]
                noise[i, k, t, 1] = w - plan[i, t, 1]
                v0, w0 = v, w
                middle = heading + 0.5 * w * step
                x += v * step * math.cos(middle)
                y += v * step * math.sin(middle)
                heading += w * step
                c, s = math.cos(heading), math.sin(heading)
                room = 1.0
                for d in range(discs.shape[0]):
                    px = x + c * discs[d, 0] - s * discs[d, 1]
                    py = y + s * discs[d, 0] + c * discs[d, 1]
                    room = min(room, _room(far, field, px, py) - discs[d, 2])
                room -= costs.margin[i, 0]
                if room <= 0.0:
                    total += costs.collision_weight[i, 0] * (1.0 + (steps - t) / steps)
                    for rest in range(t + 1, steps):
                        noise[i, k, rest, 0] = -plan[i, rest, 0]
                        noise[i, k, rest, 1] = -plan[i, rest, 1]
                    break
                if room < costs.obstacle_distance[i, 0]:
                    total += costs.obstacle_weight[i, 0] * (1.0 - room / costs.obstacle_distance[i, 0]) / steps
            total += to_go(
                path,
                along,
                count,
                leg,
                until,
                costs.path_weight[i, 0],
                pose[i, 0] + c0 * x - s0 * y,
                pose[i, 1] + s0 * x + c0 * y,
            )
            cost[k] = total
            least = min(least, total)
        weights = 0.0
        for k in range(runs):
            cost[k] = math.exp(-(cost[k] - least) / costs.temperature[i, 0])
            weights += cost[k]
        for t in range(steps):
            v, w = 0.0, 0.0
            for k in range(runs):
                v += cost[k] * noise[i, k, t, 0]
                w += cost[k] * noise[i, k, t, 1]
            plan[i, t, 0] += v / weights
            plan[i, t, 1] += w / weights
