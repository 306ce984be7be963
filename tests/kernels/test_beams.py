"""Likelihoods of scans, against sums written out."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from amorsim.core.maps.map import Map
from amorsim.estimators.known_map import PARTS, Ends, field_from, field_of, place_of
from amorsim.kernels.filters.beams import Mixture, Scan, beam_probability, weigh_by_beams, weigh_by_field

STD = 0.2


def mixture(hit=0.5, short=0.0, most=0.0, random=0.5, hit_std=STD, short_rate=0.1):
    hit, short, most, random, short_rate = (np.array([[value]]) for value in (hit, short, most, random, short_rate))
    return Mixture(hit, short, most, random, hit_std, short_rate)


def scan(ranges, bearings, mount=(0.0, 0.0, 0.0), range_max=20.0):
    columns = (np.array([[value]]) for value in (*mount, range_max))
    return Scan(np.array([ranges]), np.array([bearings]), *columns)


def beluga():
    """The grid of Beluga's tests: 5 x 5 cells of 0.5 m, the middle one occupied."""
    cells = np.zeros((5, 5), dtype=np.uint8)
    cells[2, 2] = 1
    return Map.from_array(cells, resolution=0.5)


def weigh(world, poses, seen, mix, cubed=False, resolution=0.5, distance_max=2.0):
    out, poses = np.empty(len(poses)), np.array(poses)
    turns = np.stack((np.sin(poses[:, 2]), np.cos(poses[:, 2])))
    ends = Ends(STD, distance_max, mix.hit[0, 0], mix.random[0, 0] / seen.range_max[0, 0], seen.ranges.shape[1], cubed)
    count = weigh_by_field(0, poses, turns, seen, field_of(world, resolution, ends), place_of(world), cubed, out)
    return count, out


@pytest.mark.long
def test_the_cubed_weight_is_that_of_beluga():
    """Beluga takes distances to the middles of occupied cells; the field is made of these here."""
    margin = 4
    row, col = np.mgrid[0:13, 0:13]
    away = np.rint(PARTS * np.hypot(row - 6, col - 6)).astype(np.int32)
    field = field_from(np.minimum(away, PARTS * margin), 0.5, margin, Ends(STD, 2.0, 0.5, 0.5 / 20.0, 1, True))
    diagonal, out = scan([math.hypot(1.25, 1.25)], [math.pi / 4]), np.empty(2)
    turns = np.array([[0.0, 0.0], [1.0, -1.0]])
    poses = np.array([(0.0, 0.0, 0.0), (0.0, 0.0, math.pi)])
    assert weigh_by_field(0, poses, turns, diagonal, field, place_of(beluga()), True, out) == 1
    assert math.exp(out[0]) == pytest.approx(2.068577607986223, abs=1e-9)
    assert math.exp(out[1]) == pytest.approx(1.0, abs=1e-4)


def surface_away(cells, row, col):
    """How far the middle of a cell is from where walls begin, in cells; free cells are all around."""
    is_wall = 0 <= row < cells.shape[0] and 0 <= col < cells.shape[1] and cells[row, col]
    others = np.argwhere(np.pad(cells, 1) == 0) - 1 if is_wall else np.argwhere(cells)
    return round(PARTS * (np.hypot(*(others - (row, col)).T).min() - 0.5)) / PARTS


def test_the_log_likelihood_is_the_sum_over_beams():
    rng = np.random.default_rng(4)
    cells = (rng.random((40, 60)) < 0.05).astype(np.uint8)
    world = Map.from_array(cells, resolution=0.1, origin=(1.0, -2.0, 0.7))
    ranges = np.concatenate((rng.uniform(0.1, 5.0, 70), [np.inf, np.nan, -np.inf]))
    bearings = rng.uniform(-3.0, 3.0, 73)
    mount = (0.2, -0.1, 0.3)
    poses = np.column_stack((rng.uniform(0.0, 4.0, 50), rng.uniform(-2.0, 4.0, 50), rng.uniform(-3.0, 3.0, 50)))
    count, found = weigh(world, poses, scan(ranges, bearings, mount), mixture(), resolution=0.1)
    assert count == 70
    for pose, value in zip(poses, found, strict=True):
        c, s = math.cos(pose[2]), math.sin(pose[2])
        total = 0.0
        for r, b in zip(ranges[:70], bearings[:70], strict=True):
            along, aside = mount[0] + r * math.cos(b + mount[2]), mount[1] + r * math.sin(b + mount[2])
            x, y = pose[0] + c * along - s * aside - 1.0, pose[1] + s * along + c * aside + 2.0
            x, y = math.cos(0.7) * x + math.sin(0.7) * y, math.cos(0.7) * y - math.sin(0.7) * x
            col, row = math.floor(x / 0.1), math.floor(y / 0.1)
            away = min(0.1 * surface_away(cells, row, col), 2.0)
            total += math.log(0.5 * norm.pdf(away, scale=STD) + 0.5 / 20.0)
        # Half a unit a beam: the peak, 3.7 above the rest, is 2**31 / 73 units high.
        assert value == pytest.approx(total, abs=70 * 0.5 * 3.7 * 73 / 2**31)


@pytest.mark.parametrize("expected", [3.0, 7.9, math.inf])
def test_the_densities_of_the_beam_model_add_up_to_one(expected):
    shares = (0.6, 0.1, 0.05, 0.25, STD, 0.4)

    def density(r):
        return beam_probability(r, expected, 8.0, *shares)

    whole = quad(density, 0.0, 8.0, points=[min(expected, 8.0)], limit=200)[0] + density(math.inf)
    lost = 0.6 * norm.cdf(0.0, loc=expected, scale=STD) if expected < 8.0 else 0.0
    assert whole == pytest.approx(1.0 - lost, abs=1e-3)


@pytest.mark.long
def test_the_beam_model_expects_what_a_laser_would_read():
    world = Map.from_segments([(0, 0, 6, 0), (6, 0, 6, 4), (6, 4, 0, 4), (0, 4, 0, 0), (2, 0, 2, 1.5)], resolution=0.01)
    pose = np.array([[1.2, 2.1, 0.4]])
    bearings = np.linspace(-3.0, 3.0, 24)
    ranges = world.cast_rays(pose, bearings, 8.0)[0]
    rest = mixture(hit=0.7, short=0.1, most=0.1, random=0.1)
    out, off = np.empty(1), np.empty(1)
    seen = scan(ranges, bearings, range_max=8.0)
    assert weigh_by_beams(0, pose, seen, rest, world.grid, place_of(world), False, out) == 24
    each = 0.7 * norm.pdf(0.0, scale=STD) + 0.1 / 8.0
    assert out[0] == pytest.approx(24 * math.log(each), rel=1e-12)  # nothing is nearer than expected
    weigh_by_beams(0, np.add(pose, (0.2, 0.1, 0.05)), seen, rest, world.grid, place_of(world), False, off)
    assert off[0] < out[0] - 5.0


def test_a_beam_that_ends_beyond_the_field_counts_as_far_from_any_wall():
    far = scan([15.0], [0.0])
    _, out = weigh(beluga(), [(0.0, 0.0, 0.3)], far, mixture(), distance_max=0.5)
    assert out[0] == pytest.approx(math.log(0.5 * norm.pdf(0.5, scale=STD) + 0.5 / 20.0), abs=1e-8)


@pytest.mark.parametrize("beams", [1, 15, 16, 17, 64])
def test_as_many_beams_count_as_there_are(beams):
    ranges = np.full(beams, math.hypot(1.25, 1.25))
    count, out = weigh(beluga(), [(0.0, 0.0, math.pi / 4)], scan(ranges, np.zeros(beams)), mixture())
    assert count == beams
    inside = 0.25  # [m] from the middle of the cell to its sides
    each = math.log(0.5 * norm.pdf(inside, scale=STD) + 0.5 / 20.0)
    # Half a unit a beam, as above.
    assert out[0] == pytest.approx(beams * each, abs=beams * 0.5 * 3.7 * beams / 2**31)


def test_a_pose_that_is_no_number_weighs_as_one_far_from_any_wall():
    count, out = weigh(beluga(), [(math.nan, 0.0, 0.0)], scan([1.0, 1.0], [0.0, 1.0]), mixture())
    assert count == 2
    assert out[0] == pytest.approx(2.0 * math.log(0.5 / 20.0), abs=1e-6)


def test_the_field_is_right_from_which_side_a_wall_is_seen():
    """A wall from x = 2.003 m to 2.104 m; cells of 0.05 m see its surfaces where they are, to half a finer cell."""
    world = Map.from_segments([(0, 0, 4, 0), (4, 0, 4, 3), (4, 3, 0, 3), (0, 3, 0, 0)], resolution=0.001)
    cells = world.to_array()
    cells[:, 2003:2104] = 1
    world = Map.from_array(cells, resolution=0.001)
    at = np.arange(1.825, 2.3, 0.05)  # the middles of the cells
    away = np.minimum(np.abs(at - 2.003), np.abs(at - 2.104))
    seen, density = scan([0.0], [0.0]), []
    for x in at:
        _, out = weigh(world, [(x, 1.525, 0.0)], seen, mixture(), resolution=0.05)
        density.append(math.exp(out[0]))
    found = STD * np.sqrt(-2.0 * np.log((np.array(density) - 0.5 / 20.0) / (0.5 * norm.pdf(0.0, scale=STD))))
    np.testing.assert_allclose(found, away, atol=0.01)
