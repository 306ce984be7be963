"""Avoiders that choose a direction."""

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.kernels.avoidance.histogram import block_sectors
from tests.controllers.test_dwa import make, said, simulate

POSTS = [(x, y, x, y + 0.3) for x, y in ((2.0, -0.2), (3.5, 0.6), (3.5, -1.2))]
TRAP = [(2.5, -1.0, 2.5, 1.0), (2.5, -1.0, 1.0, -1.0), (2.5, 1.0, 1.0, 1.0)]
KINDS = [
    am.controllers.VfhPlus,
    am.controllers.NearnessDiagram,
    am.controllers.PotentialField,
    am.controllers.Bug2,
    am.controllers.TangentBug,
]


@pytest.mark.parametrize("kind", KINDS)
def test_it_passes_posts(kind):
    simulation = simulate([make(kind(goals=((6.0, 0.3),), speed=0.5))], POSTS, duration=60.0)
    assert said(simulation) == [("rover", "goal_reached", "1 of 1")]


@pytest.mark.parametrize("kind", [am.controllers.VfhPlus, am.controllers.PotentialField])
def test_a_trap_stops_it_and_it_says_so(kind):
    simulation = simulate([make(kind(goals=((6.0, 0.0),), speed=0.5, patience=8.0))], TRAP, duration=40.0)
    assert ("rover", "blocked", "no progress") in said(simulation)
    assert simulation.active.all()  # and it touched nothing


def test_bug2_gets_out_of_a_trap():
    controller = am.controllers.Bug2(goals=((6.0, 0.0),), speed=0.5, patience=100.0)
    sensor = am.sensors.Laser(beams=181, fov=math.radians(360.0), range_max=6.0)
    simulation = simulate([make(controller, sensor=sensor, shape=am.Shape.circle(0.2))], TRAP, duration=90.0)
    assert said(simulation) == [("rover", "goal_reached", "1 of 1")]


def test_sectors_are_blocked_as_the_enlarged_circles_say():
    random = np.random.default_rng(1)
    sectors, room, far = 72, 0.3, 2.0
    for _ in range(50):
        points = random.uniform(-2.5, 2.5, (2, 6))
        blocked = np.empty(sectors, dtype=bool)
        block_sectors(points, room, far, blocked)
        distance, bearing = np.hypot(*points), np.arctan2(points[1], points[0])
        expected = np.zeros(sectors, dtype=bool)
        low = -math.pi + np.arange(sectors) * 2.0 * math.pi / sectors
        for d, b in zip(distance, bearing, strict=True):
            if d > far:
                continue
            half = math.asin(room / d) if d > room else 0.5 * math.pi
            # A sector is free if all of it is more than `half` off the point's direction.
            for turn in (-2.0 * math.pi, 0.0, 2.0 * math.pi):
                expected |= (low + 2.0 * math.pi / sectors > b + turn - half) & (low < b + turn + half)
        assert blocked.tolist() == expected.tolist()


def test_vfh_does_not_swing_between_two_equal_openings():
    """A post straight ahead: it keeps to the side that it took first."""
    controller = am.controllers.VfhPlus(goals=((6.0, 0.0),), speed=0.5)
    simulation = simulate([make(controller)], [(3.0, -0.3, 3.0, 0.3)], duration=0.0)
    sides = []
    for _ in range(150):
        simulation.step()
        bearing = simulation.frames()[0].beliefs["controller"]["bearing"][0, 0]
        x, _, heading = simulation.true_pose[0]
        if 1.6 < x < 2.6:
            sides.append(math.copysign(1.0, heading + bearing))
        assert math.isfinite(bearing)
    assert len(sides) > 5
    assert len(set(sides)) == 1
