"""Elementary functions of arrays: the bits of the C library, whatever instructions the processor has."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from amorsim.kernels import elementary

RNG = np.random.default_rng(1)
SPREAD = RNG.uniform(-5.0, 5.0, 2000)
POSITIVE = RNG.uniform(1e-6, 50.0, 2000)


@pytest.mark.parametrize(
    ("function", "expected", "arguments"),
    [
        (elementary.exp, math.exp, [SPREAD]),
        (elementary.expm1, math.expm1, [SPREAD]),
        (elementary.log, math.log, [POSITIVE]),
        (elementary.log1p, math.log1p, [POSITIVE]),
        (elementary.arccos, math.acos, [SPREAD / 5.0]),
        (elementary.arctan2, math.atan2, [SPREAD, SPREAD[::-1]]),
        (elementary.power, math.pow, [POSITIVE, SPREAD]),
        (elementary.power, math.pow, [POSITIVE, np.full(2000, 3.0)]),
    ],
)
def test_the_bits_are_those_of_the_c_library(
    function: Callable[..., Any], expected: Callable[..., float], arguments: list[Any]
) -> None:
    found = function(*arguments)
    assert np.array_equal(found, [expected(*map(float, each)) for each in zip(*arguments, strict=True)])


def test_shapes_are_broadcast_and_views_are_taken_as_they_are() -> None:
    column, row = SPREAD[:6].reshape(6, 1), SPREAD[:20:2]
    found = elementary.arctan2(column, row)
    assert found.shape == (6, 10)
    assert found[4, 3] == math.atan2(column[4, 0], row[3])
    assert elementary.exp(0.0).shape == ()
    assert float(elementary.exp(1.0)) == math.exp(1.0)
    assert elementary.exp(SPREAD[:8].reshape(2, 4).T).shape == (4, 2)
    assert np.array_equal(elementary.exp(SPREAD[:8].reshape(2, 4).T), elementary.exp(SPREAD[:8]).reshape(2, 4).T)


def test_kernels_get_arrays_that_may_be_written_to() -> None:
    """NumPy warns whoever asks that of an array that it has broadcast without a copy; numba asks at a first call."""
    given: list[Any] = []
    elementary._each(lambda *arrays: given.extend(arrays), np.ones((1, 1)), np.ones(1), 2.0)
    assert all(array.flags.writeable and array.shape == (1,) for array in given)


def test_nothing_that_a_step_computes_takes_numpys_own() -> None:
    package = Path(elementary.__file__).parents[1]
    own = re.compile(r"np\.(exp|expm1|exp2|log|log1p|log2|log10|arccos|arcsin|arctan|arctan2|tan|power|cbrt)\(")
    without = {"analysis", "reports", "render", "ui", "cli", "studies", "sweeps", "learning"}  # which no run depends on
    files = [file for file in package.rglob("*.py") if file.relative_to(package).parts[0] not in without]
    assert len(files) > 300
    assert [str(file) for file in files if own.search(file.read_text(encoding="utf-8"))] == []


def test_the_edges_are_numpys() -> None:
    edges = np.array([0.0, -0.0, np.inf, -np.inf, np.nan, -1.0, 1e300])
    with np.errstate(all="ignore"):
        assert np.array_equal(elementary.exp(edges), np.exp(edges), equal_nan=True)
        assert np.array_equal(elementary.log(edges), np.log(edges), equal_nan=True)
        assert np.array_equal(elementary.log1p(edges), np.log1p(edges), equal_nan=True)
        assert np.array_equal(elementary.expm1(edges), np.expm1(edges), equal_nan=True)
        assert np.array_equal(elementary.arccos(edges), np.arccos(edges), equal_nan=True)
