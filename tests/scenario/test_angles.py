"""Degrees in files and radians in Python, there and back to the same bits."""

import copy
import math
import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st

from amorsim.scenario.toml.angles import LongDegrees, parse_float, to_degrees, to_radians

ANGLES = st.floats(allow_nan=False, allow_infinity=False, min_value=-1e6, max_value=1e6)


@given(ANGLES)
def test_radians_survive_being_written_in_degrees_and_read_again(radians):
    degrees = to_degrees(radians)
    text = degrees.text if isinstance(degrees, LongDegrees) else repr(degrees)
    assert to_radians(degrees) == radians
    assert to_radians(parse_float(text)) == radians


@given(st.decimals(min_value=-720, max_value=720, places=4))
def test_degrees_that_a_person_writes_come_back_as_they_were(degrees):
    assert to_degrees(to_radians(float(degrees))) == float(degrees)
    assert not isinstance(to_degrees(to_radians(float(degrees))), LongDegrees)


def test_some_radians_are_the_image_of_no_double_in_degrees():
    # A tenth of all: this is why degrees may be written with more digits than a double holds.
    long = [angle for angle in (1.2 + i * 2.0**-52 for i in range(200)) if isinstance(to_degrees(angle), LongDegrees)]
    assert 5 < len(long) < 50
    for angle in long:
        near = math.degrees(angle)
        tried = [near + i * math.ulp(near) for i in range(-8, 9)]
        assert angle not in [math.radians(degrees) for degrees in tried]


@pytest.mark.parametrize("text", ["1.5", "0.1", "-0.0", "1e-3", "57.295779513082323", "1_000.5", "180.0"])
def test_numbers_as_short_as_a_double_are_plain_floats(text):
    plain = text.replace("_", "")
    number = parse_float(text)
    assert number == float(plain)
    assert isinstance(number, LongDegrees) == (len(plain) > 17)


@pytest.mark.parametrize("text", ["inf", "-inf", "nan"])
def test_what_is_not_finite_is_left_to_the_fields(text):
    assert repr(parse_float(text)) == repr(float(text))


def test_long_degrees_are_copied_and_pickled_with_all_digits():
    number = LongDegrees("57.29577951308232087679")
    for same in (copy.deepcopy(number), pickle.loads(pickle.dumps(number))):
        assert same == number
        assert same.text == number.text


def test_degrees_are_exact_at_the_turns():
    assert [to_radians(degrees) for degrees in (0.0, 90.0, 180.0, 360.0)] == [0.0, math.pi / 2, math.pi, 2 * math.pi]
    assert [to_degrees(radians) for radians in (0.0, math.pi / 2, -math.pi, math.tau)] == [0.0, 90.0, -180.0, 360.0]
