"""Fits of a few unknowns."""

from __future__ import annotations

import numpy as np
import pytest

from amorsim.algorithms.least_squares import gauss_newton, linear_fit

_X = np.linspace(0.0, 2.0, 21)


def test_a_curve_gives_back_its_parameters() -> None:
    wanted = 1.3 * np.exp(-0.7 * _X)

    def residuals(tried: np.ndarray) -> np.ndarray:
        return tried[:, :1] * np.exp(-tried[:, 1:] * _X) - wanted

    fit = gauss_newton(residuals, np.ones(2))
    assert fit.values == pytest.approx([1.3, 0.7], abs=1e-10)
    assert np.abs(fit.residuals).max() < 1e-10
    derivative = np.stack((np.exp(-0.7 * _X), -1.3 * _X * np.exp(-0.7 * _X)), axis=1)
    assert fit.jacobian == pytest.approx(derivative, abs=1e-8)


def test_with_noise_the_residuals_are_normal_to_the_derivatives() -> None:
    observed = 1.3 * np.exp(-0.7 * _X) + np.random.default_rng(2).normal(0.0, 0.1, size=_X.size)

    def residuals(tried: np.ndarray) -> np.ndarray:
        return tried[:, :1] * np.exp(-tried[:, 1:] * _X) - observed

    fit = gauss_newton(residuals, np.ones(2), tolerance=1e-10)
    assert fit.jacobian.T @ fit.residuals == pytest.approx([0.0, 0.0], abs=1e-7)


def test_what_does_not_settle_says_so() -> None:
    def residuals(tried: np.ndarray) -> np.ndarray:
        # Newton's step from x leads to -2 x: away, whatever the start.
        return np.cbrt(tried)

    with pytest.raises(ValueError, match="did not settle"):
        gauss_newton(residuals, np.ones(1))


def test_several_linear_fits_at_once_are_those_one_by_one() -> None:
    design = np.stack((np.ones(21), _X), axis=1)
    observed = np.random.default_rng(3).normal(size=(21, 4))
    together = linear_fit(design, observed)
    for i in range(4):
        assert together[:, i] == pytest.approx(np.polyfit(_X, observed[:, i], 1)[::-1], abs=1e-12)
