"""HRVO: the velocity is the one that looking at all candidates finds."""

from __future__ import annotations

import math

import numpy as np
import pytest

from amorsim.kernels.avoidance.hybrid import hybrid_velocities

SPARE = 1e-9


def is_inside(cone: list[float], x: float, y: float) -> bool:
    dx, dy = x - cone[0], y - cone[1]
    return cone[2] * dy - cone[3] * dx > SPARE and cone[4] * dy - cone[5] * dx < -SPARE


def candidates(cones: list[list[float]], most: float, wx: float, wy: float) -> list[tuple[float, float]]:
    """The wanted velocity, and on each side: its projection, where it meets the circle, and where earlier sides."""
    sides = [(cone[0], cone[1], cone[k], cone[k + 1]) for cone in cones for k in (2, 4)]
    found = [(wx, wy)]
    for a, (ax, ay, dx, dy) in enumerate(sides):
        places = [dx * (wx - ax) + dy * (wy - ay)]
        along = ax * dx + ay * dy
        inside = along * along + most * most - ax * ax - ay * ay
        if inside >= 0.0:
            places += [-along + math.sqrt(inside), -along - math.sqrt(inside)]
        for bx, by, ex, ey in sides[:a]:
            cross = dx * ey - dy * ex
            if abs(cross) > 1e-9 and ((bx - ax) * dy - (by - ay) * dx) / cross > 0.0:
                places.append(((bx - ax) * ey - (by - ay) * ex) / cross)
        found += [(ax + t * dx, ay + t * dy) for t in places if t > 0.0]
    return found


def twin(cones: list[list[float]], most: float, wx: float, wy: float) -> tuple[float, float]:
    def merit(velocity: tuple[float, float]) -> tuple[int, float]:
        kept = next((j for j, cone in enumerate(cones) if is_inside(cone, *velocity)), len(cones))
        return -kept, (velocity[0] - wx) * (velocity[0] - wx) + (velocity[1] - wy) * (velocity[1] - wy)

    slow = [(x, y) for x, y in candidates(cones, most, wx, wy) if x * x + y * y <= most * most * (1.0 + 1e-9)]
    return min(slow, key=merit)


@pytest.mark.parametrize(("slots", "spread"), [(1, 1.0), (4, 2.0), (9, 0.5), (9, 8.0)])
def test_the_velocity_is_the_best_of_all_candidates(slots: int, spread: float) -> None:
    random = np.random.default_rng(slots)
    rows = 12
    others = np.empty((rows, slots, 5))
    others[:, :, :2] = random.uniform(-spread, spread, (rows, slots, 2))
    others[:, :, 2:4] = random.normal(0.0, 0.05, (rows, slots, 2))
    others[:, :, 4] = 0.08
    others[0] = math.nan  # nobody is near
    others[1, 1:] = math.inf
    own, wanted = random.normal(0.0, 0.1, (2, rows, 2))
    most = np.full((rows, 1), 0.12)
    cones, out = np.empty((rows, slots, 6)), np.empty((rows, 2))
    hybrid_velocities(others, own, wanted, np.full((rows, 1), 0.1), most, 0, rows, cones, out)
    for row in range(rows):
        there = [cone for cone in cones[row].tolist() if not math.isnan(cone[0])]
        assert len(there) == np.isfinite(others[row, :, 0]).sum()
        wx, wy = wanted[row].tolist()
        size = math.sqrt(wx * wx + wy * wy)
        if size > 0.12:
            wx, wy = wx / size * 0.12, wy / size * 0.12
        assert out[row].tolist() == list(twin(there, 0.12, wx, wy))
