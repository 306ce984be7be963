"""Parameters check what they are given, and describe themselves."""

from __future__ import annotations

import math

import attrs
import pytest

from amorsim.core.errors import ComponentError
from amorsim.core.parameters import ParameterError, describe, parameter
from amorsim.core.poses import Mount


@attrs.frozen(kw_only=True)
class Thing:
    """One parameter of each kind."""

    length: float = parameter(1.0, unit="m", gt=0, le=10, help="how long")
    count: int = parameter(3, ge=1, static=True)
    mode: str = parameter("a", choices=("a", "b"))
    flag: bool = parameter(False)
    limit: float | None = parameter(None, unit="rad/s", ge=0)
    pair: tuple[float, float] = parameter((0.0, 1.0))
    many: tuple[int, ...] = parameter(())
    mount: Mount = parameter(Mount())
    needed: float = parameter(unit="m")


def make(**values: object) -> Thing:
    return Thing(**({"needed": 1.0} | values))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"length": 0.0}, r"length: expected a number \[m\] > 0 and <= 10, got 0.0"),
        ({"length": math.nan}, "got nan"),
        ({"length": math.inf}, "got inf"),
        ({"length": "1"}, "got '1'"),
        ({"length": True}, "got True"),
        ({"length": None}, "got None"),
        ({"needed": 10**400}, "got 1000"),
        ({"count": 1.0}, "a whole number >= 1, got 1.0"),
        ({"count": 0}, "got 0"),
        ({"count": True}, "got True"),
        ({"mode": "c"}, "one of 'a', 'b', got 'c'"),
        ({"flag": 1}, "true or false, got 1"),
        ({"limit": -1.0}, r"a number or nothing \[rad/s\] >= 0, got -1.0"),
        ({"pair": (1.0,)}, "it has 1 elements, not 2"),
        ({"pair": [1.0, 2.0]}, r"a list of 2, .*got \[1\.0, 2\.0\]: in Python write a tuple, in round brackets"),
        ({"many": (1, 2.5)}, r"\(element 1\)"),
        ({"mount": 3}, "a table of x, y, heading, got 3"),
    ],
)
def test_wrong_values_are_refused_with_what_was_expected(values: dict[str, object], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        make(**values)


def test_right_values_are_taken_as_they_are() -> None:
    thing = make(length=2, limit=None, many=(1, 2), mount=Mount(x=1.0))
    assert thing.length == 2
    assert type(thing.length) is int  # nothing is coerced


def test_they_describe_themselves() -> None:
    parameters = describe(Thing)
    assert parameters["length"].expectation == "a number [m] > 0 and <= 10"
    assert parameters["needed"].is_required
    assert not parameters["length"].is_required
    assert parameters["limit"].is_angle
    assert not parameters["length"].is_angle
    assert parameters["count"].static
    assert not parameters["count"].live
    assert parameters["length"].live
    assert parameters["length"].help == "how long"


def test_a_word_or_something_measured_is_expected_in_these_words() -> None:
    @attrs.frozen(kw_only=True)
    class Start:
        random: str | tuple[float, float] = parameter("anywhere", unit="m", choices=("anywhere",))

    assert describe(Start)["random"].expectation == "'anywhere' or a list of 2, each a number [m]"
    with pytest.raises(ParameterError, match=r"expected 'anywhere' or a list of 2, each a number \[m\], got True"):
        Start(random=True)


def test_an_element_of_an_element_is_reported_once() -> None:
    @attrs.frozen(kw_only=True)
    class Way:
        places: tuple[tuple[float, float], ...] = parameter(unit="m")

    with pytest.raises(ParameterError, match=r"got nan \(element 2\.1\)$"):
        Way(places=((0.0, 1.0), (0.0, 1.0), (0.0, math.nan)))
    with pytest.raises(ParameterError, match=r"it has 1 elements, not 2 \(element 1\)$"):
        Way(places=((0.0, 1.0), (0.0,)))  # type: ignore[arg-type]


def test_a_field_without_an_annotation_is_named() -> None:
    @attrs.frozen(kw_only=True)
    class Unsaid:
        share = parameter(0.1)

    with pytest.raises(ComponentError, match=r"^field 'share' of Unsaid has no annotation, such as share: float$"):
        Unsaid()
