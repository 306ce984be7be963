"""Draws: keyed by names, counted by replica, episode and tick."""

from __future__ import annotations

import numpy as np
import pytest

from amorsim.core import draws as module
from amorsim.core.draws import Draws, check_collisions, stream_key
from amorsim.core.errors import AmorsimError


def make(key: int = 7, rows: int = 2, replica: int = 0, episode: int = 0, tick: int = 0) -> Draws:
    counter = np.tile(np.array([replica, episode, tick], dtype=np.uint32), (rows, 1))
    return Draws(np.full(rows, key, dtype=np.uint64), counter)


def test_each_call_of_a_tick_takes_the_next_numbers() -> None:
    draws = make()
    first, second = draws.normal(3), draws.normal(3)
    assert not (first == second).any()
    draws.rewind()
    assert (draws.normal(3) == first).all()


@pytest.mark.parametrize("change", [{"replica": 1}, {"episode": 1}, {"tick": 1}, {"key": 8}])
def test_every_part_of_key_and_counter_counts(change: dict[str, int]) -> None:
    assert not (make().uniform(4) == make(**change).uniform(4)).any()


def test_keys_depend_on_seed_and_every_name() -> None:
    keys = {
        stream_key(1, "rover", "laser"),
        stream_key(2, "rover", "laser"),
        stream_key(1, "rover", "sonar"),
        stream_key(1, "roverlaser"),
        stream_key(1, "rover", "laser", "gaussian"),
    }
    assert len(keys) == 5


def test_the_key_of_a_stream_never_changes() -> None:
    # Written down, because every recorded run depends on it.
    assert stream_key(7, "rover", "sensor", "laser") == 16912801849163197121


def test_a_collision_is_an_error_that_names_both(monkeypatch: pytest.MonkeyPatch) -> None:
    check_collisions(1, [("a", "x"), ("b", "x"), ("a", "x")])
    monkeypatch.setattr(module, "stream_key", lambda seed, *names: 5)
    with pytest.raises(AmorsimError, match=r"seed 1 .* b x and a x"):
        check_collisions(1, [("a", "x"), ("b", "x")])
