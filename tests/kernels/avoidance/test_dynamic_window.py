"""The dynamic window: what it chooses can be braked from."""

import math

import numpy as np
import pytest

from amorsim.kernels.avoidance.arcs import Box, distance_to_box
from amorsim.kernels.avoidance.dynamic_window import Abilities, Scene, Weights, choose_twists, keep_behind
from amorsim.kernels.avoidance.guide import Guide
from amorsim.kernels.behaviours.free_space import Sight
from tests.some_cases import one_in

DT = 0.1
BOX = Box(-0.25, 0.2, -0.2, 0.2, math.inf)
MARGIN = 0.05
LIMITS = (1.0, 2.0, 0.8, 2.5)


def column(rows, value):
    return np.full((rows, 1), value)


def choose(
    ranges, bearings, moving, goal, *, back=0.0, limits=LIMITS, curvature=math.inf, lag=0.0, box=BOX, behind=None
):
    """The twists of robots at the origin; `moving` is changed."""
    rows, k = ranges.shape
    beams = np.zeros((rows, 5, k))
    beams[:, 2] = bearings
    beams[:, 3], beams[:, 4] = np.cos(bearings), np.sin(bearings)
    out = np.empty((rows, 3))
    arcs = np.empty((rows, 7, 21, 3))
    sight = Sight(ranges, beams, column(rows, 0.0), 1)
    behind = np.full((rows, 4, 3), -1e30) if behind is None else behind
    choose_twists(
        Scene(sight, column(rows, 0.0), behind, column(rows, 0.0)),
        np.zeros((rows, 3)),
        box,
        Guide(goal[:, None, :].copy(), np.zeros((rows, 1)), np.ones(rows, np.int64), np.zeros(rows, np.int64)),
        Abilities(
            column(rows, 2.0), column(rows, back), column(rows, 5.0), np.tile(limits, (rows, 1)),
            column(rows, curvature), column(rows, lag),
        ),
        Weights(*(column(rows, value) for value in (MARGIN, 1.5, 0.3, 2.0, 0.3, 0.05))),
        np.ones((rows, 1), dtype=bool),
        DT,
        moving,
        0,
        rows,
        arcs,
        out,
    )  # fmt: skip
    return out, arcs


def braked(v, w, limits, lag=0.0):
    """Poses while a robot drives a step with a twist and then brakes along the same arc, every 2 ms."""
    time = abs(v) / limits[2] + abs(w) / limits[3]
    pose, found = [0.0, 0.0, 0.0], [(0.0, 0.0, 0.0)]
    step = 0.002
    for n in range(math.ceil((DT + lag + time) / step)):
        t = (n + 0.5) * step
        left = 1.0 if t < DT + lag else max(0.0, 1.0 - (t - DT - lag) / time)
        middle = pose[2] + 0.5 * w * left * step
        pose = [
            pose[0] + v * left * step * math.cos(middle),
            pose[1] + v * left * step * math.sin(middle),
            pose[2] + w * left * step,
        ]
        found.append(tuple(pose))
    return found


def nearest(poses, points, box=BOX):
    """The least distance of the points to the box on its way."""
    least = math.inf
    for x, y, heading in poses:
        c, s = math.cos(heading), math.sin(heading)
        for px, py in points:
            dx, dy = px - x, py - y
            least = min(least, distance_to_box(c * dx + s * dy, c * dy - s * dx, box))
    return least


@pytest.mark.parametrize("back", one_in(2, [0.4, 0.0]))
@pytest.mark.parametrize("box", [BOX, Box(0.0, 0.0, 0.0, 0.0, math.inf), Box(-0.3, 0.2, -0.2, 0.2, 0.32)])
def test_never_chooses_what_it_cannot_brake_from(back, box):
    random = np.random.default_rng(3)
    rows, k = 40, 48
    bearings = np.linspace(-math.pi, math.pi, k, endpoint=False)
    ranges = random.uniform(0.45, 3.0, (rows, k))
    ranges[random.uniform(size=ranges.shape) < 0.4] = math.inf
    moving = np.stack((random.uniform(0.0, 1.0, rows), random.uniform(-1.0, 1.0, rows)), axis=1)
    moving[::2] = 0.0
    before = moving.copy()
    goals = random.uniform(-5.0, 5.0, (rows, 2))
    out, arcs = choose(ranges, bearings, moving, goals, back=back, box=box)
    driven = 0
    for i in range(rows):
        v, w = out[i, 0], out[i, 2]
        # Within one step's accelerations, which both share, and the drive's rates.
        assert abs(v - before[i, 0]) / LIMITS[2] + abs(w - before[i, 1]) / LIMITS[3] <= DT * (1.0 + 1e-9)
        points = [(r * math.cos(b), r * math.sin(b)) for r, b in zip(ranges[i], bearings, strict=True) if r < math.inf]
        admissible = np.isfinite(arcs[i, :, :, 2]).any()
        if not admissible:  # what the robot did before was not for this world; it brakes
            assert abs(v) <= abs(before[i, 0])
            continue
        driven += abs(v) + abs(w) > 0.05
        assert nearest(braked(v, w, LIMITS), points, box) >= MARGIN - 2e-3
    assert driven > 10


@pytest.mark.long
def test_every_arc_left_over_can_be_braked_from():
    random = np.random.default_rng(4)
    bearings = np.linspace(-2.0, 2.0, 30)
    ranges = random.uniform(0.4, 1.2, (1, 30))
    _, arcs = choose(ranges, bearings, np.array([[0.45, 0.3]]), np.array([[3.0, 0.0]]), lag=0.1)
    points = np.stack((ranges[0] * np.cos(bearings), ranges[0] * np.sin(bearings)), axis=1)
    fine = [(v, w) for v, w, cost in arcs.reshape(-1, 3) if math.isfinite(cost)]
    assert 0 < len(fine) < 147
    for v, w in fine[::5]:
        assert nearest(braked(v, w, LIMITS, 0.1), points) >= MARGIN - 2e-3


def test_it_stops_before_a_wall():
    """The gap that is left is above 0, and less than the way of braking and of a step."""
    bearings = np.linspace(-1.0, 1.0, 41)
    moving = np.zeros((1, 2))
    at, fastest = 0.0, 0.0
    for _ in range(200):
        ranges = (2.0 - at) / np.cos(bearings)[None]
        out, _ = choose(ranges, bearings, moving, np.array([[9.0, 0.0]]))
        assert abs(out[0, 2]) < 0.5
        at += out[0, 0] * DT
        fastest = max(fastest, out[0, 0])
        if out[0, 0] == 0.0:
            break
    assert fastest > 0.5
    assert 0.0 < 2.0 - at - BOX.front - MARGIN < fastest**2 / (2.0 * LIMITS[2]) + fastest * DT


def test_a_row_does_not_depend_on_others():
    random = np.random.default_rng(5)
    bearings = np.linspace(-2.0, 2.0, 30)
    ranges = random.uniform(0.5, 3.0, (6, 30))
    goals = random.uniform(-3.0, 3.0, (6, 2))
    moving = random.uniform(0.0, 0.3, (6, 2))
    together, _ = choose(ranges, bearings, moving.copy(), goals)
    for i in range(6):
        alone, _ = choose(ranges[i : i + 1], bearings, moving[i : i + 1].copy(), goals[i : i + 1])
        assert alone.tobytes() == together[i].tobytes()


def test_what_it_passed_is_not_forgotten():
    """A place behind its rear corner, out of sight: it does not turn into it."""
    bearings = np.linspace(-1.0, 1.0, 21)
    ranges = np.full((1, 21), math.inf)
    goal = np.array([[0.0, 3.0]])
    free, _ = choose(ranges, bearings, np.zeros((1, 2)), goal)
    assert free[0, 2] > 0.1
    behind = np.array([[[-0.27, -0.24, 0.0], [9.0, 9.0, 0.0]]])
    held, arcs = choose(ranges, bearings, np.zeros((1, 2)), goal, behind=behind)
    poses = braked(held[0, 0], held[0, 2], LIMITS)
    assert nearest(poses, [(-0.27, -0.24)]) >= nearest(poses[:1], [(-0.27, -0.24)]) - 2e-3
    assert np.isnan(arcs[..., 2]).any()
    # An old place counts no more.
    behind[:, :, 2] = -60.0
    assert choose(ranges, bearings, np.zeros((1, 2)), goal, behind=behind)[0].tolist() == free.tolist()


def test_what_is_beside_it_is_kept():
    bearings = np.linspace(-2.0, 2.0, 41)
    beams = np.zeros((1, 5, 41))
    beams[0, 2:5] = bearings, np.cos(bearings), np.sin(bearings)
    ranges = np.full((1, 41), math.inf)
    ranges[0, 2], ranges[0, 20] = 0.5, 0.5
    behind = np.full((1, 3, 3), -1e30)
    pose = np.array([[1.0, 2.0, 0.5 * math.pi]])
    for time in (3.0, 4.0):
        scene = Scene(Sight(ranges, beams, column(1, 0.0), 1), column(1, 0.0), behind, column(1, time))
        keep_behind(scene, pose, np.zeros((1, 2)), 0, 1)
        place = 1.0 - 0.5 * math.sin(bearings[2]), 2.0 + 0.5 * math.cos(bearings[2])
        np.testing.assert_allclose(behind[0, 0], (*place, time), atol=1e-9)
        assert (behind[0, 1:, 2] < 0.0).all()  # what is ahead will be seen again
