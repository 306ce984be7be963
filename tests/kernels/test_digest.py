"""Fingerprints: the same however rows are cut and arrays are laid, and another for any bit that differs."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from amorsim.kernels.text.digest import absorb

MASK = 2**64 - 1


def twin(arrays):
    """The fingerprints (N, 2) of arrays (N, k), one after the other, in Python's whole numbers."""
    found = np.zeros((len(arrays[0]), 2), dtype=np.uint64)
    for i in range(len(found)):
        first = second = 0
        for array in arrays:
            words = squares = 0
            for j, bits in enumerate(array[i].view(np.uint64).tolist()):
                word = (bits + j * 0x6A09E667F3BCC909) * 0x9E3779B97F4A7C15 & MASK
                word = (word ^ word >> 32) * 0x6A09E667F3BCC909 & MASK
                words += word
                squares += word**2
            first = (first ^ words & MASK) * 0x9E3779B97F4A7C15 & MASK
            first ^= first >> 29
            second = (second + squares) * 0x6A09E667F3BCC909 & MASK
            second ^= second >> 32
        found[i] = first, second
    return found


@pytest.mark.parametrize("rows", [1, 2, 3, 8, 9])
@pytest.mark.parametrize("sizes", [(3,), (3, 2, 2, 3, 9), (3, 2, 2, 3, 9, 2, 181, 1)])
def test_arrays_are_mixed_one_after_the_other(rows, sizes):
    draw = np.random.default_rng(rows)
    arrays = [draw.normal(size=(rows, k)) for k in sizes]
    found = np.zeros((rows, 2), dtype=np.uint64)
    absorb(arrays, found)
    np.testing.assert_array_equal(found, twin(arrays))


@given(st.integers(1, 12), st.integers(0, 12))
def test_a_rows_fingerprint_does_not_depend_on_the_other_rows(rows, cut):
    draw = np.random.default_rng(rows)
    arrays = [draw.normal(size=(rows, k)) for k in (3, 2, 5)]
    whole, parts = np.zeros((2, rows, 2), dtype=np.uint64)
    absorb(arrays, whole)
    absorb([array[:cut] for array in arrays], parts[:cut])
    absorb([array[cut:] for array in arrays], parts[cut:])
    np.testing.assert_array_equal(parts, whole)


def test_the_last_bit_of_any_number_tells():
    values = np.random.default_rng(0).normal(size=(1, 7))
    found = np.zeros((8, 2), dtype=np.uint64)
    absorb([values], found[:1])
    for j in range(7):
        changed = values.copy()
        changed[0, j] = np.nextafter(changed[0, j], np.inf)
        absorb([changed], found[j + 1 : j + 2])
    assert len({tuple(row) for row in found.tolist()}) == 8


def test_places_and_the_order_of_arrays_tell():
    values = np.random.default_rng(0).normal(size=(3, 1, 200))
    first, second, third = values
    swapped = first.copy()
    swapped[0, [3, 11]] = first[0, [11, 3]]
    turned = first[:, ::-1].copy()
    orders = [first, second, third], [second, first, third], [swapped, second, third], [turned, second, third], [first]
    found = np.zeros((5, 2), dtype=np.uint64)
    for i, arrays in enumerate(orders):
        absorb(arrays, found[i : i + 1])
    assert len(set(found[:, 0].tolist())) == len(set(found[:, 1].tolist())) == 5
