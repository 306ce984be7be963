"""Box and Muller's transform against longer arithmetic, and where its logarithm and its angle are hardest."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from amorsim.kernels.random.normals import normals

STEP = 2.0**-54  # the least uniform draw
# Of a normal draw: what its own last place, those of a logarithm and a root, and those of a sine add up to.
TOLERANCE = 1e-15


def transformed(first, second):
    """Normal draws of uniform ones."""
    radius, other = np.array(first, dtype=float), np.array(second, dtype=float)
    normals(radius, other, radius.view(np.int64), np.empty(len(radius)))
    return radius, other


def expected(first, second):
    """The same in numbers of 64 bits and more in the mantissa, where the processor has them."""
    first, second = np.array(first, dtype=np.longdouble), np.array(second, dtype=np.longdouble)
    radius = np.sqrt(-2 * np.log(first))
    angle = 2 * np.arctan2(np.longdouble(0), np.longdouble(-1)) * second
    return radius, np.cos(angle), np.sin(angle)


def check(first, second):
    made = transformed(first, second)
    radius, cos, sin = expected(first, second)
    for got, part in zip(made, (cos, sin), strict=True):
        assert (np.abs(got - radius * part) <= TOLERANCE * radius).all()


def test_a_million_draws_agree_with_longer_arithmetic():
    draws = np.random.default_rng(1).random((2, 1_000_000)) * (1 - 2 * STEP) + STEP
    check(*draws)


def test_the_ends_and_the_quarters_of_both_draws_agree_with_longer_arithmetic():
    near = [0.25, 0.5, 0.75, math.sqrt(0.5), 0.125, 0.375, 0.625, 0.875]
    places = [STEP, 2 * STEP, 3 * STEP, 1e-9, 1 - 1e-9, 1 - 2 * STEP, *near]
    places += [np.nextafter(place, way) for place in near for way in (0.0, 1.0)]
    check(*(grid.ravel() for grid in np.meshgrid(places, places)))


def test_the_radius_is_good_to_its_own_size_where_it_is_small():
    """Near 1 the logarithm is small, and would be lost in a sum."""
    first = 1 - 2.0 ** -np.arange(3, 54)
    radius, _ = transformed(first, np.zeros(len(first)))
    np.testing.assert_allclose(radius, expected(first, 0.0)[0].astype(float), rtol=TOLERANCE)


@given(st.lists(st.tuples(st.floats(STEP, 1 - STEP), st.floats(STEP, 1 - STEP)), min_size=1, max_size=40))
def test_a_pair_has_the_same_bits_in_any_company(pairs):
    """Whether several go side by side or one goes alone."""
    first, second = np.array(pairs).T
    together = transformed(first, second)
    for k in range(len(pairs)):
        alone = transformed(first[k : k + 1], second[k : k + 1])
        assert (alone[0][0], alone[1][0]) == (together[0][k], together[1][k])
