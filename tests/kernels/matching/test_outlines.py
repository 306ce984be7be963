"""Lines through the points of a scan."""

import numpy as np
import pytest

from tests.kernels.matching.scenes import WHOLE, outline_of, room, scan


def lost(ranges, share, seed):
    """The scan without a share of its beams, and which it has left."""
    is_left = np.random.default_rng(seed).random(len(ranges)) >= share
    return np.where(is_left, ranges, np.inf), is_left


@pytest.mark.parametrize("seed", range(3))
def test_a_lost_beam_is_no_gap_in_a_wall(seed):
    """When lines ended there, a quarter of the points had none with 30 % of the beams lost."""
    ranges, _ = scan(room(), (3.4, 1.9, 0.3), WHOLE)
    whole = outline_of(ranges, WHOLE)
    ranges, is_left = lost(ranges, 0.3, seed)
    found = outline_of(ranges, WHOLE)
    has_line = ~np.isnan(whole.lines[:, 0]) & is_left
    assert np.isnan(found.lines[~is_left]).all()
    assert np.isnan(found.lines[has_line, 0]).mean() < 0.12
    both = has_line & ~np.isnan(found.lines[:, 0])
    turned = np.abs((whole.lines[both, 2:] * found.lines[both, 2:]).sum(axis=1))
    assert np.quantile(turned, 0.05) > np.cos(0.02)
