"""NEES, NIS and their verdict."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import chi2

from amorsim.algorithms.consistency import chi_squared_band, nees, nis, verdict


def filters(count, runs, scale=1.0, size=3, seed=0):
    """Errors and covariances of filters, each of `runs` runs, whose errors are `scale` times as large as they say."""
    random = np.random.default_rng(seed)
    roots = random.normal(size=(count, size, size)) + 2.0 * np.eye(size)
    covariances = roots @ np.swapaxes(roots, 1, 2)
    errors = scale * np.einsum("nij,nrj->nri", np.linalg.cholesky(covariances), random.normal(size=(count, runs, size)))
    return errors, np.repeat(covariances[:, None], runs, axis=1)


def test_nees_is_the_distance_of_mahalanobis() -> None:
    errors, covariances = filters(20, 5)
    wanted = np.einsum("nri,nrij,nrj->nr", errors, np.linalg.inv(covariances), errors)
    assert nees(errors, covariances) == pytest.approx(wanted, rel=1e-9)
    assert nis(errors[0, 0], covariances[0, 0]) == pytest.approx(wanted[0, 0], rel=1e-9)


def test_nees_of_a_row_does_not_depend_on_the_others() -> None:
    errors, covariances = filters(7, 3)
    whole = nees(errors, covariances)
    for i in range(7):
        assert nees(errors[i : i + 1], covariances[i : i + 1]).tobytes() == whole[i : i + 1].tobytes()


def test_nees_without_a_covariance_is_nan() -> None:
    assert math.isnan(nees(np.ones(3), np.zeros((3, 3))))
    assert math.isnan(nees(np.ones(2), np.array([[1.0, 2.0], [2.0, 1.0]])))


def test_bands_are_those_of_chi_squared() -> None:
    for degrees, count in ((3, 1), (3, 50), (2, 1000)):
        wanted = chi2.ppf([0.025, 0.975], degrees * count) / count
        assert chi_squared_band(degrees, count) == pytest.approx(tuple(wanted), rel=1e-12)


def test_the_verdict_is_right_in_95_of_100_synthetic_filters() -> None:
    errors, covariances = filters(1000, 50)
    verdicts = [verdict(values, 3).verdict for values in nees(errors, covariances)]
    # Two standard deviations of a binomial number of 1,000 tries, in percent.
    assert abs(verdicts.count("consistent") / 10.0 - 95.0) <= 1.4


@pytest.mark.parametrize(("scale", "word"), [(2.0, "overconfident"), (0.5, "underconfident")])
def test_a_wrong_covariance_is_reported(scale: float, word: str) -> None:
    errors, covariances = filters(50, 50, scale)
    found = [verdict(values, 3) for values in nees(errors, covariances)]
    assert all(each.verdict == word for each in found)
    assert str(found[0]).startswith(f"{word}: the mean of 50 values is")
    assert "times as large as the covariance says" in str(found[0])


def test_values_that_are_not_there_are_left_out() -> None:
    found = verdict(np.array([math.nan, 3.0, 3.0, math.nan]), 3)
    assert (found.count, found.mean, found.verdict) == (2, 3.0, "consistent")
    assert verdict(np.array([math.nan]), 3).verdict == "unknown"
    assert "no values" in str(verdict(np.array([]), 3))


@pytest.mark.parametrize(("degrees", "confidence"), [(0, 0.95), (3, 0.0), (3, 1.0)])
def test_what_has_no_verdict_is_refused(degrees: int, confidence: float) -> None:
    with pytest.raises(ValueError, match="expected degrees >= 1"):
        verdict(np.ones(3), degrees, confidence=confidence)
