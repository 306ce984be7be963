"""The angle at which beams meet surfaces, which a laser and a sonar tell if they are asked."""

import math

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.contracts import Aim
from amorsim.contracts.side import Side
from amorsim.core.maps.map import Map
from amorsim.core.shapes import Shape
from amorsim.sensors.incidence import PATCH
from amorsim.simulation.world.sensor_view import GroupView
from amorsim.simulation.world.world import World
from tests import building

CELL = 0.001


def look(sensor, map_, *poses, aim=None, thing=None, at=(0.0, 0.0, 0.0)):
    """What a sensor reads and tells at poses, each in a world of its own: alone, or with a `thing` that stands `at`."""
    names, shapes = (("rover",), (Shape.circle(0.05),)) if thing is None else (("a", "b"), (Shape.circle(0.05), thing))
    world = World(map_, names, shapes, len(poses))
    world.poses = np.array([each for pose in poses for each in (pose, at)[: len(names)]], dtype=float)
    rows = np.arange(len(poses)) * len(names)
    view = GroupView(world, rows, 0.1)
    view.body_pose = world.poses[rows]
    view.use(np.zeros((len(poses), 3)))
    stacked = am.core.rows.stack([sensor] * len(poses))
    return stacked.sense(view, aim or Aim(), {}, None)


def slanting(angle):
    """A long wall through (2, 0) whose normal is turned by `angle` from the x axis."""
    way = 5.0 * np.array([-math.sin(angle), math.cos(angle)])
    wall = np.array([[2.0 - way[0], -way[1], 2.0 + way[0], way[1]]])
    return Map.from_segments(wall, resolution=CELL, extent=(-6.0, -6.0, 8.0, 6.0))


# The ends of both probes and of the beam are each right to a cell's diagonal, across a wall that is seen over
# 2 PATCH at least.
BOUND = math.atan(2.0 * math.sqrt(2.0) * CELL / (2.0 * PATCH))


@pytest.mark.parametrize("degrees", [0.0, 10.0, 33.0, 45.0, 60.0])
def test_a_laser_tells_the_angle_to_a_slanting_wall(degrees):
    laser = am.sensors.Laser(beams=1, fov=0.1, range_max=8.0)
    ranges, side = look(laser, slanting(math.radians(degrees)), (0.0, 0.0, 0.0), (0.4, 0.1, 0.2), (0.3, 0.0, -0.2))
    assert np.isfinite(ranges).all()
    expected = [[math.radians(degrees)], [abs(math.radians(degrees) - 0.2)], [math.radians(degrees) + 0.2]]
    np.testing.assert_allclose(side["incidence"], expected, atol=BOUND)


def test_every_beam_of_a_scan_has_its_own_angle_right_into_the_corners():
    room = building.room(6.0, 5.0)
    x, y, heading = 2.3, 2.1, 0.4
    laser = am.sensors.Laser(beams=361, fov=2.0 * math.pi, range_max=20.0)
    ranges, side = look(laser, room, (x, y, heading))
    bearings = heading + laser.bearings()[0]
    end_x, end_y = x + ranges[0] * np.cos(bearings), y + ranges[0] * np.sin(bearings)
    on_side = np.minimum(end_x, 6.0 - end_x) < np.minimum(end_y, 5.0 - end_y)
    along, across = np.abs(np.cos(bearings)), np.abs(np.sin(bearings))
    expected = np.where(on_side, np.arctan2(across, along), np.arctan2(along, across))
    # Within PATCH of a corner, seen along the other wall, a probe lies round it.
    to_corner = np.where(on_side, np.minimum(end_y, 5.0 - end_y), np.minimum(end_x, 6.0 - end_x))
    clear = to_corner > 2.0 * PATCH / np.cos(expected)
    assert clear.sum() > 300
    np.testing.assert_allclose(side["incidence"][0][clear], expected[clear], atol=BOUND)


def test_past_an_edge_the_near_surface_counts():
    """A wall that ends a hand's breadth beside the beam, and another 3 m behind it."""
    walls = np.array([[2.0, -1.0, 2.0, 0.02], [5.0, -3.0, 5.0, 3.0]])
    map_ = Map.from_segments(walls, resolution=CELL, extent=(-1.0, -4.0, 6.0, 4.0))
    ranges, side = look(am.sensors.Laser(beams=1, fov=0.1), map_, (0.0, 0.0, 0.0))
    assert ranges[0, 0] == pytest.approx(2.0, abs=CELL)
    assert side["incidence"][0, 0] == pytest.approx(0.0, abs=2.0 * BOUND)


def test_where_nothing_returned_the_angle_is_nought():
    ranges, side = look(am.sensors.Laser(beams=5, range_max=1.0), building.empty(), (0.0, 0.0, 0.3))
    assert np.isinf(ranges).all()
    assert side["incidence"].tolist() == [[0.0] * 5]


@pytest.mark.parametrize(("heading", "expected"), [(0.0, 0.0), (8.0, 0.0), (-10.0, 0.0), (20.0, 8.0), (-40.0, 28.0)])
def test_a_sonar_meets_a_wall_straight_on_while_its_cone_has_the_normal(heading, expected):
    sonar = am.sensors.Sonar(half_angle=math.radians(12.0))
    _, side = look(sonar, slanting(0.0), (0.5, 0.0, math.radians(heading)))
    # Half of what lies between two rays of the cone comes on top.
    assert side["incidence"][0, 0] == pytest.approx(math.radians(expected), abs=BOUND + math.radians(0.025))


@pytest.mark.long
@pytest.mark.parametrize("traversal", ["exact", "bresenham"])
@pytest.mark.parametrize("has_post", [False, True])
def test_a_sonar_tells_the_same_step_by_step_as_if_asked_at_that_place(traversal, has_post):
    """From the second step on its own search also finds the walls; whether the first was the same is asked anew."""
    kept = []

    @attrs.frozen
    class Keeps(am.contracts.Noise):
        def corrupt(self, values, side, elapsed, state, draws):
            kept.append((values.copy(), side["incidence"].copy()))
            return values

    sonar = attrs.evolve(building.ring(8), half_angle=math.radians(15.0), traversal=traversal)
    sensors = {"encoder": building.encoder(), "sonar": am.MountedSensor(sensor=sonar, noise=building.chain(Keeps()))}
    post = am.Obstacle(name="post", shape=Shape.circle(0.3), pose=am.Pose(x=3.0, y=2.6))
    scenario = building.scenario(building.robot(sensors=sensors), obstacles=[post] if has_post else [])
    sim = am.Simulation(scenario, replicas=2)
    sim.drive("rover", forward=0.5, turn=np.array([0.4, -0.6]))
    poses = [sim.true_pose.copy()]
    for _ in range(12):
        sim.step()
        poses.append(sim.true_pose.copy())
    assert len(kept) == len(poses)
    thing = {"thing": post.shape, "at": (3.0, 2.6, 0.0)} if has_post else {}
    for at, (ranges, angles) in zip(poses, kept, strict=True):
        expected, side = look(sonar, building.room(), *at.tolist(), **thing)
        np.testing.assert_array_equal(ranges, expected)
        np.testing.assert_array_equal(angles, side["incidence"])
    assert np.ptp([angles for _, angles in kept], axis=0).max() > 0.1


def test_beams_that_are_bent_are_asked_where_they_look():
    laser = am.sensors.Laser(beams=3, fov=0.2)
    bend = np.array([[0.3, 0.3, 0.3]])
    _, side = look(laser, slanting(0.0), (0.0, 0.0, 0.0), aim=Aim(bearing=bend))
    np.testing.assert_allclose(side["incidence"], [[0.2, 0.3, 0.4]], atol=BOUND)


def test_nothing_is_worked_out_unless_it_is_asked_for_and_then_once():
    asked = []

    def make():
        asked.append(1)
        return np.zeros((1, 1))

    side = Side(incidence=make)
    assert "incidence" in side
    assert "colour" not in side
    assert list(side) == ["incidence"]
    assert len(side) == 1
    assert not asked
    assert side["incidence"] is side["incidence"]
    assert len(asked) == 1


@pytest.mark.parametrize("radius", [0.04, 0.05, 0.07, 0.3])
@pytest.mark.parametrize("distance", [0.5, 1.1, 4.5])
def test_a_round_post_is_met_straight_on_however_thin(radius, distance):
    """Somewhere in a sonar's cone its normal looks back; of rays 1/15 of 0.05 degrees apart the nearest is reported."""
    sonar = am.sensors.Sonar(half_angle=math.radians(15.0))
    post = Shape.circle(radius)
    poses = [(0.0, 0.0, math.radians(aside)) for aside in (-13.7, -3.33, 0.0, 0.02, 7.51, 14.2)]
    ranges, side = look(sonar, building.empty(), *poses, thing=post, at=(distance, 0.0, 0.0))
    np.testing.assert_allclose(ranges, distance - radius, atol=1e-4)
    aside = math.radians(0.05 / 15.0) / 2.0
    bound = math.asin(distance / radius * math.sin(aside))
    assert (side["incidence"] <= bound * (1.0 + 1e-6)).all()


def test_a_laser_tells_the_angle_to_a_round_post():
    """By the law of sines, in the triangle of the laser, the post's centre and where the beam meets it."""
    radius, distance = 0.05, 1.3
    off = np.array([0.0, 0.005, 0.02, 0.0375])
    poses = [(0.0, 0.0, angle) for angle in off.tolist()]
    laser = am.sensors.Laser(beams=1, fov=0.1)
    _, side = look(laser, building.empty(), *poses, thing=Shape.circle(radius), at=(distance, 0.0, 0.0))
    np.testing.assert_allclose(side["incidence"][:, 0], np.arcsin(distance * np.sin(off) / radius), atol=1e-9)


def test_a_side_of_a_box_has_one_slope_up_to_its_corners():
    box = Shape.rectangle(0.4, 0.4)
    laser = am.sensors.Laser(beams=1, fov=0.1)
    poses = [(0.0, y, 0.0) for y in (-0.23, -0.2, 0.0, 0.2, 0.23)]  # the corners are 0.283 m to either side
    _, side = look(laser, building.empty(), *poses, thing=box, at=(2.0, 0.0, math.radians(45.0)))
    np.testing.assert_allclose(side["incidence"], math.radians(45.0), atol=1e-9)
    _, side = look(laser, building.empty(), (0.0, 0.0, 0.0), thing=box, at=(2.0, 0.0, math.radians(20.0)))
    np.testing.assert_allclose(side["incidence"], math.radians(20.0), atol=1e-9)


def test_a_body_before_a_wall_leaves_the_slope_of_the_wall():
    """The post stands beside the beam, where the wall is felt for: it is not part of the wall."""
    laser = am.sensors.Laser(beams=1, fov=0.1)
    post = Shape.circle(0.03)
    _, side = look(laser, slanting(0.4), (0.0, 0.0, 0.0), thing=post, at=(1.95, 0.04, 0.0))
    np.testing.assert_allclose(side["incidence"], 0.4, atol=BOUND)


def test_a_rounded_box_has_the_normals_of_its_sides_and_of_its_corners():
    box = Shape.polygon([(-0.2, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.2, 0.2)], rounding=0.1)
    laser = am.sensors.Laser(beams=1, fov=0.1)
    poses = [(0.0, y, 0.0) for y in (0.0, 0.15, 0.25, 0.28)]
    _, side = look(laser, building.empty(), *poses, thing=box, at=(2.0, 0.0, 0.0))
    expected = [0.0, 0.0, math.asin(0.05 / 0.1), math.asin(0.08 / 0.1)]
    np.testing.assert_allclose(side["incidence"][:, 0], expected, atol=1e-9)
