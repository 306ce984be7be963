"""Replicas with different maps: the same alone as in company, in all that meets walls, and refused in words."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.runs.world_digests import world_fingerprint
from amorsim.scenario.files.resolved import resolved_table
from amorsim.scenario.files.write import table_text, with_copies, write_table
from amorsim.scenario.reading.read import loads
from amorsim.simulation.world import terrain
from amorsim.simulation.world.terrain import Terrain, bytes_of

FOREST = 'generate = "forest", seed = 7, size = [7, 6], per = "replica", density = { uniform = [0.05, 0.3] }'
# A laser, a ring of sonars, a bumper, a camera and a detector of marks: all that asks a map something.
SENSORS = """
[robots.sensors.laser]
use = "laser"
beams = 20
range_max = 4.0
rate = 10
[robots.sensors.lines]
use = "laser"
beams = 3
range_max = 4.0
traversal = "bresenham"
rate = 10
[robots.sensors.bumper]
use = "bumper"
[robots.sensors.marks]
use = "fiducial"
"""


def document(world: str = FOREST, robot: str = "", more: str = "", sensors: str = SENSORS) -> str:
    return f"""
format = 1
[world]
map = {{ {world} }}
[simulation]
duration = 3.0
[[robots]]
name = "rover"
model = "pioneer2dx"
controller = {{ use = "wander", speed = 0.6 }}
on_collision = "continue"
{robot}
{sensors}
{more}
"""


def read(text: str, **options: Any) -> am.Scenario:
    return loads(tomllib.loads(text), Path(), **options)


MARKS = "[[landmarks]]\nid = 3\nx = 5.0\ny = 4.0\n"
CROWD = '[[obstacles]]\nname = "box"\nshape = { circle = 0.2 }\nstart = { random = "anywhere" }\n'
ROBOTS = ["", 'start = { random = "anywhere" }']


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("more", ["", MARKS + CROWD])
def test_a_replica_is_the_same_alone_as_among_others(robot: str, more: str) -> None:
    scenario = read(document(robot=robot, more=more))
    together = am.Simulation(scenario, replicas=[0, 1, 2, 3, 5], threads=2)
    together.run(3.0)
    for replica in (5, 0, 2):
        alone = am.Simulation(scenario, replicas=[replica])
        alone.run(3.0)
        assert alone.digest(replica) == together.digest(replica)
        assert [event for event in together.events if event.replica == replica] == alone.events


def test_a_replica_computes_what_a_scenario_with_its_map_does() -> None:
    """The twin: the same world as a map of its own, which is the same for all replicas."""
    text = document(FOREST.replace("{ uniform = [0.05, 0.3] }", "0.2"))
    scenario = read(text)
    drawn = am.Simulation(scenario, replicas=range(4))
    drawn.run(3.0)
    for replica in range(4):
        world = am.worlds.forest(7, per="replica", size=(7.0, 6.0), density=0.2)
        mine = attrs.evolve(drawn.map_of(replica), source=None)
        plain = am.Simulation(attrs.evolve(scenario, map=mine, source=None, resolved=None), replicas=[replica])
        plain.run(3.0)
        assert plain.digest() == drawn.digest(replica)
        assert (world == drawn.map_of(replica)) == (replica == 0)


def test_what_is_drawn_differs_and_depends_on_the_replica_alone() -> None:
    scenario = read(document())
    maps = {replica: am.Simulation(scenario, replicas=[replica]).map_of() for replica in range(4)}
    assert len({world_fingerprint(world) for world in maps.values()}) == 4
    assert maps[0] == scenario.map
    assert am.Simulation(scenario, replicas=[3, 1], seed=5).map_of(3) == maps[3]  # the walls are the map's own
    densities = [world.source.made().generator.density for world in maps.values()]
    assert len(set(densities)) == 4
    assert all(0.05 <= density <= 0.3 for density in densities)


def test_a_parameter_alone_may_be_drawn_with_the_same_draws() -> None:
    text = document('generate = "maze", seed = 2, size = [6, 5], loops = { uniform = [0.0, 1.0] }')
    simulation = am.Simulation(read(text), replicas=2)
    perfect, open_ = (simulation.map_of(replica) for replica in (0, 1))
    assert perfect != open_
    same = am.Simulation(read(text.replace("1.0] }", '1.0], per = "study" }')), replicas=3)
    assert len(same._fleet.world.terrain.maps) == 1


def test_whole_numbers_are_drawn_from_end_to_end() -> None:
    world = am.worlds.barn(3, size=(3.0, 8.0), rounds=am.Distribution(kind="uniform", values=(1.0, 3.0)))
    rounds = {world.source.of(replica).made().generator.rounds for replica in range(60)}
    assert rounds == {1, 2, 3}


def test_robots_start_where_their_map_says_and_know_it() -> None:
    known = f"[robots.knowledge]\nmap = {{ {FOREST} }}"
    maze = FOREST.replace("forest", "cave").replace("density = { uniform = [0.05, 0.3] }", "fill = 0.35")
    scenario = read(document(maze, more=known.replace(FOREST, maze), sensors=""))
    assert scenario.robots[0].pose is None
    simulation = am.Simulation(scenario, replicas=4)
    maps = [simulation.map_of(replica) for replica in range(4)]
    assert simulation.true_pose.tolist() == [list(world.start) for world in maps]
    assert len({tuple(pose) for pose in simulation.true_pose.tolist()}) > 1
    model = simulation._fleet.groups[0].robot
    assert model.map is None
    assert [model.map_of(row) for row in range(4)] == maps
    one = am.Simulation(scenario, replicas=[2])._fleet.groups[0].robot
    assert one.map == maps[2]
    assert one.map_of(0) is one.map


LOCALIZES = """
[robots.knowledge]
map = {{ {world} }}
[robots.estimators.mcl]
use = "monte_carlo"
wheel_variance = 1e-3
particles_max = 600
{fields}
"""


@pytest.mark.parametrize("fields", ["", 'model = "beam"', "recovery_slow = 0.001\nrecovery_fast = 0.1"])
def test_a_robot_localizes_itself_on_the_map_of_its_replica(fields: str) -> None:
    scenario = read(document(more=LOCALIZES.format(world=FOREST, fields=fields)))
    many = am.Simulation(scenario, replicas=3)
    many.run()
    for replica in range(3):
        alone = am.Simulation(scenario, replicas=[replica])
        alone.run()
        assert alone.digest(replica) == many.digest(replica)
        known = attrs.evolve(scenario.robots[0].knowledge, map=many.map_of(replica))
        told = attrs.evolve(scenario, robots=[attrs.evolve(scenario.robots[0], knowledge=known)])
        told = am.Simulation(told, replicas=[replica])
        told.run()
        assert told.digest(replica) == many.digest(replica)


def test_a_robot_of_a_replica_that_knows_no_map_is_refused() -> None:
    scenario = read(document(more=LOCALIZES.format(world=FOREST, fields="").replace("map =", "# map =")))
    with pytest.raises(am.ComponentError, match=r"it knows none; name one in knowledge\.map"):
        am.Simulation(scenario, replicas=2)


def test_an_estimator_alone_knows_the_map_of_its_replica() -> None:
    scenario = read(document(more=LOCALIZES.format(world=FOREST, fields="")))
    simulation = am.Simulation(scenario, replicas=[2])
    x, y, heading = simulation.true_pose[0].tolist()
    robot = attrs.evolve(scenario.robots[0], pose=am.Pose(x=x, y=y, heading=heading))
    runner = am.EstimatorRunner(robot, "mcl", dt=simulation.dt, seed=simulation.seed, replica=2)
    for _ in range(30):
        (frame,) = simulation.frames()
        fresh = {name: reading for name, (_, reading) in frame.readings.items() if reading.fresh[0, 0]}
        estimate = runner.update(
            frame.time[0], {name: reading.measured[0] for name, reading in fresh.items()}, frame.command[0]
        )
        assert estimate.pose.tolist() == frame.estimates["mcl"].pose[0].tolist()
        simulation.step()


def test_a_start_in_a_wall_names_the_replica() -> None:
    scenario = read(document(robot="pose = { x = 2.0, y = 2.0 }", sensors=""))
    with pytest.raises(am.ScenarioError, match=r"in replica \d+, at \(2\.000, 2\.000\) m the footprint overlaps"):
        am.Simulation(scenario, replicas=range(30))


def test_snapshots_and_new_episodes_keep_the_maps() -> None:
    scenario = read(document())
    simulation = am.Simulation(scenario, replicas=3)
    before = simulation._fleet.world.terrain
    simulation.run(1.0)
    held = simulation.snapshot().to_bytes()
    simulation.run(1.0)
    digest = simulation.digest()
    simulation.restore(held)
    simulation.run(1.0)
    assert simulation.digest() == digest
    other = am.Simulation(scenario, replicas=3)
    other.restore(held)
    other.run(1.0)
    assert other.digest() == digest
    simulation.reset(seed=4)
    simulation.set("rover", "sensors.laser.noise", [{"use": "gaussian", "std": 0.01}])
    assert simulation._fleet.world.terrain is before


def test_a_position_is_judged_by_the_replicas_own_map() -> None:
    simulation = am.Simulation(read(document(sensors="")), replicas=6)
    places = [(1.0 + 0.25 * i, 1.0 + 0.25 * j) for i in range(20) for j in range(15)]
    free = {}
    for replica in range(6):
        world = simulation.map_of(replica)
        free[replica] = {place for place in places if not world.occupied([place])[0]}
    differs = next(place for place in places if place not in free[0] and place in free[1])
    with pytest.raises(am.AmorsimError, match="it would overlap a wall"):
        simulation.set_pose("rover", (*differs, 0.0), replica=0)
    shown = simulation.occupancy(0.25, replica=1) == 1
    assert not (shown == (simulation.occupancy(0.25, replica=0) == 1)).all()


# ------------------------------------------------------------------------------------------------- in files


def test_what_is_resolved_is_read_as_the_same_worlds() -> None:
    scenario = read(document())
    table = resolved_table(scenario)
    assert table["world"]["map"]["density"] == {"uniform": [0.05, 0.3], "per": "replica"}
    assert "pose" not in table["robots"][0]
    again = read(table_text(table))
    assert again.map == scenario.map
    assert again.map.source == scenario.map.source
    assert am.Simulation(again, replicas=2).map_of(1) == am.Simulation(scenario, replicas=2).map_of(1)


def test_a_folder_names_the_generator_and_has_a_digest_of_each_world(tmp_path: Path) -> None:
    known = f"[robots.knowledge]\nmap = {{ {FOREST} }}"
    scenario = read(document(more=known, sensors=""))
    summary = am.run(scenario, tmp_path / "run", replicas=[1, 4], duration=0.5)
    about = json.loads((summary.folder / "run.json").read_text())
    assert list(about["worlds"]) == ["1", "4"]
    assert am.reproduce(summary.folder).is_exact
    again = am.load(summary.folder / "scenario.toml")
    assert again.map.source == scenario.map.source
    assert again.robots[0].knowledge.map is again.map
    write_table(with_copies(scenario, tmp_path / "copy"), tmp_path / "copy.toml")
    assert not list((tmp_path / "copy").glob("*.png"))


def test_another_world_than_then_is_reported(tmp_path: Path) -> None:
    summary = am.run(read(document(sensors="")), tmp_path / "run", replicas=[1, 4], duration=0.3)
    about = summary.folder / "run.json"
    record = json.loads(about.read_text())
    record["worlds"]["4"] = "0123456789abcdef"
    about.write_text(json.dumps(record))
    outcome = am.reproduce(summary.folder)
    assert not outcome.is_same
    assert "the generator Forest gives replica 4 another world than in that run" in outcome.difference


def test_a_world_without_what_is_drawn_is_no_different(tmp_path: Path) -> None:
    """A distribution that the study draws once: one world, whose cells a folder holds."""
    text = document(FOREST.replace('"replica"', '"study"').replace("0.3] }", '0.3], per = "study" }'), sensors="")
    summary = am.run(read(text), tmp_path / "run", replicas=2, duration=0.3)
    assert "worlds" not in json.loads((summary.folder / "run.json").read_text())
    assert list(summary.folder.glob("*.png"))
    assert am.reproduce(summary.folder).is_exact


FAULTS = [
    ('per = "row"', "world.map.per", "expected 'study' or 'replica', got 'row'"),
    ("density = { uniform = [0.3, 0.05] }", "world.map.density.uniform", "expected low <= high"),
    ("density = { uniform = [0.05, 0.3], par = 1 }", "world.map.density.par", "unknown key"),
    ('density = { normal = [0.1, 0.1], per = "day" }', "world.map.density.per", "replica"),
    ("density = { normal = [-5.0, 0.1] }", "world.map.density", "expected a number"),
    ("size = { uniform = [4.0, 9.0] }", "world.map.size", "only a number can be drawn"),
    ('seed = "per_replica"', "world.map.seed", 'per = "replica" gives each replica a world of its own'),
]


@pytest.mark.parametrize(("words", "path", "message"), FAULTS)
def test_faults_name_the_key(words: str, path: str, message: str) -> None:
    with pytest.raises(am.ScenarioError) as caught:
        read(document(f'generate = "forest", {words}'))
    assert any(fault.path == path and message in fault.message for fault in caught.value.faults), caught.value


def test_a_whole_number_needs_whole_ends() -> None:
    with pytest.raises(am.ScenarioError, match="both whole numbers"):
        read(document('generate = "barn", rounds = { uniform = [0.5, 3.0] }'))
    with pytest.raises(am.MapError, match="both whole numbers"):
        am.worlds.barn(rounds=am.Distribution(kind="normal", values=(2.0, 1.0)))


def test_a_number_that_the_generator_refuses_names_the_replica() -> None:
    scenario = read(document('generate = "forest", size = [7, 6], density = { normal = [0.4, 0.3] }', sensors=""))
    with pytest.raises(am.MapError, match=r"density: expected a number .*, drawn for replica \d+; take a narrower"):
        am.Simulation(scenario, replicas=100)


# --------------------------------------------------------------------------------------------------- memory


def test_a_limit_of_memory_is_checked_before_other_worlds_are_made(monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = read(document(sensors=""))
    each = bytes_of(scenario.map)
    monkeypatch.setattr(terrain, "MOST_BYTES", 10 * each)
    made: list[int] = []
    make = am.worlds.Forest.generate

    def counted(self: Any, draws: Any) -> am.Map:
        made.append(0)
        return make(self, draws)

    monkeypatch.setattr(am.worlds.Forest, "generate", counted)
    with pytest.raises(am.AmorsimError, match=r"11 replicas with a map each need about .* at most 10 replicas at once"):
        am.Simulation(scenario, replicas=11)
    assert not made


def test_worlds_that_grow_reach_the_limit_on_the_way(monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = read(document(sensors=""))
    monkeypatch.setattr(terrain, "bytes_of", lambda world: 100 if world is scenario.map else 10_000)
    monkeypatch.setattr(terrain, "MOST_BYTES", 10_000)
    with pytest.raises(am.AmorsimError, match="coarser resolution or smaller worlds"):
        am.Simulation(scenario, replicas=100)


def test_the_bytes_of_a_map_are_those_of_its_arrays() -> None:
    world = am.worlds.maze(1, size=(6.0, 5.0))
    arrays = [array for array in (*world.grid, *world.segment_index) if isinstance(array, np.ndarray)]
    assert bytes_of(world) == sum(array.nbytes for array in arrays) > 1000


def test_rows_go_with_their_maps() -> None:
    maps = tuple(am.worlds.maze(seed, size=(4.0, 4.0)) for seed in range(2))
    held = Terrain(maps, np.array([1, 0, 0, 1]))
    replica = np.array([0, 0, 1, 2, 3, 3])
    found = [(maps.index(world), rows) for world, rows in held.between(replica, 1, 6)]
    assert found == [(1, slice(1, 2)), (0, slice(2, 4)), (1, slice(4, 6))]
    assert held.at(1) is maps[0]
