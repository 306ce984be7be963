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


@pytest.mark.parametrize(("gap", "has_line"), [(1, True), (3, True), (4, False)])
def test_more_than_three_lost_beams_in_a_row_are_a_gap(gap, has_line):
    """Two points of a wall and, behind a gap, the rest of it: alone they are too few for a line."""
    bearings = np.radians(np.arange(-10.0, 11.0))
    ranges = 1.0 / np.cos(bearings)
    ranges[:5] = ranges[7 : 7 + gap] = np.inf
    lines = outline_of(ranges, bearings).lines
    assert (~np.isnan(lines[5:7, 0])).tolist() == [has_line, has_line]
    assert not np.isnan(lines[7 + gap :, 0]).any()
