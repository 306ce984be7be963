"""The figures of UMBmark, against the numbers that were verified elsewhere and against exact squares."""

from __future__ import annotations

import math

import numpy as np
import pytest

from amorsim.algorithms.umbmark import WheelGeometry, exact_fit, published_figures, systematic_error
from tests.algorithms.squares import end_point, ends


def _predict(tried: np.ndarray, runs: int) -> np.ndarray:
    """End points `(c, 2 * runs, 2)`: clockwise runs first."""
    return np.array([np.repeat(np.concatenate(ends(ed, eb)), runs, axis=0) for ed, eb in tried.tolist()])


def test_a_perfect_robot_has_perfect_figures() -> None:
    clockwise, anticlockwise = ends(1.0, 1.0)
    assert systematic_error(clockwise, anticlockwise) < 1e-12
    figures = published_figures(clockwise, anticlockwise, 4.0, 0.32)
    for found in (figures.x, figures.y, figures.mean):
        assert found == pytest.approx((0.0, 0.0, 1.0, 1.0), abs=1e-12)


@pytest.mark.parametrize(
    ("ed", "eb", "ed_x", "ed_y", "eb_x", "eb_y"),
    [
        # With a track of 0.32 m: figures that were computed for the project beforehand, of five decimals.
        (1.001, 1.0, 1.00100, 1.00100, None, None),
        (1.0, 1.01, None, None, 1.00984, 1.01031),
        (0.998, 1.015, 0.99816, 0.99783, 1.01395, 1.01667),
    ],
)
def test_the_published_figures_are_the_verified_ones(
    ed: float, eb: float, ed_x: float | None, ed_y: float | None, eb_x: float | None, eb_y: float | None
) -> None:
    figures = published_figures(*ends(ed, eb), 4.0, 0.32)
    found = (figures.x.ed, figures.y.ed, figures.x.eb, figures.y.eb)
    for value, wanted in zip(found, (ed_x, ed_y, eb_x, eb_y), strict=True):
        if wanted is not None:
            assert value == pytest.approx(wanted, abs=6e-6)


def test_the_x_form_is_off_by_as_much_as_is_known() -> None:
    figures = published_figures(*ends(1.005, 1.02), 4.0, 0.32)
    assert (1.005 - figures.x.ed) / 0.005 == pytest.approx(0.11, abs=0.01)
    assert (1.02 - figures.x.eb) / 0.02 == pytest.approx(0.25, abs=0.015)
    assert abs(figures.mean.ed - 1.005) < 0.05 * 0.005
    assert abs(figures.mean.eb - 1.02) < 0.06 * 0.02


def test_mirrored_robots_have_mirrored_figures() -> None:
    """Exchanging the wheels exchanges the directions, and makes Ed its inverse."""
    clockwise, anticlockwise = ends(1.004, 1.01)
    mirror = np.array([1.0, -1.0])
    figures = published_figures(clockwise, anticlockwise, 4.0, 0.32)
    mirrored = published_figures(anticlockwise * mirror, clockwise * mirror, 4.0, 0.32)
    assert mirrored.mean.beta == pytest.approx(-figures.mean.beta)
    assert mirrored.mean.ed == pytest.approx(1.0 / figures.mean.ed)
    assert mirrored.mean.eb == pytest.approx(figures.mean.eb)


@pytest.mark.parametrize(("ed", "eb"), [(0.995, 0.98), (1.005, 1.02), (0.998, 1.015), (1.0, 1.0)])
def test_the_exact_fit_finds_what_was_put_in(ed: float, eb: float) -> None:
    clockwise, anticlockwise = (np.repeat(points, 5, axis=0) for points in ends(ed, eb))
    fit = exact_fit(lambda tried: _predict(tried, 5), clockwise, anticlockwise)
    assert fit.ed.value == pytest.approx(ed, abs=1e-10)
    assert fit.eb.value == pytest.approx(eb, abs=1e-10)
    assert fit.ed.half_width < 1e-12
    assert fit.scatter == pytest.approx(0.0, abs=1e-12)


def _at_least(probability: float, trials: int, risk: float) -> int:
    """The most successes k such that fewer than k come with a probability below `risk`."""
    below, k = 0.0, 0
    while below + (term := math.comb(trials, k) * probability**k * (1 - probability) ** (trials - k)) < risk:
        below += term
        k += 1
    return k


def test_the_intervals_cover_as_often_as_they_say_where_directions_and_coordinates_differ() -> None:
    """Noise of another size each way round, and correlated in x and y: what Welch's degrees of freedom are for."""
    draws = np.random.default_rng(5)
    trials, hits_ed, hits_eb = 300, 0, 0
    mix = np.array([[0.03, 0.01], [-0.02, 0.015]])
    for _ in range(trials):
        clockwise, anticlockwise = (np.repeat(points, 5, axis=0) for points in ends(1.003, 1.012))
        clockwise = clockwise + draws.normal(size=(5, 2)) @ mix
        anticlockwise = anticlockwise + 3.0 * draws.normal(size=(5, 2)) @ mix.T
        fit = exact_fit(lambda tried: _predict(tried, 5), clockwise, anticlockwise)
        hits_ed += fit.ed.covers(1.003)
        hits_eb += fit.eb.covers(1.012)
    for hits in (hits_ed, hits_eb):
        assert _at_least(0.95, trials, 1e-3) <= hits
        # Nor are they much too wide: at the other end of the same distribution.
        assert trials - hits >= _at_least(0.05, trials, 1e-3)


def test_the_scatter_is_that_of_single_runs() -> None:
    draws = np.random.default_rng(6)
    clockwise, anticlockwise = (
        np.repeat(points, 400, axis=0) + draws.normal(0.0, 0.02, size=(400, 2)) for points in ends(1.0, 1.0)
    )
    fit = exact_fit(lambda tried: _predict(tried, 400), clockwise, anticlockwise)
    # The length of a plane normal error of 0.02 m in each coordinate; its square is chi-square of 1596 degrees.
    assert fit.scatter**2 == pytest.approx(2 * 0.02**2, rel=4 * math.sqrt(2 / 1596))


def test_single_runs_are_too_few() -> None:
    with pytest.raises(ValueError, match="two runs each way at least, got 1 and 1"):
        exact_fit(lambda tried: _predict(tried, 1), *ends(1.0, 1.0))


def test_a_corrected_geometry_keeps_its_mean_and_takes_the_ratios() -> None:
    nominal_geometry = WheelGeometry(0.08, 0.084, 0.33)
    found = nominal_geometry.corrected(1.01, 0.98)
    assert found.radius_left + found.radius_right == pytest.approx(0.164, abs=1e-15)
    assert found.radius_right / found.radius_left == pytest.approx(1.01 * 0.084 / 0.08)
    assert found.track == pytest.approx(0.33 * 0.98)
    assert nominal_geometry.corrected(1.0, 1.0) == pytest.approx(nominal_geometry, abs=1e-16)


def test_the_systematic_error_is_the_farther_centre() -> None:
    clockwise = np.array([[0.3, 0.0], [0.3, 0.2]])
    anticlockwise = np.array([[-0.6, -0.8], [-0.6, -0.8]])
    assert systematic_error(clockwise, anticlockwise) == pytest.approx(1.0)
    assert end_point(1.0, 1.0, side=4.0, track=0.32, turns=1) == pytest.approx((0.0, 0.0), abs=1e-12)
