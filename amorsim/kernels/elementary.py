"""Exponentials, logarithms, powers and angles of arrays, as the C library computes them.

NumPy computes them by other instructions where a processor has wider vectors (AVX-512), and their last bits are others
then: `numpy.exp` of 4 % of the numbers, `numpy.arctan2` of 8 %. A run must not depend on that. Sines, cosines and roots
are the same everywhere.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel

__all__ = ["arccos", "arctan2", "exp", "expm1", "log", "log1p", "power"]


def exp(x: ArrayLike) -> Array:
    """E to the power of each number."""
    return _each(_exp, x)


def expm1(x: ArrayLike) -> Array:
    """exp(x) - 1 of each number."""
    return _each(_expm1, x)


def log(x: ArrayLike) -> Array:
    """The natural logarithm of each number: -inf of 0, nan below."""
    return _each(_log, x)


def log1p(x: ArrayLike) -> Array:
    """log(1 + x) of each number."""
    return _each(_log1p, x)


def arccos(x: ArrayLike) -> Array:
    """The angle [rad] of each cosine; nan beyond 1."""
    return _each(_arccos, x)


def arctan2(y: ArrayLike, x: ArrayLike) -> Array:
    """The angle [rad] of each point (x, y), in [-pi, pi]."""
    return _each(_arctan2, y, x)


def power(x: ArrayLike, exponent: ArrayLike) -> Array:
    """Each number to its power."""
    return _each(_power, x, exponent)


def _each(run: Callable[..., Any], *arguments: ArrayLike) -> Array:
    """The result of a kernel for the arguments, broadcast to one shape."""
    arrays = [np.asarray(argument, dtype=np.float64, order="C") for argument in arguments]
    shape = arrays[0].shape
    if any(array.shape != shape for array in arrays):
        shape = np.broadcast_shapes(*(array.shape for array in arrays))
        arrays = [_filled(array, shape) for array in arrays]
    out = np.empty(shape)
    run(*(array.reshape(-1) for array in arrays), out.reshape(-1))
    return out


def _filled(array: Array, shape: tuple[int, ...]) -> Array:
    """A copy broadcast to a shape: what NumPy broadcasts without one cannot be written to, and warns kernels of it."""
    filled = np.empty(shape)
    filled[...] = array
    return filled


@kernel
def _exp(x: Array, out: Array) -> None:
    for i in range(len(out)):
        out[i] = math.exp(x[i])


@kernel
def _expm1(x: Array, out: Array) -> None:
    for i in range(len(out)):
        out[i] = math.expm1(x[i])


@kernel
def _log(x: Array, out: Array) -> None:
    for i in range(len(out)):
        out[i] = math.log(x[i])


@kernel
def _log1p(x: Array, out: Array) -> None:
    for i in range(len(out)):
        out[i] = math.log1p(x[i])


@kernel
def _arccos(x: Array, out: Array) -> None:
    for i in range(len(out)):
        out[i] = math.acos(x[i])


@kernel
def _arctan2(y: Array, x: Array, out: Array) -> None:
    for i in range(len(out)):
        out[i] = math.atan2(y[i], x[i])


@kernel
def _power(x: Array, exponent: Array, out: Array) -> None:
    for i in range(len(out)):
        out[i] = x[i] ** exponent[i]
