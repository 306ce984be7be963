"""Which arc a wandering car takes, against weighing all of them with all points."""

from __future__ import annotations

import math

import numpy as np
import pytest

from amorsim.kernels.behaviours import wandering_car
from amorsim.kernels.behaviours.wandering_car import CarBody

ARCS, STEPS = wandering_car._ARCS, wandering_car._STEPS


def room(points: np.ndarray, bend: float, front: float, rear: float, half_width: float, horizon: float) -> float:
    step = horizon / STEPS
    for k in range(1, STEPS + 1):
        way = step * k
        angle = bend * way
        x, y = (way, 0.0) if abs(angle) < 1e-6 else (math.sin(angle) / bend, (1.0 - math.cos(angle)) / bend)
        c, s = math.cos(angle), math.sin(angle)
        for px, py in points.T.tolist():
            if not math.isfinite(px):
                continue
            dx, dy = px - x, py - y
            if rear < c * dx + s * dy < front and abs(c * dy - s * dx) < half_width:
                return way - step
    return horizon


def best_arc(points: np.ndarray, lean: float, sharpest: float, body: CarBody, keep: float) -> tuple[float, float]:
    length = body.front - body.rear
    best, found = -math.inf, (0.0, 0.0)
    for k in range(2 * ARCS + 1):
        share = (k - ARCS) / ARCS
        horizon = wandering_car._HORIZON * length
        free = room(points, share * sharpest, body.front + keep, body.rear, body.half_width + keep, horizon)
        worth = free - 0.2 * length * abs(share - lean)
        if worth > best:
            best, found = worth, (free, share * sharpest)
    return found


@pytest.mark.parametrize("sharpest", [0.0, 1e-9, 1e-4, 0.02, 0.237, 1.5, 1e3])
@pytest.mark.parametrize("count", [0, 3, 40])
def test_the_arc_is_the_one_of_weighing_all(sharpest: float, count: int) -> None:
    random = np.random.default_rng(count)
    moved = 0
    for trial in range(40):
        length = random.uniform(0.5, 5.0)
        body = CarBody(0.8 * length, -0.2 * length, 0.2 * length, np.zeros((1, 4)), np.array([[sharpest]]))
        points = random.uniform(-3.5 * length, 3.5 * length, (2, count))
        points[:, : count // 3] = np.inf
        lean = (-1.0, 0.0, 1.0, 0.5, 0.25)[trial] if trial < 5 else random.uniform(-1.0, 1.0)
        found = wandering_car._best_arc(points, np.empty(points.shape), lean, sharpest, body, 0.05 * length)
        expected = best_arc(points, lean, sharpest, body, 0.05 * length)
        assert found == expected
        moved += found[0] < wandering_car._HORIZON * length
    assert moved > 0 or count < 40
