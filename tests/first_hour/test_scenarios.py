"""The scenarios of drives and controllers run as they are; their maps are what their script draws."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
import pytest
import shapely

import amorsim as am
from tests.first_hour.conftest import ROOT, amorsim
from tests.some_cases import one_in

DRIVEN = (
    "car-park",
    "synchro-hall",
    "khepera-maze",
    "line",
    "convoy",
    "yard",
    "landmarks",
    "find-yourself",
    "loop",
    "map-the-office",
    "find-the-way",
    "parking-lot",
    "unknown-maze",
    "learned",
)


@pytest.mark.pictures
@pytest.mark.parametrize("name", one_in(4, DRIVEN))
def test_it_runs_as_it_is(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    status, said = amorsim(f"amorsim run {name} --out run --set simulation.duration=3 --quiet", monkeypatch)
    assert status == 0, said
    assert (tmp_path / "run" / "picture.png").is_file()
    assert "Traceback" not in said


@pytest.mark.parametrize("name", DRIVEN)
def test_its_robots_get_under_way_and_meet_nothing(name: str) -> None:
    sim = am.Simulation(am.load(name))
    start = sim.true_pose.copy()
    sim.run(8.0)
    assert not [event for event in sim.events if event.kind != "report"]
    assert (np.hypot(*(sim.true_pose - start)[:, :2].T) > (0.03 if name == "khepera-maze" else 0.3)).all()


@pytest.mark.long
@pytest.mark.parametrize("name", DRIVEN)
def test_its_robots_meet_nothing_to_the_end(name: str) -> None:
    scenario = am.load(name)
    sim = am.Simulation(scenario)
    sim.run(scenario.duration)
    assert not [event for event in sim.events if event.kind != "report"]
    if name == "find-the-way":
        reached = [event.value for event in sim.events if event.path == "goal_reached"]
        assert reached == ["1 of 3", "2 of 3", "3 of 3"]
    if name == "learned":
        reached = [event.value for event in sim.events if event.path == "goal_reached"]
        assert reached == [f"{number} of 6" for number in range(1, 7)]
    if name == "car-park":
        assert np.hypot(*(sim.true_pose[0, :2] - (18.7, 31.0))) < 0.6
        assert abs(np.sin(sim.true_pose[0, 2] - np.pi / 2)) < np.sin(np.radians(6.0))


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2])
def test_car_and_tractor_park_in_their_bays_whatever_their_errors(seed: int) -> None:
    """In eight replicas, with other errors in each. The bay leaves the car 1 m on either side."""
    scenario = am.load("parking-lot")
    sim = am.Simulation(scenario, seed=seed, replicas=8)
    sim.run(scenario.duration)
    assert [event.path for event in sim.events] == ["goal_reached"] * 16
    for name, goal in (("car", (29.7, 2.0)), ("tractor", (38.1, 33.0))):
        poses = np.array([sim.robot(name, replica).true_pose for replica in range(8)])
        assert np.hypot(*(poses[:, :2] - goal).T).max() < 0.3
        assert np.abs(np.sin(poses[:, 2] - 0.5 * np.pi)).max() < np.sin(np.radians(10.0))
        assert np.abs(np.diff(poses, axis=0)).max() > 0.0


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2])
def test_the_robot_finds_its_way_out_of_a_maze_that_it_maps(seed: int) -> None:
    """It knows no wall at the start, meets dead ends, and plans again and again."""
    scenario = am.load("unknown-maze")
    assert scenario.robots[0].knowledge.map is None
    sim = am.Simulation(scenario, seed=seed, replicas=8)
    sim.run(5.0)
    first = sim.frames()[0].beliefs
    seen = np.isfinite(first["mapping"]["occupancy"]).mean(axis=(1, 2))
    path = first["controller"]["path"]
    sim.run(scenario.duration - 5.0)
    assert not [event for event in sim.events if event.kind != "report"]
    assert [event.path for event in sim.events if event.path != "recovery"] == ["goal_reached"] * 8
    last = sim.frames()[0].beliefs
    assert (np.isfinite(last["mapping"]["occupancy"]).mean(axis=(1, 2)) > 1.5 * seen).all()
    assert (last["controller"]["plans"] > 10).all()
    assert last["controller"]["path"].tobytes() != path.tobytes()


@pytest.mark.long
def test_robots_that_cross_get_to_their_goals() -> None:
    """Some meet, and some stand in one another's way, as the method's authors found; then they say so."""
    sim = am.Simulation(am.load("crossing"))
    sim.run(120.0)
    reached = [event.name for event in sim.events if event.path == "goal_reached"]
    stuck = {event.name for event in sim.events if event.path == "deadlock"}
    assert len(set(reached)) >= 15
    assert set(sim.names) - set(reached) <= stuck


@pytest.mark.long
def test_the_khepera_keeps_to_its_line() -> None:
    """Round it once and more, with its base point within half of what its two sensors are apart."""
    scenario = am.load("line")
    line = shapely.LineString(scenario.floor.markings[0].patch.points)
    sim = am.Simulation(scenario)
    gone = [sim.true_pose[0, :2]]
    for _ in range(round(scenario.duration / scenario.dt)):
        sim.step()
        gone.append(sim.true_pose[0, :2])
        assert not sim.robot("khepera").readings["cliff"].true.any()
    assert max(line.distance(shapely.Point(place)) for place in gone) < 0.012
    assert np.hypot(*np.diff(gone, axis=0).T).sum() > line.length


def test_their_maps_are_what_their_script_draws() -> None:
    script = ROOT / "tools" / "draw_worlds.py"
    if not script.is_file():
        pytest.skip("the tools are not installed")
    spec = importlib.util.spec_from_file_location("draw_worlds", script)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    folder = Path(am.__file__).parent / "scenarios"
    for world in module.WORLDS:
        assert module.draw(world) == (folder / world).read_text(encoding="utf-8")
        map_ = am.load_map(folder / world)
        assert map_.warnings == ()
        assert map_.start is not None
