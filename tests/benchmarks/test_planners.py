"""The section of planners: all sides find the same lengths, so that their ratios count."""

from __future__ import annotations

import time

import pytest

from benchmarks import planners


def test_all_sides_find_the_same_lengths() -> None:
    world, name = planners._world(quick=True)
    free = world.to_array() == 0
    problems = planners._problems(free, 3)
    sides = planners._searchers(world, free, lambda _: None)
    rows = planners._race(f"A*, {name}", sides, problems, 2, time.perf_counter, lambda _: None)
    assert rows[0].side == "amorsim"
    assert rows[0].ratio is None
    assert all(row.ratio is not None and row.ratio.counts for row in rows[1:])
    assert all(len(row.rounds) == 2 for row in rows)
    fields = planners._fields(world, free, lambda _: None)
    lengths = [[solve(problem) for problem in problems] for solve in fields.values()]
    for others in lengths[1:]:
        assert others == pytest.approx(lengths[0], abs=1e-6)


def test_a_side_that_finds_other_lengths_has_no_ratio_that_counts() -> None:
    sides = {"amorsim": lambda _: 2.0, "a peer": lambda _: 1.9}
    rows = planners._race("A*", sides, [((0, 0), (0, 2))], 2, time.perf_counter, lambda _: None)
    assert rows[1].ratio is not None
    assert not rows[1].ratio.counts
    assert "a length differs by 0.1 cells" in rows[1].ratio.why_not
