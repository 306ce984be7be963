"""A shuttle turns back, posts are where the seed says, a course has its robots and its lines."""

from pathlib import Path

import amorsim_example as example
import amorsim_example.plugin
import attrs
import numpy as np
import pytest
from example_world import open_ground, robot, simulation

import amorsim as am
from amorsim.plugins.manager import make_registry
from amorsim.worlds.made import MadeWorld, make_world


def shuttle(walls: tuple[tuple[float, float, float, float], ...] = ()) -> list[float]:
    """Where a shuttle is along x after each step of 0.1 s."""
    box = am.Obstacle(
        name="box", shape=am.Shape.circle(0.2), motion=example.Shuttle(speed=1.0, distance=2.0), pose=am.Pose(x=0.0)
    )
    sim = simulation(robot(pose=am.Pose(y=10.0)), map=open_ground(*walls), obstacles=[box])
    places = []
    for _ in range(60):
        sim.step()
        places.append(float(sim.obstacle("box").true_pose[0]))
    return places


def test_a_shuttle_goes_to_and_fro() -> None:
    places = shuttle()
    assert max(places) == pytest.approx(2.0, abs=0.11)
    assert min(places) == pytest.approx(0.0, abs=0.11)
    assert np.abs(np.diff(places)).max() == pytest.approx(0.1)


def test_a_shuttle_turns_back_at_a_wall() -> None:
    places = shuttle(((1.0, -5.0, 1.0, 5.0),))
    assert max(places) == pytest.approx(0.8, abs=0.02)
    assert places[-1] < 0.8


def test_posts_stand_where_the_seed_says_and_leave_the_middle_free() -> None:
    posts = example.Posts(posts=300)
    one, again, other = (make_world(MadeWorld(generator=posts, seed=seed)) for seed in (1, 1, 2))
    assert one == again
    assert one != other
    assert not one.to_array()[45:55, 45:55].any()
    assert one.to_array()[1:-1, 1:-1].sum() > 200


def test_a_course_is_read_with_its_robots(tmp_path: Path) -> None:
    (tmp_path / "room.maze").write_text("#####\n#   #\n#   #\n#####\n")
    registry = make_registry({"example": amorsim_example.plugin}, entry_points=[])
    (tmp_path / "a.course").write_text("course room.maze\n\npioneer2dx 1.0 1.0 90\n")
    scenario = am.load(tmp_path / "a.course", registry=registry)
    (rover,) = scenario.robots
    assert attrs.astuple(rover.pose) == (1.0, 1.0, pytest.approx(np.pi / 2))
    (tmp_path / "b.course").write_text("course room.maze\npioneer2dx 1.0 1.0\nx y\n")
    with pytest.raises(am.ScenarioError) as caught:
        am.load(tmp_path / "b.course", registry=registry)
    assert [fault.line for fault in caught.value.faults] == [2, 3]


def test_bounce_keeps_away_from_walls() -> None:
    room = am.Map.from_segments([(0, 0, 4, 0), (4, 0, 4, 3), (4, 3, 0, 3), (0, 3, 0, 0)])
    rover = am.load_robot("pioneer2dx", name="rover", pose=am.Pose(x=1.5, y=1.5), controller=example.Bounce())
    sim = am.Simulation(am.Scenario(map=room, robots=[rover]))
    sim.run(30.0)
    assert not sim.events
