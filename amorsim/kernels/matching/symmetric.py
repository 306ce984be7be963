"""Symmetric 3 x 3 matrices of one row: eigenvalues, and steps without what nothing determines."""

from __future__ import annotations

import math

from amorsim.array_types import Array
from amorsim.kernels.compile import part

__all__ = ["UNDETERMINED", "directions", "eigen", "invert", "solve"]


UNDETERMINED = 1e-8
"""Eigenvalues below this part of the largest tell nothing."""
_FAR = 1e100  # its square is no number any more
_SWEEPS = 12  # Jacobi's method is quadratic; five are enough for 3 x 3


@part
def eigen(matrix: Array, values: Array, vectors: Array) -> None:
    """Eigenvalues (3,), the least first, and eigenvectors in the columns of `vectors` (3, 3); `matrix` is used up.

    Jacobi's method: each rotation makes one pair of numbers off the diagonal 0.
    """
    for i in range(3):
        for j in range(3):
            vectors[i, j] = 1.0 if i == j else 0.0
    for _ in range(_SWEEPS):
        if matrix[0, 1] == 0.0 and matrix[0, 2] == 0.0 and matrix[1, 2] == 0.0:
            break
        for p in range(2):
            for q in range(p + 1, 3):
                off = matrix[p, q]
                if off == 0.0:
                    continue
                theta = (matrix[q, q] - matrix[p, p]) / (2.0 * off)
                far = abs(theta)
                t = 1.0 / (far + math.sqrt(far * far + 1.0)) if far < _FAR else 0.5 / far
                if theta < 0.0:
                    t = -t
                c = 1.0 / math.sqrt(t * t + 1.0)
                s = t * c
                for k in range(3):
                    a = matrix[k, p]
                    b = matrix[k, q]
                    matrix[k, p] = c * a - s * b
                    matrix[k, q] = s * a + c * b
                for k in range(3):
                    a = matrix[p, k]
                    b = matrix[q, k]
                    matrix[p, k] = c * a - s * b
                    matrix[q, k] = s * a + c * b
                matrix[p, q] = 0.0
                matrix[q, p] = 0.0
                for k in range(3):
                    a = vectors[k, p]
                    b = vectors[k, q]
                    vectors[k, p] = c * a - s * b
                    vectors[k, q] = s * a + c * b
    for i in range(3):
        values[i] = matrix[i, i]
    for i in range(2):
        for j in range(2 - i):
            if values[j] > values[j + 1]:
                a = values[j]
                values[j] = values[j + 1]
                values[j + 1] = a
                for k in range(3):
                    a = vectors[k, j]
                    vectors[k, j] = vectors[k, j + 1]
                    vectors[k, j + 1] = a


@part
def directions(information: Array, arm: float, scaled: Array, values: Array, vectors: Array) -> None:
    """Eigenvalues (3,) and eigenvectors of an information on a pose, in which turns count as lengths.

    A turn is as long as it moves a point at the distance `arm` [m]. `scaled` (3, 3) is room.
    """
    for i in range(3):
        for j in range(3):
            scaled[i, j] = information[i, j] / ((arm if i == 2 else 1.0) * (arm if j == 2 else 1.0))
    eigen(scaled, values, vectors)


@part
def solve(values: Array, vectors: Array, right: Array, least: float, out: Array) -> None:
    """The solution (3,) of a system by its matrix's eigenvalues; none along those below `least` of the largest."""
    for i in range(3):
        out[i] = 0.0
    for j in range(3):
        if values[j] > least * values[2] and values[j] > 0.0:
            along = (vectors[0, j] * right[0] + vectors[1, j] * right[1] + vectors[2, j] * right[2]) / values[j]
            for i in range(3):
                out[i] += vectors[i, j] * along


@part
def invert(matrix: Array, out: Array) -> bool:
    """The inverse (3, 3) of a positive matrix, by cofactors; False, and nothing written, if it is singular."""
    a = matrix[1, 1] * matrix[2, 2] - matrix[1, 2] * matrix[1, 2]
    b = matrix[0, 2] * matrix[1, 2] - matrix[0, 1] * matrix[2, 2]
    c = matrix[0, 1] * matrix[1, 2] - matrix[0, 2] * matrix[1, 1]
    determinant = matrix[0, 0] * a + matrix[0, 1] * b + matrix[0, 2] * c
    if not determinant > 0.0:
        return False
    out[0, 0] = a / determinant
    out[0, 1] = b / determinant
    out[0, 2] = c / determinant
    out[1, 1] = (matrix[0, 0] * matrix[2, 2] - matrix[0, 2] * matrix[0, 2]) / determinant
    out[1, 2] = (matrix[0, 1] * matrix[0, 2] - matrix[0, 0] * matrix[1, 2]) / determinant
    out[2, 2] = (matrix[0, 0] * matrix[1, 1] - matrix[0, 1] * matrix[0, 1]) / determinant
    out[1, 0] = out[0, 1]
    out[2, 0] = out[0, 2]
    out[2, 1] = out[1, 2]
    return True
