"""Gaussian beliefs of poses: the root of a covariance, and draws."""

from __future__ import annotations

import math

import numpy as np

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel

__all__ = ["draw_around", "root"]


@kernel
def root(covariance: Array, out: Array) -> None:
    """The lower triangle L with ``L L' = covariance`` (n, n), by Cholesky; a column of zeros without variance."""
    size = covariance.shape[0]
    for j in range(size):
        for i in range(size):
            out[i, j] = 0.0
    for j in range(size):
        rest = covariance[j, j]
        for k in range(j):
            rest -= out[j, k] * out[j, k]
        # What rounding leaves of a variance that the columns before explain.
        if not rest > 1e-14 * covariance[j, j]:
            continue
        out[j, j] = math.sqrt(rest)
        for i in range(j + 1, size):
            rest = covariance[i, j]
            for k in range(j):
                rest -= out[i, k] * out[j, k]
            out[i, j] = rest / out[j, j]


@kernel
def draw_around(means: Array, covariances: Array, normals: Array, out: Array) -> None:
    """Turn standard normal draws `(N, 3)` into draws about means `(N, 3)` with covariances `(N, 3, 3)`."""
    lower = np.empty((3, 3))
    for i in range(means.shape[0]):
        root(covariances[i], lower)
        for j in range(3):
            value = means[i, j]
            for k in range(j + 1):
                value += lower[j, k] * normals[i, k]
            out[i, j] = value
