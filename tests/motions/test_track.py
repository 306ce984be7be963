"""A recorded track is repeated to its times; from a file that a user wrote, and that a run's folder keeps."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import amorsim as am
from amorsim.motions import Track
from amorsim.motions.track import read_track
from tests import building
from tests.motions.worlds import DT, obstacle, track, world

TEXT = "time,x,y\n10,2,2\n11,3,2\n13,3,4\n14,2,4\n"
TIMES, XS, YS = [0.0, 1.0, 3.0, 4.0], [2.0, 3.0, 3.0, 2.0], [2.0, 2.0, 4.0, 4.0]


@pytest.fixture
def file(tmp_path: Path) -> str:
    (tmp_path / "walk.csv").write_text(TEXT)
    return str(tmp_path / "walk.csv")


def test_it_is_where_the_recording_has_it(file: str) -> None:
    poses = track(world(obstacle(Track(file=file))), 50)
    time = DT * np.arange(51)
    assert poses[:, 0] == pytest.approx(np.interp(time, TIMES, XS), abs=1e-9)
    assert poses[:, 1] == pytest.approx(np.interp(time, TIMES, YS), abs=1e-9)
    assert abs(poses[38, 2]) == pytest.approx(np.pi, abs=1e-9)  # faces where it goes


def test_headings_are_taken_the_short_way(tmp_path: Path) -> None:
    (tmp_path / "turn.csv").write_text("time, heading_deg, x, y\n0, 170, 2, 2\n1, -170, 2, 2\n")
    poses = track(world(obstacle(Track(file=str(tmp_path / "turn.csv")))), 12)
    assert np.abs(poses[5, 2]) == pytest.approx(np.pi)
    assert poses[10, 2] == pytest.approx(np.radians(-170.0))


def test_it_starts_again(file: str) -> None:
    poses = track(world(obstacle(Track(file=file, repeat=True, speed_max=100.0))), 120)
    time = (DT * np.arange(121)) % 4.0
    off = np.hypot(poses[:, 0] - np.interp(time, TIMES, XS), poses[:, 1] - np.interp(time, TIMES, YS))
    assert off[(time > 1e-6) & (time < 4.0 - 1e-6)].max() < 1e-6  # at the jump rounding decides


@pytest.mark.parametrize("blocked", ["wait", "skip"])
def test_blocked_it_waits_or_skips_what_it_missed(file: str, blocked: str) -> None:
    robot = building.robot(shape=am.Shape.circle(0.3), pose=am.Pose(x=3.0, y=3.0), on_collision="continue")
    sim = world(obstacle(Track(file=file, blocked=blocked)), robot=robot)
    poses = track(sim, 28)
    assert poses[-1, :2] == pytest.approx([3.0, 2.5], abs=1e-9)
    sim.set_pose("rover", (8.0, 8.0, 0.0))
    poses = track(sim, 7)  # at 3.5 s by the clock; its own way was 1.5 s long
    if blocked == "wait":
        assert poses[-1, :2] == pytest.approx([3.0, 2.5 + 0.7], abs=1e-9)
    else:  # it hurries to where the recording is, (2.5, 4), straight, and no faster than that ever was
        assert np.hypot(*np.diff(poses[:, :2], axis=0).T).max() <= 0.1 + 1e-9
        assert poses[-1, 1] == pytest.approx(2.5 + 0.7, abs=0.1)
        assert poses[-1, 0] < 2.95


def test_from_elsewhere_it_makes_for_its_place(file: str) -> None:
    poses = track(world(obstacle(Track(file=file, speed_max=2.0), pose=am.Pose(x=2.0, y=1.0))), 50)
    assert poses[-1, :2] == pytest.approx([2.0, 4.0], abs=1e-9)
    assert np.hypot(*np.diff(poses[:, :2], axis=0).T).max() <= 0.2 + 1e-9


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "expected a first line such as time,x,y"),
        ("t,x,y\n0,1,1\n", "expected a first line such as time,x,y,heading_deg, got 't,x,y'"),
        ("time,x,y,heading\n0,1,1,0\n1,1,1,0\n", "got also 'heading'. An angle is given in degrees, as heading_deg."),
        ("time,x,y,haeding_deg\n0,1,1,0\n1,1,1,0\n", "got also 'haeding_deg'. Did you mean 'heading_deg'?"),
        ("time,x,y,who\n0,1,1,a\n1,1,1,a\n", "no columns but time, x, y, heading_deg, each once, got also 'who'."),
        ("time,x,y,x\n0,1,1,1\n1,1,1,1\n", "each once, got also 'x'."),
        ("time,x,y\n0,1,1\n", "two lines at least below the first, got 1"),
        ("time,x,y\n0,1,1\n\n1,1,2\n1,2,2\n", "line 5: expected a time above 1, got 1"),
        ("time,x,y\n0,1,1\n1,1\n", "line 3: expected 3 cells, got 2"),
        ("time,x,y\n0,1,1\n1,a,1\n", "line 3: expected a finite x, got 'a'"),
        ("time,x,y\n0,1,1\n1,inf,1\n", "line 3: expected a finite x, got 'inf'"),
    ],
)
def test_a_file_that_is_no_track(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "bad.csv").write_text(text)
    with pytest.raises(am.ParameterError, match=message):
        read_track(tmp_path / "bad.csv")


SCENARIO = """\
format = 1
[world]
map = "room.wld"
[simulation]
duration = 1.0
[[robots]]
name = "rover"
model = "pioneer2dx"
pose = { x = 4.0, y = 1.0 }
[[obstacles]]
name = "ann"
shape = { circle = 0.2 }
motion = { use = "track", file = "tracks/walk.csv" }
[[obstacles]]
name = "bob"
shape = { circle = 0.2 }
pose = { x = 1.0, y = 1.0 }
motion = { use = "mine.py:chase", speed = 0.4 }
[[obstacles]]
name = "post"
shape = { circle = 0.1 }
pose = { x = 0.5, y = 3.5 }
"""
OWN = "def chase(obstacle, speed):\n    return speed * (obstacle.others[0, 0] > obstacle.x), 0.0, 1.0\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "tracks").mkdir()
    (tmp_path / "tracks" / "walk.csv").write_text("time,x,y\n0,2,3\n10,2,2\n")
    (tmp_path / "room.wld").write_text("0 0 5000 0\n5000 0 5000 4000\n5000 4000 0 4000\n0 4000 0 0\n")
    (tmp_path / "mine.py").write_text(OWN)
    (tmp_path / "s.toml").write_text(SCENARIO)
    return tmp_path


def test_files_are_found_beside_the_scenario_kept_by_a_run_and_reproduce(folder: Path) -> None:
    am.run(am.load(folder / "s.toml"), folder / "run", replicas=2)
    assert {"walk.csv", "mine.py", "obstacles.csv"} <= {path.name for path in (folder / "run").iterdir()}
    (folder / "tracks" / "walk.csv").unlink()
    again = am.reproduce(folder / "run")
    assert again.is_same, again
    lines = (folder / "run" / "obstacles.csv").read_text().splitlines()
    assert lines[0] == "replica,time,obstacle,x,y,heading"
    # Two that move at eleven ticks, and a post at the first, in two replicas.
    assert len(lines) == 1 + 2 * (2 * 11 + 1)
    assert "1,1.000000,ann,2.000000,2.900000,-1.570796" in lines
    assert "0,1.000000,bob,1.400000,1.000000,1.000000" in lines
    assert sum(",post," in line for line in lines) == 2


def test_a_missing_track_is_a_fault_with_its_place(folder: Path) -> None:
    (folder / "tracks" / "walk.csv").unlink()
    with pytest.raises(am.ScenarioError, match=r"s.toml:\d+: obstacles.ann.motion.file: expected a track to be there"):
        am.load(folder / "s.toml")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "def chase(obstacle, speed):\n    return 'fast'\n",
            "mine.py:chase' of obstacle 'bob' returned 'fast'; expected the velocity",
        ),
        ("def chase(obstacle, speed):\n    return 1.0, float('nan')\n", "expected the velocity"),
        ("def chase(obstacle, speed):\n    return 1e300, 0.0\n", r"\(1e\+300, 0.0\); expected .* each at most 1e\+06"),
        (
            "def chase(obstacle, speed):\n    return speed / 0.0, 0.0\n",
            "of obstacle 'bob' at 0 s raised ZeroDivisionError",
        ),
        ("def chase(obstacle, speed):\n    raise SystemExit(3)\n", "at 0 s raised SystemExit: 3"),
    ],
)
def test_a_function_that_gives_no_velocity_is_named(folder: Path, text: str, message: str) -> None:
    (folder / "mine.py").write_text(text)
    with pytest.raises(am.ComponentError, match=message):
        am.Simulation(am.load(folder / "s.toml")).step()


def test_a_function_that_takes_something_else_is_a_fault(folder: Path) -> None:
    (folder / "mine.py").write_text("def chase():\n    return None\n")
    with pytest.raises(am.ScenarioError, match=r"obstacles.bob.motion.use: .*cannot be called as chase\(obstacle"):
        am.load(folder / "s.toml")


def test_a_track_that_has_gone_meanwhile_is_reported(file: str) -> None:
    sim = world(obstacle(Track(file=file)))
    Path(file).unlink()
    sim.step()  # what was read is kept
    with pytest.raises(am.ComponentError, match=r"walk.csv' is there no more"):
        sim.reset()


class Fussy:
    """Does not like the third of its kind to be made, or to be asked."""

    def __init__(self, at: str) -> None:
        Fussy.made += 1
        self.number, self.at = Fussy.made, at
        if at == "making" and self.number == 3:
            raise ValueError("no more")

    def velocity(self, obstacle: am.motions.ObstacleState) -> None:
        if self.number == 3 and obstacle.time > 0.15:
            raise ValueError("not me")

    made = 0


@pytest.mark.parametrize(
    ("at", "message"),
    [
        ("making", "making its object for obstacle 'c' with the options {'at': 'making'} raised ValueError: no more"),
        ("asking", "of obstacle 'c' at 0.2 s raised ValueError: not me"),
    ],
)
def test_of_many_the_one_that_failed_is_named(at: str, message: str) -> None:
    Fussy.made = 0
    motion = am.motions.UserMotion(source="own", function=Fussy, options=(("at", at),))
    posts = [obstacle(motion, name=name, pose=am.Pose(x=1.0 + i, y=4.0)) for i, name in enumerate("abcd")]
    with pytest.raises(am.ComponentError, match=re.escape(f"motion 'own'{':' if at == 'making' else ''} {message}")):
        world(*posts).run(0.5)


def test_what_cannot_be_called_is_refused_as_a_motion() -> None:
    motion = am.motions.UserMotion(source="own", function="go")
    with pytest.raises(am.ComponentError, match="motion 'own': expected a function or a class, got 'go'"):
        world(obstacle(motion, pose=am.Pose(x=3.0, y=3.0)))


class Patrol:
    """Goes to and fro, a second each way; counts for itself."""

    def __init__(self) -> None:
        self.steps = 0

    def velocity(self, obstacle: am.motions.ObstacleState) -> tuple[float, float] | None:
        self.steps += 1
        return (0.5, 0.0) if self.steps % 20 < 10 else (-0.5, 0.0)


def test_a_class_has_an_object_for_each_and_a_snapshot_copies_them() -> None:
    sim = world(obstacle(Patrol, pose=am.Pose(x=3.0, y=3.0)), obstacle(Patrol, name="b", pose=am.Pose(x=3.0, y=5.0)))
    sim.run(0.5)
    snapshot = sim.snapshot()
    sim.run(2.0)
    digest = sim.digest()
    sim.restore(snapshot)
    sim.run(2.0)
    assert sim.digest() == digest
    sim.run(1.5)
    assert sim.obstacle("thing").true_pose[0] == pytest.approx(sim.obstacle("b").true_pose[0])
