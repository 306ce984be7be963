"""Arguments are what the annotations of a public function say, or are refused by name before it begins."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import attrs
import numpy as np
import numpy.typing as npt
import pytest

from amorsim.core.arguments import checked
from amorsim.core.parameters import ParameterError

if TYPE_CHECKING:
    from decimal import Decimal

Array = npt.NDArray[np.float64]
KINDS: dict[str, tuple[list[Any], list[Any], str]] = {
    "number": (
        [1, 2.5, np.float32(1), np.int64(3), float("nan"), -float("inf")],
        ["1", True, 1j, None, 10**400],
        "a num",
    ),
    "whole": ([1, np.int64(3), -(10**400)], [1.0, True, "1", None], "a whole number, got"),
    "text": (["", "x"], [b"x", 1, Path("x")], "a text, got"),
    "flag": ([True, np.False_], [0, "yes", None], "True or False, got"),
    "maybe": ([None, 1.5], ["x", [1.0]], "a number or None, got"),
    "path": (["x", Path("x")], [1, b"x"], "a text or a path, got"),
    "word": (["a", "b"], ["c", np.zeros(3), [], None], "'a' or 'b', got"),
    "array": (
        [[1, 2], np.zeros((2, 3)), 3.0, []],
        ["x", [[1], [1, 2]], np.array(["x"]), {}],
        "an array of numbers or None, got",
    ),
    "anything": ([np.array(["x", None], dtype=object)], [[1.0]], "an array or None, got"),
    "pose": ([(1, 2.0), [1, 2], np.zeros(2)], [(1, "2"), (1,), np.zeros(3), 3.0, "12"], "(a number, a number), got"),
    "several": ([["x"], ("x", "y"), []], ["x", iter(["x"]), [1], {"x": 1}], "a list, each a text"),
    "once": ([["x"], iter(["x"])], ["x", 3], "a list, each a text"),
    "table": ([{"x": 1}, {}], [{1: 1}, {"x": "y"}, [1]], "a table from a text to a whole number or None, got"),
    "function": ([print, lambda: 1], [1, "print"], "a function or None, got"),
    "count": ([3], [2.5], "how many there are, got"),
    "unknown": ([1, "x", None], [], ""),
    "free": ([1, "x", None], [], ""),
}


@checked
def function(
    number: float = 0.0,
    whole: int = 0,
    text: str = "",
    flag: bool = False,
    maybe: float | None = None,
    path: str | os.PathLike[str] = "",
    word: Literal["a", "b"] = "a",
    array: Array | None = None,
    anything: npt.NDArray[Any] | None = None,
    pose: tuple[float, float] = (0.0, 0.0),
    several: Sequence[str] = (),
    once: Iterable[str] = (),
    table: Mapping[str, int] | None = None,
    function: Callable[[], None] | None = None,
    count: Annotated[int, "how many there are"] = 0,
    unknown: Decimal | None = None,
    free=None,
) -> str:
    """Called."""
    return "called"


@pytest.mark.parametrize("name", KINDS)
def test_what_fits_is_taken_and_what_does_not_is_refused(name: str) -> None:
    fits, others, words = KINDS[name]
    for value in fits:
        assert function(**{name: value}) == "called"
    for value in others:
        with pytest.raises(ParameterError) as caught:
            function(**{name: value})
        assert caught.value.name == name
        assert f"{name}: expected {words}" in str(caught.value)


def test_a_text_alone_is_shown_as_the_list_that_is_meant() -> None:
    with pytest.raises(ParameterError, match=r"several: expected a list, each a text, as \['x'\], got 'x'"):
        function(several="x")


def test_a_call_that_python_refuses_is_left_to_python() -> None:
    with pytest.raises(TypeError, match="unexpected keyword"):
        function(nothing=1)


def test_a_function_keeps_its_name_and_signature() -> None:
    assert function.__name__ == "function"
    assert function.__doc__ == "Called."


@checked
@attrs.frozen
class Thing:
    """Something with a number."""

    number: float

    @classmethod
    @checked
    def of(cls, text: str) -> Thing:
        """One."""
        return cls(float(text))


def test_a_class_checks_what_it_is_made_of() -> None:
    assert Thing(1.5) == Thing.of("1.5")
    with pytest.raises(ParameterError, match="number: expected a number, got 'x'"):
        Thing("x")
    with pytest.raises(ParameterError, match="text: expected a text, got 3"):
        Thing.of(3)
