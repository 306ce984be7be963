"""Which window has the controls."""

from __future__ import annotations

import pytest

from amorsim.core.errors import AmorsimError
from amorsim.ui.simulator.controls import GRACE, Controls


class Clock:
    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def test_the_first_window_has_them_and_others_watch() -> None:
    controls = Controls(Clock())
    first, second = controls.open("one"), controls.open("two")
    assert controls.state() == {"holder": first, "asking": []}
    with pytest.raises(AmorsimError, match="another window has the controls"):
        controls.carry_out(second, {"want": "take"})


def test_they_wait_for_a_window_that_is_loaded_again() -> None:
    clock = Clock()
    controls = Controls(clock)
    first, second = controls.open("one"), controls.open("two")
    controls.carry_out(second, {"want": "ask"})
    assert controls.close(first)
    third = controls.open("three")
    controls.carry_out(third, {"want": "ask"})
    clock.now += 0.9 * GRACE
    assert controls.state() == {"holder": "", "asking": [second, third]}
    again = controls.open("one")
    assert controls.state() == {"holder": again, "asking": [second, third]}
    clock.now += GRACE
    assert controls.state()["holder"] == again


def test_after_a_while_they_go_to_the_first_that_asks_or_comes() -> None:
    clock = Clock()
    controls = Controls(clock)
    first, second = controls.open("one"), controls.open("two")
    controls.carry_out(second, {"want": "ask"})
    controls.close(first)
    clock.now += GRACE
    assert controls.state() == {"holder": second, "asking": []}
    controls.close(second)
    clock.now += 1.1 * GRACE
    assert controls.state()["holder"] == ""
    assert controls.state()["holder"] == ""
    third = controls.open("three")
    assert controls.holder == third


def test_a_window_that_is_alone_does_not_wait() -> None:
    controls = Controls(Clock())
    controls.close(controls.open("one"))
    second = controls.open("two")
    assert controls.holder == second
    assert controls.open("one") != controls.holder


def test_a_user_who_takes_them_does_not_wait() -> None:
    controls = Controls(Clock())
    first, second = controls.open("one"), controls.open("two")
    controls.close(first)
    assert controls.carry_out(second, {"want": "take"})["holder"] == second
    assert controls.open("one") != controls.holder


def test_a_tab_that_was_copied_is_not_waited_for_while_its_copy_is_there() -> None:
    controls = Controls(Clock())
    first, copy = controls.open("one"), controls.open("one")
    assert controls.holder == first
    controls.carry_out(copy, {"want": "ask"})
    controls.close(first)
    assert controls.holder == copy


def test_windows_that_tell_no_tab_are_not_waited_for() -> None:
    controls = Controls(Clock())
    first, second = controls.open(), controls.open()
    controls.carry_out(second, {"want": "ask"})
    controls.close(first)
    assert controls.holder == second
