"""Remarks on what is hardly meant."""

import tomllib
from pathlib import Path

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.scenario.knowledge import Knowledge
from amorsim.scenario.reading.read import loads
from amorsim.scenario.spec import Landmark, Light
from amorsim.simulation.lint import advice
from amorsim.worlds.drawn import map_of
from tests.building import robot, room, scenario


@pytest.mark.parametrize(
    ("landmarks", "lights", "paths"),
    [
        ([Landmark(id=1, x=6.0, y=2.0)], [Light(x=1.0, y=1.0)], []),  # on the wall, and seen
        ([Landmark(id=1, x=1.0, y=1.0), Landmark(id=2, x=7.0, y=2.0)], [], ["landmarks.1"]),
        ([Landmark(id=1, x=6.0002, y=2.0, radius=0.0)], [], ["landmarks.0"]),
        ([], [Light(x=1.0, y=1.0), Light(x=0.0, y=2.0)], ["lights.1"]),
    ],
)
def test_marks_and_lamps_that_nobody_can_see_are_remarked_on(landmarks, lights, paths):
    found = advice(scenario(map=room(), landmarks=landmarks, lights=lights))
    assert [remark.partition(":")[0] for remark in found] == paths


@pytest.mark.parametrize(
    ("error", "remark"),
    [
        ({"value": 1.02}, "robots.rover.errors.drive.track: the true value is 1.02, where the robot believes in 0.33; "
                          "a factor is written { scale = 1.02 }"),
        ({"value": 0.34}, ""),
        ({"value": 0.6}, ""),  # a wide robot
        ({"scale": 1.02}, ""),
        ({"value": am.Distribution(kind="normal", values=(1.0, 0.1))}, ""),
    ],
)  # fmt: skip
def test_a_value_that_is_hardly_one_but_a_factor_is_remarked_on(error, remark):
    found = advice(scenario(robot(name="rover", errors={"drive.track": am.Deviation(**error)}), map=room()))
    assert found == ([remark] if remark else [])


def remarks(*robots, **changes):
    return advice(scenario(*robots, map=room(), **changes))


@pytest.mark.parametrize(
    ("place", "problem"),
    [
        ((5.0, 2.0), ""),
        ((6.0, 2.0), "(6, 2) m is in a wall; it cannot get there"),
        ((7.5, 2.0), "(7.5, 2) m is outside the map, which is 6 m x 5 m from (0, 0) m on; it cannot get there"),
    ],
)
def test_places_where_nobody_gets_are_remarked_on(place, problem, tmp_path):
    ways = ((1.0, 1.0), place)
    (tmp_path / "track.csv").write_text(f"time,x,y\n0,1,1\n1,{place[0]},{place[1]}\n")
    makes = am.motions
    motions = {
        "motion.waypoints.1": makes.Loop(waypoints=ways),
        "motion.goals.1": makes.Pedestrian(goals=ways),
        "motion.file": makes.Track(file=str(tmp_path / "track.csv")),
    }
    for path, motion in motions.items():
        thing = am.Obstacle(name="it", shape=am.Shape.circle(0.2), motion=motion)
        expected = [f"obstacles.it.{path}: {problem}"] if problem else []
        assert [found for found in remarks(obstacles=[thing]) if found.startswith("obstacles")] == expected
    controllers = {
        "waypoints.1": am.controllers.Pursuit(waypoints=ways),
        "x": am.controllers.GoTo(x=place[0], y=place[1]),
    }
    for path, controller in controllers.items():
        expected = [f"robots.rover.controller.{path}: {problem}"] if problem else []
        assert remarks(robot(controller=controller)) == expected


WALLS = [(0, 0, 10, 0), (10, 0, 10, 5), (10, 5, 0, 5), (0, 5, 0, 0)]


def two_rooms(gap: float, resolution: float = 0.001):
    """Two rooms of 5 m x 5 m, and a way of a width between them, slanted where the wall is a metre thick."""
    low, high = 2.5 - gap / 2, 2.5 + gap / 2
    halves = [(5, 0, 5, low), (5, high, 5, 5)] if gap else [(5, 0, 5, 5)]
    return am.Map.from_segments([*WALLS, *halves], resolution=resolution)


@pytest.mark.parametrize("resolution", [0.001, 0.05])
@pytest.mark.parametrize(("gap", "is_shut"), [(0.0, True), (0.3, True), (0.6, False), (1.0, False)])
@pytest.mark.parametrize("place", [(8.0, 2.0), (9.9, 4.9), (5.1, 4.0)])
def test_places_behind_walls_are_remarked_on(gap, is_shut, place, resolution):
    """Not those behind a gap through which the body may fit: a disc of 0.4 m."""
    ways = ((1.0, 1.0), (2.0, 2.0), place)
    driver = robot(shape=am.Shape.circle(0.2), controller=am.controllers.Pursuit(waypoints=ways))
    found = advice(scenario(driver, map=two_rooms(gap, resolution)))
    problem = (
        f"robots.rover.controller.waypoints.2: ({place[0]:g}, {place[1]:g}) m is walled off from where it starts; "
        "it cannot get there"
    )
    assert found == ([problem] if is_shut else [])


def test_what_is_not_certain_is_not_remarked_on():
    world = two_rooms(0.0)
    for changes in (
        {"pose": None, "start": am.RandomStart()},  # in which room is not known
        {"pose": am.Pose(x=8.0, y=2.5)},
        {"shape": am.Shape.rectangle(0.4, 0.4, x=1.0)},  # beside its base point, which walls may shut off
    ):
        far = am.controllers.Pursuit(waypoints=((6.0, 1.0), (8.0, 2.0)))
        assert advice(scenario(robot(**({"controller": far} | changes)), map=world)) == []


def test_the_bundled_scenarios_get_no_remark_on_ways():
    for name in ("car-park", "crowd", "doors", "yard", "synchro-hall"):
        assert [remark for remark in advice(am.load(name)) if "walled off" in remark] == []


def test_of_many_places_and_of_a_crowd_little_is_said():
    walk = am.motions.Pedestrian(goals=tuple((9.0, float(i)) for i in range(10)))
    crowd = [am.Obstacle(name=f"p{i}", shape=am.Shape.circle(0.2), motion=walk) for i in range(5)]
    found = remarks(obstacles=crowd)
    assert len(found) == 4
    assert found[-1] == "obstacles.p0.motion: so are 7 more of the 10 places on its route"


def test_marks_that_cannot_be_distinguished_are_remarked_on():
    known = Knowledge(landmarks=((1.0, 1.0), (2.0, 2.0), (3.0, 3.0)), landmark_ids=(4, 0, 4))
    found = remarks(
        robot(fiducial=2, knowledge=known),
        landmarks=[Landmark(id=i, x=1.0 + 0.1 * n, y=1.0) for n, i in enumerate((1, 2, 3, 1))],
        obstacles=[am.Obstacle(name="post", shape=am.Shape.circle(0.2), fiducial=3)],
    )
    assert found == [
        "landmarks.1.id: robots.rover carries 2 too; a sensor cannot know which of them it sees",
        "landmarks.2.id: obstacles.post carries 3 too; a sensor cannot know which of them it sees",
        "landmarks.3.id: landmarks.0 carries 1 too; a sensor cannot know which of them it sees",
        "robots.rover.knowledge.landmarks: more than one has the id 4; expected each id once",
    ]


def forest(density):
    """A scenario whose replicas have forests of their own, and a robot that goes to (0, 0)."""
    text = f"""
        format = 1
        [world]
        map = {{ generate = "forest", seed = 7, size = [7, 6], per = "replica", density = {density} }}
        [[robots]]
        name = "rover"
        model = "pioneer2dx"
        controller = {{ use = "goto", x = 0.0, y = 0.0 }}
    """
    return loads(tomllib.loads(text), Path())


def test_where_replicas_have_different_maps_the_first_few_are_looked_at():
    given = forest(0.6)
    first, other = given.map, map_of(given.map, 1)
    cells = first.to_array(), other.to_array()
    for is_wall, expected in ((0, "is in a wall; it cannot get there (replica 1)"), (1, "is in a wall; it cannot")):
        row, col = np.argwhere((cells[0] == is_wall) & (cells[1] == 1))[-1]
        x, y = np.array([col + 0.5, row + 0.5]) * first.resolution + first.origin[:2]
        goal = am.controllers.GoTo(x=float(x), y=float(y))
        found = advice(attrs.evolve(given, robots=[attrs.evolve(given.robots[0], controller=goal)]))
        assert any(remark.startswith("robots.rover.controller.x") and expected in remark for remark in found), found
        assert ("(replica 1)" in "".join(found)) == (not is_wall)


def test_a_replica_without_a_world_is_remarked_on():
    found = advice(forest("{ uniform = [0.1, 8.0] }"))
    assert any(remark.startswith("world.map: replica 3 has no world: Forest") for remark in found), found
