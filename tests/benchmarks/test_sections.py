"""The sections of crowds, mixed fleets and compositions: that what they time is what they say."""

from __future__ import annotations

import re
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import amorsim as am
from amorsim.estimators.map_area import log_odds_evidence
from amorsim.kernels.mapping.occupancy import add_log_odds
from amorsim.kernels.mapping.scan_cells import window_for
from benchmarks import compositions, crowd, graphs, mapping, mixed
from benchmarks.contest import drive
from benchmarks.ours import given


def test_a_crowd_walks_and_is_timed_in_simulated_seconds() -> None:
    rows = crowd._contest(9, 16.0, 2, 0.02, time.perf_counter, lambda _: None)
    assert rows[0].side == "amorsim"
    assert rows[0].unit == "simulated s/s"
    assert all(len(row.rounds) == 2 for row in rows)
    walked = re.search(r"people went (.*) m/s", rows[0].note)
    assert walked is not None
    assert 0.3 < float(walked.group(1)) < crowd.SPEED


def test_a_peer_that_stops_is_told_and_does_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    class Leaver(crowd.Ours):
        def __init__(self, side: float, starts: Any, goals: Any, speed: float, radius: float, dt: float) -> None:
            super().__init__(side, starts, goals)
            self.left = 110 if dt == 0.01 else 0  # steps; a round makes one at least, and the walk before 100

        @staticmethod
        def version() -> str:
            return "0"

        def step(self) -> None:
            self.left -= 1
            if self.left < 0:
                raise RuntimeError("somebody is outside")
            super().step()

    monkeypatch.setattr(crowd, "JuPedSim", Leaver)
    said: list[str] = []
    rows = crowd._contest(9, 16.0, 20, 1e-9, time.perf_counter, said.append)
    assert [row.side for row in rows] == ["amorsim", "JuPedSim 0, steps of 0.01 s"]
    assert [len(row.rounds) for row in rows] == [20, 10]
    assert rows[1].ratio is not None
    assert not rows[1].ratio.counts
    assert rows[1].ratio.why_not == "it stopped: somebody is outside"
    assert [words for words in said if "stopped" in words] == [
        "crowd: JuPedSim 0, steps of 0.05 s, stopped after 0 rounds: somebody is outside",
        "crowd: JuPedSim 0, steps of 0.01 s, stopped after 10 rounds: somebody is outside",
    ]


def test_a_crowd_has_as_much_room_as_it_says() -> None:
    side, starts, goals = crowd._people(100, 4.0)
    assert side == pytest.approx(20.0)
    gaps = np.linalg.norm(starts[:, None] - starts[None], axis=2) + 10.0 * np.eye(100)
    assert gaps.min() > 2.0 * crowd.RADIUS
    for places in (starts, goals):
        assert places.min() > 0.5
        assert places.max() < side - 0.5


def test_commands_given_make_one_group() -> None:
    assert given(1.0, 2.0) is given(1.0, 2.0)
    command = given(1.0, 2.0).command(type("Robot", (), {"rows": 3}), {}, None, None, {}, None)
    np.testing.assert_array_equal(command, [[1.0, 2.0]] * 3)


def test_the_mixed_fleet_is_of_ten_models_that_ship() -> None:
    # The Jackal and the Pioneer of logs, which came later, are left out: figures of ten models stay comparable.
    folder = Path(am.__file__).parent / "robots"
    assert set(mixed.MODELS) == {file.stem for file in folder.glob("*.toml")} - {"jackal", "pioneer2dx-lms200"}


@pytest.mark.parametrize("name", [compositions._PLAIN, compositions._EKF, "an Ackermann car, commands given"])
def test_a_composition_goes_its_way_and_meets_nothing(name: str) -> None:
    side = compositions._side(compositions._COMPOSITIONS[name], 1)
    before = side.simulation.true_pose.copy()
    drive(side, 20, 0.0, time.perf_counter)
    assert np.hypot(*(side.simulation.true_pose - before)[0, :2]) > 0.05
    assert not side.simulation.events


@pytest.mark.parametrize("name", list(compositions._LESS))
def test_code_that_is_not_amorsim_s_keeps_count_of_its_time(name: str) -> None:
    side = compositions._side(compositions._COMPOSITIONS[name], 1)
    compositions._Own.seconds = 0.0
    made = drive(side, 20, 0.0, time.perf_counter)
    assert 0.0 < compositions._Own.seconds < made.seconds


def test_the_far_obstacle_is_far() -> None:
    robot, post = compositions._with_post(compositions._plain())
    assert isinstance(post, am.Obstacle)
    assert robot.pose is not None
    assert np.hypot(post.pose.x - robot.pose.x, post.pose.y - robot.pose.y) > 20.0


def test_both_sides_of_mapping_see_the_same_cells() -> None:
    pose = np.array([1.23, -2.34, 0.7])
    grid: dict[tuple[int, int], float] = {}
    mapping.plain_scan(pose, grid)
    cells = np.full((1, 800 * 800), np.nan, dtype=np.float32)
    room = window_for(mapping._AREA, 8.0)
    origin = np.array([[-20.0, -20.0]])
    add_log_odds(mapping._AREA, origin, mapping._scan(pose), log_odds_evidence(), room, cells)
    rows, cols = np.nonzero(np.isfinite(cells.reshape(800, 800)))
    mine = {(int(col) - 400, int(row) - 400) for row, col in zip(rows, cols, strict=True)}
    assert len(mine ^ set(grid)) <= 0.002 * len(grid)  # where a line goes through a corner
    ends = {cell for cell, value in grid.items() if value > 0.0}
    assert (cells > 0.0).sum() == pytest.approx(len(ends), abs=2)


def test_mapping_is_timed() -> None:
    rows = mapping.measure(1, True, time.perf_counter, lambda _: None)
    assert [row.side for row in rows] == ["amorsim", "plain Python"]
    assert rows[0].rounds[0] > rows[1].rounds[0]


@pytest.mark.long
def test_environments_for_learners_are_timed() -> None:
    pytest.importorskip("gymnasium", reason="the extra 'learn' is not installed")
    from benchmarks import learning

    rows = [row for row in learning.measure(1, True, time.perf_counter, lambda _: None) if row.side != "VMAS"]
    assert [row.setting for row in rows] == 3 * ["PointGoal, 1 environments"] + 3 * ["PointGoal, 100 environments"]
    assert all(row.rounds[0] > 0.0 for row in rows)
    assert re.search(r"the interface costs -?\d+ us a step", rows[1].note)


def test_a_graph_that_is_made_is_solved_from_poses_that_are_off() -> None:
    rows = graphs.measure(1, True, time.perf_counter, lambda _: None)
    assert rows[0].side == "amorsim"
    poses, edges = (int(number) for number in re.findall(r"(\d+) (?:poses|edges)", rows[0].setting))
    assert (poses, edges) == (1728, 2 * 1727 - 144)
    found = re.match("chi2 ([0-9.]+)", rows[0].note)
    assert found is not None
    # As many squared errors of variance 1 as there are measured numbers more than unknown ones, to six deviations.
    free = 3 * (edges - poses + 1)
    assert abs(float(found.group(1)) - free) < 6.0 * np.sqrt(2.0 * free)
