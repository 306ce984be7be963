"""When a ratio counts, and how it is taken: nothing here is about time."""

from __future__ import annotations

import time
from typing import Any

import attrs
import numpy as np
import pytest

from benchmarks import contest, published, results
from benchmarks.ours import Ours, disc
from benchmarks.results import Conduct, Ratio, Row, compare, ratio_of
from benchmarks.table import as_text, figure, plain_says
from benchmarks.task import BEAMS, Task
from benchmarks.worlds import line_room, places

GOOD = Conduct(first_range=3.0, mean_range=3.2, distance=1.0, stopped=0.0, steps=20)


def test_alike_sides_count() -> None:
    assert compare(GOOD, attrs.evolve(GOOD, mean_range=3.2 * 1.009, distance=1.01)) == ""


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"first_range": 3.0 * 1.012}, "first scans differ"),
        ({"mean_range": 3.2 * 0.985}, "mean ranges differ"),
        ({"mean_range": None}, "not known"),
        ({"mean_range": float("nan")}, "mean ranges differ"),
        ({"distance": 0.0}, "does not move"),
        ({"distance": 0.9}, "ways differ"),
        ({"all_beams": False}, "all beams"),
    ],
)
def test_each_trap_is_seen(changes: dict[str, Any], why: str) -> None:
    assert why in compare(GOOD, attrs.evolve(GOOD, **changes))
    assert why in compare(attrs.evolve(GOOD, **changes), GOOD)


def test_a_ratio_is_taken_round_by_round() -> None:
    """The second round was twice as slow for both: the ratio does not see it."""
    assert ratio_of([100.0, 50.0, 120.0], [10.0, 5.0, 10.0]) == results.Spread(10.0, 10.0, 12.0)
    assert ratio_of([1.0, 2.0], [3.0, 6.0], less_is_better=True) == results.Spread(3.0, 3.0, 3.0)
    with pytest.raises(ValueError, match="2 rounds against 3"):
        ratio_of([1.0, 2.0], [1.0, 2.0, 3.0])


def test_published_figures_are_scaled_by_the_plain_traversal() -> None:
    assert published.here(10_000.0, (published.PLAIN_THERE, published.PLAIN_THERE / 2.0)) == (10_000.0, 5_000.0)


def test_a_slow_yardstick_is_said() -> None:
    assert "slower" in plain_says((4.0e6, 4.9e6, 4.5e6))
    assert "slower" not in plain_says((5.1e6, 6.0e6))


class Follower:
    """A peer that follows a task in Python, or falls into one of the traps."""

    def __init__(self, task: Task, trap: str = "") -> None:
        self.task, self.trap = task, trap
        self.reset()

    def reset(self) -> None:
        self._poses = self.task.starts.copy()
        self._scan = self._cast()

    def step(self, index: int) -> None:
        if self.trap != "stands":
            v, w = self.task.twists[index].T
            self._poses = self._poses + 0.1 * np.column_stack(
                [v * np.cos(self._poses[:, 2]), v * np.sin(self._poses[:, 2]), w]
            )
        if self.trap != "does not scan":
            self._scan = self._cast()

    def ranges(self) -> Any:
        return self._scan[:, 1:] if self.trap == "leaves out a beam" else self._scan

    def poses(self) -> Any:
        return self._poses

    def _cast(self) -> Any:
        return self.task.world.map.cast_rays(self._poses, np.linspace(-np.pi / 2, np.pi / 2, BEAMS), 8.0)


@pytest.fixture(scope="module")
def driven() -> tuple[Ours, Task, Any]:
    room = line_room(0.01)
    ours = Ours(room, [disc("a", places(room, 1, 0.6)[0])])
    return ours, *ours.task(12)


def test_a_drive_over_again_has_the_same_bits(driven: Any) -> None:
    ours, _, _ = driven
    again = ours.repeated(12)
    ours.reset()
    again.reset()
    for index in range(12):
        ours.step(index)
        again.step(index)
    np.testing.assert_array_equal(ours.simulation.true_pose, again.simulation.true_pose)
    np.testing.assert_array_equal(ours.scan(), again.scan())


def test_a_peer_that_follows_is_alike(driven: Any) -> None:
    _, task, track = driven
    conduct = contest.watch(Follower(task), 12, 60.0).conduct
    assert conduct.steps == 12
    assert conduct.distance is not None
    assert conduct.distance > 0.1
    assert compare(contest.track_conduct(track, 12), conduct) == ""


@pytest.mark.parametrize("trap", ["stands", "does not scan", "leaves out a beam"])
def test_a_peer_in_a_trap_does_not_count(driven: Any, trap: str) -> None:
    _, task, track = driven
    conduct = contest.watch(Follower(task, trap), 12, 60.0).conduct
    assert compare(contest.track_conduct(track, 12), conduct) != ""


def test_a_slow_peer_makes_one_step_and_is_compared_on_it(driven: Any) -> None:
    _, task, track = driven
    conduct = contest.watch(Follower(task), 12, 0.0).conduct
    assert conduct.steps == 1
    assert compare(contest.track_conduct(track, 1), conduct) == ""


@pytest.mark.parametrize("trap", ["", "stands", "does not scan", "leaves out a beam"])
def test_what_is_timed_must_be_what_was_watched(driven: Any, trap: str) -> None:
    """A peer that leaves something out as soon as nobody looks."""
    _, task, _ = driven
    follower = Follower(task)
    seen = contest.watch(follower, 12, 60.0)
    follower.trap = trap
    made = contest.drive(follower, 12, 0.0, time.perf_counter)
    assert made.steps == 12
    assert bool(contest.strayed(follower, seen)) == bool(trap)


def test_a_peer_that_sees_nothing_need_not_see_anything_new() -> None:
    class Blind:
        def reset(self) -> None:
            self.x = 0.0

        def step(self, index: int) -> None:
            self.x += 0.1

        def ranges(self) -> Any:
            return np.full((1, BEAMS), self.seen)

        def poses(self) -> Any:
            return np.array([[self.x, 0.0, 0.0]])

    blind = Blind()
    blind.seen = 8.0
    assert contest.watch(blind, 3, 60.0).conduct.all_beams
    blind.seen = 7.9
    assert not contest.watch(blind, 3, 60.0).conduct.all_beams


def test_amorsim_drives_the_same_way_every_time(driven: Any) -> None:
    """What is timed is what the track tells: from the same start, to the bit."""
    ours, task, _ = driven
    contest.drive(ours, 12, 0.0, time.perf_counter)
    end = ours.simulation.true_pose.copy()
    ours.reset()
    np.testing.assert_array_equal(ours.simulation.true_pose, task.starts)
    contest.drive(ours, 12, 0.0, time.perf_counter)
    np.testing.assert_array_equal(ours.simulation.true_pose, end)


def test_scans_that_trail_are_compared_with_those_they_are() -> None:
    from benchmarks.task import Track

    track = Track(mean_range=np.array([1.0, 2.0, 3.0]), way=np.array([0.5, 0.25]), stopped=np.array([0.0, 1.0]))
    assert contest.track_conduct(track, 2).mean_range == 2.5
    late = contest.track_conduct(track, 2, lag=1)
    assert (late.first_range, late.mean_range, late.distance, late.stopped) == (1.0, 1.5, 0.75, 0.5)


def test_the_table_says_what_counts_and_what_each_side_computes() -> None:
    spread = ratio_of([20.0], [10.0])
    rows = [
        Row(section="fleet", setting="one", side="amorsim", unit="robot-steps/s", rounds=(20.0,), note="all"),
        Row(
            section="fleet",
            setting="one",
            side="peer",
            unit="robot-steps/s",
            rounds=(10.0,),
            ratio=Ratio(spread=spread, counts=False, why_not="ways differ"),
            conduct=GOOD,
            note="half",
        ),
    ]
    text = as_text(rows, {"date": "today"}, "python -m benchmarks", (), ["other: not installed"])
    assert "2 x (2 to 2)" in text
    assert "no: ways differ" in text
    assert "mean range 3.200 m, drove 1.000 m in 20 steps, 0% stood" in text
    assert "- amorsim: all" in text
    assert "- peer: half" in text
    assert "other: not installed" in text


@pytest.mark.parametrize(("value", "text"), [(5_263_000.0, "5.26 M"), (1_240.0, "1.24 k"), (0.0135, "0.0135")])
def test_figures_have_three_digits(value: float, text: str) -> None:
    assert figure(value) == text
