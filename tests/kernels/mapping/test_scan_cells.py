"""The cells that scans say something about, against looking at every cell."""

import math

import numpy as np
import pytest

from amorsim.kernels.mapping.occupancy import Evidence, Scans, add_counts, add_log_odds
from amorsim.kernels.mapping.scan_cells import Area, window_for

AREA = Area(24, 31, 0.5)
ORIGIN = np.array([[-3.0, 1.0]])
NONE = np.inf


def scans(poses, ranges, bearings=(0.0,), range_max=100.0):
    bearings = np.array([bearings], dtype=float)
    poses, ranges = np.array(poses, dtype=float), np.array(ranges, dtype=float)
    fresh = np.ones((len(poses), 1), dtype=bool)
    return Scans(poses, ranges, fresh, np.cos(bearings), np.sin(bearings), np.array([[range_max]]))


def counted(given, origin=ORIGIN, area=AREA):
    rows = len(given.poses)
    hits, misses = np.zeros((2, rows, area.rows * area.cols), dtype=np.int32)
    room = window_for(area, float(given.range_max[0, 0]))
    add_counts(area, np.repeat(origin, rows, axis=0), given, room, hits, misses)
    return hits.reshape(rows, area.rows, area.cols), misses.reshape(rows, area.rows, area.cols)


def touched(x, y, dx, dy, length, area=AREA):
    """Cells whose closed square, a hair smaller or larger, a segment meets (slab test): surely, and perhaps."""
    found = []
    for grown in (-1e-9, 1e-9):
        cells = np.zeros((area.rows, area.cols), dtype=bool)
        for row in range(area.rows):
            for col in range(area.cols):
                low, high = 0.0, length
                for start, d, line in ((x, dx, col), (y, dy, row)):
                    a, b = line - grown - start, line + 1 + grown - start
                    if d == 0.0:
                        if a > 0.0 or b < 0.0:
                            high = -1.0
                        continue
                    low, high = max(low, min(a / d, b / d)), min(high, max(a / d, b / d))
                cells[row, col] = low <= high
        found.append(cells)
    return found


def check_beam(pose, length):
    pose = np.array(pose, dtype=float)
    hits, misses = counted(scans([pose], [[length]]))
    x, y = (pose[:2] - ORIGIN[0]) / AREA.resolution
    sure, perhaps = touched(x, y, math.cos(pose[2]), math.sin(pose[2]), length / AREA.resolution)
    seen = (hits[0] + misses[0]) > 0
    assert (hits[0] + misses[0]).max() <= 1
    assert not (sure & ~seen).any()
    assert not (seen & ~perhaps).any()
    # One cell after the other, side by side: as many as there are lines crossed, and the first.
    rows, cols = np.nonzero(seen)
    assert seen.sum() == 1 + np.ptp(rows) + np.ptp(cols)


@pytest.mark.parametrize("seed", range(10))
def test_a_beam_sees_the_cells_that_its_line_touches(seed):
    rng = np.random.default_rng(seed)
    for _ in range(12):
        check_beam(rng.uniform((-2.9, 1.1, -math.pi), (12.4, 12.9, math.pi)), rng.uniform(0.0, 6.0))


@pytest.mark.parametrize("quarter", range(4))
def test_a_beam_along_an_axis_sees_a_row_of_cells(quarter):
    hits, misses = counted(scans([[4.3, 7.3, quarter * math.pi / 2.0]], [[2.0]]))
    assert hits.sum() == 1
    assert misses.sum() == 4


def test_beams_through_corners_see_a_chain_of_cells():
    for heading in (0.25, 0.75, -0.25, -0.75):
        hits, misses = counted(scans([[4.0, 7.0, heading * math.pi]], [[2.0 * math.sqrt(2.0) - 0.1]]))
        rows, cols = np.nonzero((hits + misses)[0])
        assert len(rows) == 1 + np.ptp(rows) + np.ptp(cols)


def test_a_cell_is_hit_or_missed_once_in_a_scan_and_a_hit_goes_first():
    # Three beams into one direction: two end in a cell that the third one crosses.
    hits, misses = counted(scans([[0.25, 3.25, 0.0]], [[1.0, 1.1, 3.0]], bearings=(0.0, 0.0, 0.0)))
    row = 4
    assert hits[0, row].nonzero()[0].tolist() == [8, 12]
    assert misses[0, row].nonzero()[0].tolist() == [6, 7, 9, 10, 11]
    assert hits.max() == misses.max() == 1


def test_a_beam_that_saw_nothing_is_free_to_its_longest_range():
    hits, misses = counted(scans([[0.25, 3.25, 0.0]], [[NONE]], range_max=1.5))
    assert hits.sum() == 0
    assert misses[0, 4].nonzero()[0].tolist() == [6, 7, 8, 9]


@pytest.mark.parametrize("value", [-np.inf, np.nan])
def test_a_beam_that_was_too_near_or_lost_says_nothing(value):
    hits, misses = counted(scans([[0.25, 3.25, 0.0]], [[value]]))
    assert hits.sum() == misses.sum() == 0


def test_beams_end_at_the_border_of_the_area():
    hits, misses = counted(scans([[12.0, 3.25, 0.0]], [[10.0]]))
    assert hits.sum() == 0
    assert misses[0, 4].nonzero()[0].tolist() == [30]
    hits, misses = counted(scans([[13.1, 3.25, math.pi]], [[2.0]]))  # from outside
    assert hits[0, 4].nonzero()[0].tolist() == [28]
    assert misses[0, 4].nonzero()[0].tolist() == [29, 30]


def test_evidence_adds_up_and_is_bounded():
    bound = Evidence(*np.array((2.0, -0.5, -1.2, 5.0), dtype=np.float32))
    log_odds = np.full((1, AREA.rows * AREA.cols), np.nan, dtype=np.float32)
    given = scans([[0.25, 3.25, 0.0]], [[1.0]])
    room = window_for(AREA, 100.0)
    for count in range(1, 4):
        add_log_odds(AREA, ORIGIN, given, bound, room, log_odds)
        row = log_odds.reshape(AREA.rows, AREA.cols)[4]
        assert row[8] == min(2.0 * count, 5.0)
        assert row[7] == np.float32(max(-0.5 * count, -1.2))
        assert np.isnan(row[9])
        assert np.isfinite(log_odds).sum() == 3


def test_rows_that_have_no_new_scan_keep_their_map():
    given = scans([[0.25, 3.25, 0.0]] * 2, [[1.0], [1.0]])
    given = given._replace(fresh=np.array([[False], [True]]))
    hits, misses = counted(given)
    assert hits[0].sum() == misses[0].sum() == 0
    assert hits[1].sum() == 1
