"""Least squares for a few unknowns, with derivatives taken numerically."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from amorsim.array_types import Array

__all__ = ["Fit", "gauss_newton", "linear_fit"]


_STEP = 1e-5  # of the central differences, for unknowns of about 1: their error is of its square
_MOST_STEPS = 50


class Fit(NamedTuple):
    """The unknowns `(p,)` that make the squares least, the residuals left `(m,)`, and their derivatives `(m, p)`."""

    values: Array
    residuals: Array
    jacobian: Array


def gauss_newton(residuals: Callable[[Array], Array], start: Array, tolerance: float = 1e-12) -> Fit:
    """The least-squares fit of unknowns that are of about 1.

    Parameters
    ----------
    residuals
        Residuals `(c, m)` for c candidates `(c, p)`, all in one call.
    start
        Where to begin, `(p,)`.
    tolerance
        It ends when no unknown changes by more.

    Raises
    ------
    ValueError
        If it does not come to an end, or an unknown changes nothing.
    """
    values = np.array(start, dtype=np.float64)
    count = len(values)
    offsets = np.concatenate((np.zeros((1, count)), _STEP * np.eye(count), -_STEP * np.eye(count)))
    for _ in range(_MOST_STEPS):
        found = residuals(values + offsets)
        jacobian = ((found[1 : count + 1] - found[count + 1 :]) / (2.0 * _STEP)).T
        if not np.isfinite(jacobian).all():
            break
        change, _, rank, _ = np.linalg.lstsq(jacobian, -found[0], rcond=None)
        if rank < count:  # what changes nothing cannot be found
            break
        values = values + change
        if np.abs(change).max() <= tolerance:
            return Fit(values, residuals(values[None])[0], jacobian)
    raise ValueError(f"the fit did not settle; it was at {values.tolist()}")


def linear_fit(design: Array, observed: Array) -> Array:
    """The coefficients `(p,)` or `(p, n)` for which `design` `(m, p)` times them comes nearest to `observed`.

    `observed` is `(m,)`, or `(m, n)` for n fits at once.
    """
    return np.asarray(np.linalg.lstsq(design, observed, rcond=None)[0])
