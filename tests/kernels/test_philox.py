"""Philox 4x32-10 against the published known answers, and the draws made of it as statistics."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from amorsim.kernels.random.philox import _unit, fill_normal, fill_uniform, philox

# From the known-answer vectors that accompany the authors' Random123 library: counter, key, result.
KNOWN = [
    ((0, 0, 0, 0), (0, 0), (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8)),
    (
        (0xFFFFFFFF,) * 4,
        (0xFFFFFFFF, 0xFFFFFFFF),
        (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD),
    ),
    (
        (0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344),
        (0xA4093822, 0x299F31D0),
        (0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1),
    ),
]


@pytest.mark.parametrize(("counter", "key", "expected"), KNOWN)
def test_known_answers(counter: tuple[int, ...], key: tuple[int, ...], expected: tuple[int, ...]) -> None:
    words = philox(*(np.uint64(word) for word in (*counter, *key)))
    assert tuple(int(word) for word in words) == expected


def counters(count: int) -> np.ndarray:
    made = np.zeros((count, 3), dtype=np.uint32)
    made[:, 2] = np.arange(count)
    return made


def test_normal_draws_are_normal() -> None:
    out = np.empty((20_000, 7))
    fill_normal(np.full(20_000, 12345, dtype=np.uint64), counters(20_000), 0, out)
    flat = out.ravel()
    # Bounds of five standard errors each; the seed is fixed, so this either holds or it does not.
    n = flat.size
    assert abs(flat.mean()) < 5 / np.sqrt(n)
    assert abs(flat.var() - 1) < 5 * np.sqrt(2 / n)
    assert abs(stats.kurtosis(flat)) < 5 * np.sqrt(24 / n)
    assert stats.kstest(flat, "norm").pvalue > 1e-3


def test_uniform_draws_are_uniform_and_never_0_or_1() -> None:
    out = np.empty((20_000, 5))
    fill_uniform(np.full(20_000, 99, dtype=np.uint64), counters(20_000), 3, out)
    assert out.min() > 0.0
    assert out.max() < 1.0
    assert stats.kstest(out.ravel(), "uniform").pvalue > 1e-3


def test_the_largest_words_make_a_draw_below_1_and_all_others_keep_their_bits() -> None:
    ones = 0xFFFFFFFF
    assert _unit(np.uint64(ones), np.uint64(ones)) == 1.0 - 2.0**-53
    for high, low in ((ones, ones - 64), (ones - 32, ones), (0x80000000, 0), (0, 0)):
        bits = (high >> 5) << 26 | low >> 6
        assert _unit(np.uint64(high), np.uint64(low)) == (float(bits) + 0.5) * 2.0**-53 < 1.0


def test_draws_of_ticks_columns_and_keys_are_uncorrelated() -> None:
    n = 50_000
    one, other = np.empty((n, 4)), np.empty((n, 4))
    fill_normal(np.full(n, 1, dtype=np.uint64), counters(n), 0, one)
    fill_normal(np.full(n, 2, dtype=np.uint64), counters(n), 0, other)
    columns = np.column_stack((one, other, np.roll(one, 1, axis=0)))
    correlations = np.corrcoef(columns.T) - np.eye(12)
    # 66 pairs, each of standard error 1 / sqrt(n): the largest of them beyond five has odds of 4e-5.
    assert np.abs(correlations).max() < 5 / np.sqrt(n)


def test_a_draw_does_not_depend_on_how_many_are_asked_for() -> None:
    keys = np.arange(3, dtype=np.uint64)
    few, many = np.empty((3, 3)), np.empty((3, 8))
    fill_normal(keys, counters(3), 5, few)
    fill_normal(keys, counters(3), 5, many)
    assert (few == many[:, :3]).all()
