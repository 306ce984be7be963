"""Which segment of a bumper is pressed: after real collisions, and against shapely."""

import itertools
import math

import numpy as np
import pytest
import shapely

import amorsim as am
from amorsim.core.parameters import ParameterError
from amorsim.core.shapes import Shape
from amorsim.scenario.spec import MountedSensor, Pose
from amorsim.sensors import Bumper, Sector
from tests.building import robot, scenario
from tests.sensors.sight import placed, random_scene

QUARTERS = tuple(Sector(start=math.radians(a), end=math.radians(a + 90)) for a in (-45, 45, 135, 225))
FRONT, LEFT, BACK, RIGHT = range(4)


def pressed(sim, name="rover", replica=None):
    return np.flatnonzero(sim.robot(name, replica).readings["bumper"].true).tolist()


def bumping(shape=Shape.circle(0.2), pose=Pose(x=3.0, y=2.5), **mounted):  # noqa: B008 - frozen
    unit = MountedSensor(sensor=Bumper(segments=QUARTERS), **mounted)
    return robot(shape=shape, pose=pose, sensors={"bumper": unit}, estimators={})


@pytest.mark.parametrize(
    "shape",
    [
        Shape.circle(0.2),
        Shape.rectangle(0.5, 0.3),
        Shape.polygon([(-0.2, -0.1), (0.2, -0.1), (0.2, 0.1), (-0.2, 0.1)], rounding=0.05),
    ],
)
@pytest.mark.parametrize(("forward", "segment"), [(0.7, FRONT), (-0.7, BACK)])
def test_a_robot_that_drives_into_a_wall_presses_that_end(shape, forward, segment):
    sim = am.Simulation(scenario(bumping(shape)))
    assert pressed(sim) == []
    sim.robot("rover").drive(forward=forward)
    while not sim.events:
        assert pressed(sim) == []
        sim.step()
    assert pressed(sim) == [segment]
    sim.robot("rover").drive(forward=-forward)  # by hand, though its controller ended
    sim.step()
    assert pressed(sim) == [segment]


def test_both_robots_that_meet_feel_it_where_they_touch_and_no_other_replica_does():
    one, other = bumping(pose=Pose(x=2.0, y=2.0)), bumping(pose=Pose(x=3.0, y=2.0, heading=math.pi / 2))
    robots = [robot_with(one, "a"), robot_with(other, "b")]
    sim = am.Simulation(scenario(*robots), replicas=3)
    sim.robot("a", 1).drive(forward=0.5)
    for _ in range(20):
        sim.step()
    assert [event.replica for event in sim.events if event.kind == "collision"] == [1, 1]
    assert (pressed(sim, "a", 1), pressed(sim, "b", 1)) == ([FRONT], [LEFT])
    for replica in (0, 2):
        assert pressed(sim, "a", replica) == pressed(sim, "b", replica) == []


def robot_with(robot_, name):
    import attrs

    return attrs.evolve(robot_, name=name)


@pytest.mark.parametrize(
    ("heading", "found"),
    [(0.0, [FRONT, LEFT]), (math.pi / 4 - 0.1, [FRONT, LEFT]), (math.pi / 4 + 0.1, [FRONT, RIGHT])],
)
def test_in_a_corner_two_segments_are_pressed(heading, found):
    assert pressed(am.Simulation(scenario(bumping(pose=Pose(x=5.794, y=4.794, heading=heading))))) == found


def test_sectors_are_seen_from_the_mount_and_turn_with_it():
    wall = Pose(x=5.796, y=2.0)  # 3.5 mm from the wall's cell, to the east
    for heading, segment in ((0.0, FRONT), (math.pi / 2, RIGHT), (math.pi, BACK)):
        mounted = bumping(pose=wall, mount=am.Mount(heading=heading))
        assert pressed(am.Simulation(scenario(mounted))) == [segment]


def test_the_default_tells_left_from_right():
    for turn, values in ((0.3, [0.0, 1.0]), (-0.3, [1.0, 0.0])):
        one = robot(
            shape=Shape.circle(0.2),
            pose=Pose(x=5.796, y=2.0, heading=turn),
            sensors={"bumper": Bumper()},
            estimators={},
        )
        assert am.Simulation(scenario(one)).robot("rover").readings["bumper"].true.tolist() == values


def check_scene(seed):
    """One scene against shapely: each sector's part of the outline, grown; how many segments were pressed."""
    random = np.random.default_rng(seed)
    edges = np.sort(random.uniform(-math.pi, math.pi, 5))
    sectors = tuple(Sector(start=a, end=b) for a, b in itertools.pairwise(edges.tolist()))
    reach = 0.25  # much, so that there is something to feel
    scene = random_scene(seed, Bumper(segments=sectors, reach=reach), bodies=14, marks=0)
    shape = scene.sim.scenario.robots[0].shape
    x, y, heading = scene.pose
    pose = Pose(x=x, y=y, heading=heading)
    outline = placed(shape, pose).exterior
    found = scene.sim.robot("rover").readings["eye"].true
    count = 0
    for sector, value in zip(sectors, found, strict=True):
        # A fan of triangles from the base point, fine enough that their far sides clear the outline.
        angles = heading + np.linspace(sector.start, sector.end, 400)
        far = [(x + 3.0 * math.cos(a), y + 3.0 * math.sin(a)) for a in angles]
        part = outline.intersection(shapely.Polygon([(x, y), *far]))
        gap = min(part.distance(other) for other in (scene.walls, *scene.bodies.values()))
        if abs(gap - reach) < 1e-3:  # arcs have chords in their place
            continue
        assert value == (gap < reach), (seed, sector)
        count += int(value)
    return count


@pytest.mark.long
def test_a_dozen_random_scenes_agree_with_shapely():
    assert 5 < sum(check_scene(seed) for seed in range(12)) < 43


@pytest.mark.long
def test_eighty_random_scenes_agree_with_shapely():
    assert 40 < sum(check_scene(seed) for seed in range(1000, 1080)) < 290


@pytest.mark.nightly
def test_three_hundred_random_scenes_agree_with_shapely():
    assert 150 < sum(check_scene(seed) for seed in range(1000, 1300)) < 1100


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda: Bumper(segments=()), "segments"),
        (lambda: Bumper(reach=0.0), "reach"),
        (lambda: Sector(start=1.0, end=1.0), "end"),
        (lambda: Sector(start=-3.0, end=4.0), "end"),
    ],
)
def test_what_makes_no_sense_is_refused_by_name(make, name):
    with pytest.raises(ParameterError, match=name):
        make()
