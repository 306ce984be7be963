"""Where bodies start: many at once, on a grid, at random; and the error if a place is not free."""

from __future__ import annotations

import re
import tomllib

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.core.maps.footprint_room import freest_start, wall_gaps
from amorsim.scenario.files.resolved import resolved_table
from amorsim.scenario.files.write import table_text
from amorsim.scenario.reading.read import loads
from amorsim.scenario.reading.starts import GridStart
from amorsim.scenario.toml.angles import parse_float
from amorsim.simulation.fleet import placing
from tests import building

GRID = "grid = [1.0, 1.0], spacing = 0.25"
HEAD = 'format = 1\n[world]\nmap = "room.wld"\nresolution = 0.01\n'
SWARM = (
    HEAD
    + """
[[robots]]
name = "r"
count = 12
model = "pioneer2dx"
shape = { circle = 0.1 }
start = { random = "anywhere" }
[[obstacles]]
name = "p"
count = 10
shape = { circle = 0.1 }
start = { random = [0.5, 0.5, 2.0, 2.5], clearance = 0.05, heading_deg = 90, per = "study" }
[[obstacles]]
shape = { rectangle = [0.4, 0.2] }
pose = { x = 3.0, y = 2.0 }
"""
)


def again(scenario, folder, registry):
    text = table_text(resolved_table(scenario, registry=registry))
    return text, loads(tomllib.loads(text, parse_float=parse_float), folder, registry=registry)


def bodies(sim, replica=0):
    world = sim._fleet.world
    return world.poses[world.first[replica] : world.first[replica + 1]]


def gaps_within(sim):
    """The smallest gap between two bodies of a replica, and to walls."""
    world = sim._fleet.world
    a, b = world.pairs_within(world.poses, np.full(len(world.poses), 0.5))
    cap = np.full(len(a), 1.0)
    walls, _ = world.wall_gaps(world.everyone, world.poses, np.full(len(world.everyone), 1.0))
    return world.body_gaps(a, world.poses[a], b, world.poses[b], cap), a, b, walls


def test_many_have_names_with_numbers_and_one_model(read):
    scenario = read(SWARM)
    assert [robot.name for robot in scenario.robots[:2]] == ["r00", "r01"]
    assert [obstacle.name for obstacle in scenario.obstacles] == [f"p{i:02d}" for i in range(10)] + ["obstacle2"]
    assert scenario.robots[0].drive is scenario.robots[11].drive
    big = read(SWARM.replace("count = 12", "count = 1000").replace("circle = 0.1", "circle = 0.01"))
    assert (big.robots[0].name, big.robots[-1].name) == ("r0000", "r0999")


def test_random_starts_are_free_differ_by_replica_or_study_and_come_again(read):
    scenario = read(SWARM)
    sim = am.Simulation(scenario, replicas=3)
    gaps, _, _, walls = gaps_within(sim)
    assert gaps.min() >= 0.0
    assert walls.min() >= 0.0
    box = bodies(sim)[sim._fleet.world.names.index("p00") :][:10]
    assert (box[:, :2] >= (0.5, 0.5)).all()
    assert (box[:, :2] <= (2.0, 2.5)).all()
    assert box[:, 2] == pytest.approx(np.pi / 2)
    drawn = [bodies(sim, replica) for replica in range(3)]
    chosen = np.array([name.startswith("p") for name in sim._fleet.world.names])
    assert (drawn[0][chosen] == drawn[1][chosen]).all()
    assert (drawn[0][~chosen] != drawn[1][~chosen]).any()
    alone = am.Simulation(scenario, replicas=[2])
    assert (bodies(alone) == drawn[2]).all()
    other = am.Simulation(scenario, seed=5)
    assert (bodies(other) != drawn[0]).any()
    sim.reset(seed=5)
    assert (bodies(sim) == bodies(other)).all()


def test_clearance_is_kept(read):
    sim = am.Simulation(read(SWARM), replicas=2)
    world = sim._fleet.world
    gaps, a, b, walls = gaps_within(sim)
    mine = np.array([world.name(body).startswith("p") for body in world.everyone])
    assert gaps[mine[a] | mine[b]].min() >= 0.05
    assert walls[mine].min() >= 0.05


def crowded(count, radius=0.1, **start):
    random = am.RandomStart(**({"random": (0.5, 0.5, 4.5, 4.5)} | start))
    post = am.Shape.circle(radius)
    crowd = [am.Obstacle(name=f"o{i:03d}", shape=post, start=random) for i in range(count)]
    return building.scenario(obstacles=crowd, seed=2)


def test_more_than_there_is_room_for_is_reported_before_a_try_is_made(monkeypatch):
    monkeypatch.setattr("amorsim.simulation.fleet.placing._draw", None)
    # 1000 circles, as polygons of 64 sides: 1000 * 32 sin(2 pi / 64) * 0.01 m2. With margins the box is 4.2 m wide.
    with pytest.raises(
        am.ScenarioError, match=r"obstacles.o000.start: the 1000 .* in the box 0.5, .* cover 31.37 m2"
    ) as caught:
        am.Simulation(crowded(1000))
    assert "there are 17.64 m2 at most; expected more room" in str(caught.value)
    with pytest.raises(am.ScenarioError, match=r"on the map cover 31.37 m2, and there are 30 m2 at most"):
        am.Simulation(crowded(1000, random="anywhere"))


def test_of_far_too_many_it_is_reported_soon():
    # They cover half more than circles put down at random can, 0.547 of the plane.
    with pytest.raises(am.ScenarioError) as caught:
        am.Simulation(crowded(450))
    found = re.search(
        r"(\d+) of 450 .* no free place in (\d+) tries \(o\d+.*\), and too few in the last", str(caught.value)
    )
    assert found, caught.value
    assert 64 <= int(found[2]) <= 256
    assert int(found[1]) > 100


def test_nobody_is_given_up_who_may_find_a_place_in_the_end():
    one_left = [np.array([3, 0])] * 600
    few = [np.array([max(20 - t // 30, 0)]) for t in range(600)]
    many = [np.array([2000 - t]) for t in range(600)]  # one a try, and 1400 left to go for 400
    for t in placing._LOOKS:
        assert not placing._is_hopeless(one_left[: t + 1])
        assert not placing._is_hopeless(few[: t + 1])
    assert placing._is_hopeless(many[:513])
    assert placing._is_hopeless([np.array([0, 500])] * 65)  # each replica by itself
    assert not placing._is_hopeless([np.array([0, 100])] * 65)


def test_starts_do_not_depend_on_who_stands_where_in_the_file(read):
    scenario = read(SWARM)
    there = am.Simulation(scenario)
    back = am.Simulation(
        am.Scenario(map=scenario.map, robots=scenario.robots[::-1], obstacles=scenario.obstacles[::-1])
    )
    assert (bodies(there) == bodies(back)).all()


def test_a_grid(read):
    text = SWARM.replace(
        'start = { random = "anywhere" }', "start = { grid = [0.5, 0.3], spacing = 0.3, heading_deg = 90 }"
    )
    robots = read(text).robots
    assert (robots[0].pose.x, robots[0].pose.y) == (0.5, 0.3)
    assert robots[1].pose.x == pytest.approx(0.8)
    assert (robots[4].pose.x, robots[4].pose.y) == (0.5, pytest.approx(0.6))  # four in a row: about as many as rows
    assert read(text.replace("spacing = 0.3", "spacing = 0.3, columns = 2")).robots[2].pose.y == pytest.approx(0.6)


@pytest.mark.parametrize("grid", [False, True])
def test_many_are_written_as_one_table_and_read_again(read, folder, registry, grid):
    text = SWARM
    if grid:
        text = SWARM.replace(
            'start = { random = "anywhere" }', "start = { grid = [0.4, 0.3], spacing = 0.31, heading_deg = 33.3 }"
        )
    scenario = read(text)
    written, same = again(scenario, folder, registry)
    assert written.count("[[robots]]") == 1
    assert written.count("[[obstacles]]") == 2
    assert [robot.name for robot in same.robots] == [robot.name for robot in scenario.robots]
    assert [robot.pose for robot in same.robots] == [robot.pose for robot in scenario.robots]
    assert am.Simulation(same).digest() == am.Simulation(scenario).digest()


def test_numbers_alone_make_no_series(read, folder, registry):
    text = HEAD + "".join(
        f'[[robots]]\nname = "{name}"\nmodel = "pioneer2dx"\npose = {{ x = {x} }}\n'
        for name, x in (("r0", 1), ("r1", 2))
    )
    written, same = again(read(text), folder, registry)
    assert written.count("[[robots]]") == 2  # each has been read by itself, and may differ
    assert [robot.name for robot in same.robots] == ["r0", "r1"]


@pytest.mark.parametrize(
    ("old", "new", "path", "message"),
    [
        ("count = 12", "count = 0", "robots.0.count", "whole number >= 1"),
        ("count = 12", "count = 1.5", "robots.0.count", "whole number >= 1"),
        ('start = { random = "anywhere" }\n', "", "robots.0.start", "12 of them cannot start at one place"),
        ('random = "anywhere"', "", "robots.0.start", "expected { random"),
        ('random = "anywhere"', 'random = "everywhere"', "robots.0.start.random", "'anywhere'"),
        ('random = "anywhere"', "random = [3, 0, 1, 1]", "robots.0.start.random", "expected xmin <= xmax"),
        ('random = "anywhere"', "grid = [1, 1]", "robots.0.start.spacing", "missing"),
        ('random = "anywhere"', "poses = [{ x = 1 }]", "robots.0.start.poses", "a pose for each of the 12, got 1"),
        ('random = "anywhere" }', 'random = "anywhere" }\npose = { x = 1 }', "robots.0.start", "got both"),
    ],
)
def test_faults(faults, old, new, path, message):
    found = faults(SWARM.replace(old, new, 1))
    assert message in found[path], found


def test_two_series_whose_names_meet_are_a_fault(faults):
    found = faults(SWARM.replace('name = "p"', 'name = "r"', 1))
    assert "robots.0 is called 'r00' too" in found["obstacles.0.name"]


def test_names_that_meet_are_a_fault_whatever_else_is_wrong(faults):
    found = faults(SWARM.replace('name = "p"', 'name = "r"\nheight = -1', 1))
    assert set(found) == {"obstacles.0.name", "obstacles.0.height"}


def test_too_many_are_reported_clearly(read, faults):
    found = faults(SWARM.replace("count = 12", "count = 1000"))
    assert (
        "1000 of them cover 31.37 m2, and there are 12 m2 on the map at most: expected 382" in (found["robots.0.count"])
    )
    with pytest.raises(
        am.ScenarioError, match=r"robots.r\d+.start: \d+ of 250 that start at random on the map found no free"
    ):
        am.Simulation(read(SWARM.replace("count = 12", "count = 250")))
    alike = [attrs.evolve(robot, name=f"r{i:04d}") for i, robot in enumerate(read(SWARM).robots[:1] * 1000)]
    with pytest.raises(
        am.ScenarioError, match=r"robots.r0000.start: the 1000 that start at random on the map cover 31.37 m2"
    ):
        am.Simulation(attrs.evolve(read(SWARM), robots=alike))


@pytest.mark.long
def test_more_than_memory_holds_are_refused_before_any_is_made(faults, monkeypatch):
    monkeypatch.setattr("amorsim.core.execution.memory.memory_of_machine", lambda: 1_000_000_000)
    made = []
    monkeypatch.setattr(GridStart, "pose", lambda self, number, count: made.append(number) or am.Pose(x=1.0, y=1.0))
    found = faults(SWARM.replace("count = 12", "count = 900000").replace('random = "anywhere"', GRID))
    shares = re.search(
        r"900000 of them would take ([\d.]+) GB of memory at least, .* 1 GB: expected (\d+) at most",
        found["robots.0.count"],
    )
    assert shares
    assert float(shares[1]) / 900_000 == pytest.approx(1.0 / float(shares[2]), rel=0.01)
    assert len(made) < 10


def test_more_replicas_than_memory_holds_are_refused(monkeypatch):
    monkeypatch.setattr("amorsim.core.execution.memory.memory_of_machine", lambda: 1_000_000_000)
    with pytest.raises(am.AmorsimError, match=r"^1000000000 replicas: they would take .* GB of memory at least, .*"):
        am.Simulation(building.scenario(), replicas=1_000_000_000)
    am.Simulation(building.scenario(), replicas=3)


def test_a_grid_that_leaves_the_map_is_reported_once_and_at_once(faults):
    found = faults(SWARM.replace("count = 12", "count = 1000").replace('random = "anywhere"', GRID))
    assert re.search(
        r"^number \d+ of the 1000 would stand at \(.*\) m: that is outside the map, .*; expected fewer,",
        found["robots.0.start"],
    )


def test_of_a_series_in_the_way_of_itself_the_first_is_reported_and_how_many(file):
    path = file(SWARM.removeprefix(HEAD).replace('random = "anywhere"', GRID.replace("0.25", "0.15")))
    with pytest.raises(am.ScenarioError) as caught:
        am.load(path)
    (fault,) = caught.value.faults
    assert fault.path == "robots.0.start"
    assert fault.message == "r01: overlaps 'r00'; expected room between them; 11 of the 12 do not stand free"


# ------------------------------------------------------------------------------ starts that are not free


@pytest.fixture
def file(tmp_path, folder):
    (tmp_path / "room.wld").write_bytes((folder / "room.wld").read_bytes())

    def write(text):
        (tmp_path / "s.toml").write_text(HEAD + text)
        return tmp_path / "s.toml"

    return write


ROVER = '[[robots]]\nname = "rover"\nmodel = "pioneer2dx"\npose = { x = 2.0, y = 1.5 }\n'


def test_a_start_in_a_wall_is_reported_beside_other_faults(file):
    path = file(ROVER.replace("x = 2.0", "x = 4.0") + "colour = 3\n")
    with pytest.raises(am.ScenarioError) as caught:
        am.load(path)
    assert {fault.path for fault in caught.value.faults} == {"robots.0.pose", "robots.0.colour"}
    assert all(fault.file == str(path) for fault in caught.value.faults)


@pytest.mark.parametrize(
    ("x", "words"),
    [
        ("44.0", "(44.000, 1.500) m is outside the map, which is "),
        ("-0.5", "(-0.500, 1.500) m is outside the map, which is "),
        ("4.0", "at (4.000, 1.500) m the footprint overlaps a wall near (4.000, 1.377) m"),
        ("0.1", "at (0.100, 1.500) m the footprint overlaps a wall near (0.000, "),
    ],
)
@pytest.mark.parametrize("by", ["the file", "the true pose"])
def test_a_start_outside_the_map_is_distinguished_from_one_in_a_wall(file, x, words, by):
    text = ROVER.replace("x = 2.0", f"x = {x}") if by == "the file" else ROVER + f"errors.pose.x = {x}\n"
    with pytest.raises(am.ScenarioError) as caught:
        am.Simulation(am.load(file(text)))
    (fault,) = caught.value.faults
    assert words in fault.message
    assert fault.message.endswith("expected a free place")


def test_the_edge_of_a_map_without_walls_is_called_so():
    rover = building.robot(pose=am.Pose(x=4.9, y=0.0))
    with pytest.raises(am.ScenarioError, match=r"overlaps the edge of the map near \(5.000, -?0"):
        am.Simulation(building.scenario(rover, map=building.empty(10.0)))


@pytest.mark.parametrize(
    "setting", ["robots.rover.pose.x=4.0", "robots.0.pose={x=4.0, y=1.5}", "robots.0.pose.x = 4.0"]
)
def test_the_setting_is_blamed_that_put_it_there(file, setting):
    with pytest.raises(am.ScenarioError) as caught:
        am.load(file(ROVER), [setting])
    (fault,) = caught.value.faults
    assert fault.file == f"--set {setting}"
    assert "the footprint overlaps a wall" in fault.message


def test_two_at_one_place_and_a_map_whose_start_has_no_room(file):
    other = ROVER.replace("rover", "other")
    with pytest.raises(am.ScenarioError, match=r"robots.other.pose: overlaps 'rover'"):
        am.load(file(ROVER + other))
    big = ROVER.replace("pose = { x = 2.0, y = 1.5 }", "shape = { circle = 1.2 }")
    with pytest.raises(am.ScenarioError, match=r"robots.rover.pose: missing, and at \(1.000, 1.500\) m the footprint"):
        am.load(file(big))


def test_of_many_at_one_place_each_is_reported_once(file):
    """Robots that were copied, by hand or in a script, and whose poses were forgotten."""
    scenario = building.scenario(*(building.robot(name=f"r{i:03d}") for i in range(130)))
    with pytest.raises(am.ScenarioError) as caught:
        am.Simulation(scenario)
    faults = [(fault.path, fault.message) for fault in caught.value.faults]
    assert faults[0] == ("robots.r001.pose", "overlaps 'r000'; expected room between them")
    assert faults[-1] == ("robots.r129.pose", "overlaps 'r000' and 128 more; expected room between them")
    assert len(faults) == 129
    shown = str(caught.value).splitlines()
    assert len(shown) == 101
    assert shown[-1] == "and 29 more faults"
    text = ROVER + "".join(ROVER[ROVER.index("[[robots]]") :].replace("rover", f"other{i}") for i in range(3))
    with pytest.raises(am.ScenarioError) as caught:
        am.load(file(text))
    assert [fault.message.split(";")[0] for fault in caught.value.faults] == [
        "overlaps 'rover'",
        "overlaps 'rover' and 1 more",
        "overlaps 'rover' and 2 more",
    ]


def test_the_place_for_a_footprint_is_one_where_it_fits():
    # A room of 2 m x 2 m, roomiest for a circle, and a corridor of 6 m x 0.8 m for what is long.
    walls = [(0, 0, 2, 0), (2, 0, 2, 2), (2, 2, 0, 2), (0, 2, 0, 0),
             (3, 0, 9, 0), (9, 0, 9, 0.8), (9, 0.8, 3, 0.8), (3, 0.8, 3, 0)]  # fmt: skip
    world = am.Map.from_segments(np.array(walls, dtype=float), resolution=0.01)
    small, long = am.Shape.circle(0.5), am.Shape.rectangle(4.0, 0.4)
    for shape in (small, long):
        pose = freest_start(world, shape)
        assert wall_gaps(world, [shape], np.array([pose]))[0][0] >= 0.0
    assert freest_start(world, small)[0] < 2.0
    assert freest_start(world, long)[0] > 3.0
    with pytest.raises(am.MapError, match="no place where a footprint that reaches"):
        freest_start(world, am.Shape.circle(1.5))
