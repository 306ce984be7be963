"""Poses in the plane, as rows (x [m], y [m], heading [rad]): for components and for the engine."""

from __future__ import annotations

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.core.arguments import is_numeric, numbers
from amorsim.core.error_text import in_words
from amorsim.core.parameters import ParameterError, parameter
from amorsim.kernels.kinematics import poses as kernels

__all__ = ["Mount", "compose", "exponential", "logarithm", "relative", "wrap_angle"]

_FLOAT = np.dtype(np.float64)


@attrs.frozen(kw_only=True)
class Mount:
    """The mount of a device on its robot: a pose in the robot's base frame (x ahead, y to the left)."""

    x: float = parameter(0.0, unit="m", frame="body", help="ahead of the robot's base point")
    y: float = parameter(0.0, unit="m", frame="body", help="to the left of the robot's base point")
    heading: float = parameter(0.0, unit="rad", help="where it looks, anticlockwise from straight ahead")


def _fit(poses: object, others: object, columns: int) -> bool:
    """Whether these are arrays of numbers `(N, 3)` and `(N, columns)`; checks no more, since each step calls it."""
    if not (isinstance(poses, np.ndarray) and isinstance(others, np.ndarray)):
        return False
    if not (poses.dtype is _FLOAT and others.dtype is _FLOAT):
        return False
    return poses.ndim == 2 and poses.shape[1] == 3 and others.shape == (poses.shape[0], columns)


def compose(poses: Array, displacements: Array) -> Array:
    """Poses `(N, 3)` after displacements `(N, 3)`, each given in its pose's frame; headings in [-pi, pi]."""
    if not _fit(poses, displacements, 3):
        poses = numbers(poses, "poses", ("N", 3))
        displacements = numbers(displacements, "displacements", (len(poses), 3))
    out = np.empty((len(poses), 3))
    kernels.compose(np.ascontiguousarray(poses), np.ascontiguousarray(displacements), out)
    return out


def exponential(twists: Array, fraction: Array) -> Array:
    """Displacements `(N, 3)` in closed form by a fraction `(N, 1)` of constant twists `(N, 3)`.

    A twist is the motion (forward [m], left [m], turn [rad]) over the whole step in the body's frame; the path
    is an arc of a circle.
    """
    if not _fit(twists, fraction, 1):
        twists = numbers(twists, "twists", ("N", 3))
        fraction = numbers(fraction, "fraction", (len(twists), 1))
    out = np.empty((len(twists), 3))
    kernels.exponential(np.ascontiguousarray(twists), np.ascontiguousarray(fraction), out)
    return out


def logarithm(displacements: Array) -> Array:
    """The constant twists `(N, 3)` that make the displacements `(N, 3)` in one step: `exponential` undone."""
    if not _fit(displacements, displacements, 3):
        displacements = numbers(displacements, "displacements", ("N", 3))
    out = np.empty((len(displacements), 3))
    kernels.logarithm(np.ascontiguousarray(displacements), out)
    return out


def relative(poses: Array, others: Array) -> Array:
    """The displacements `(N, 3)` that lead from `poses` to `others`, in each pose's own frame: `compose` undone."""
    if not _fit(poses, others, 3):
        poses = numbers(poses, "poses", ("N", 3))
        others = numbers(others, "others", (len(poses), 3))
    out = np.empty((len(poses), 3))
    kernels.relative(np.ascontiguousarray(poses), np.ascontiguousarray(others), out)
    return out


def wrap_angle(angles: Array) -> Array:
    """The same directions in [-pi, pi]; angles already there keep their bits."""
    if not is_numeric(angles):
        raise ParameterError("angles", f"expected numbers [rad], got {in_words(angles)}")
    given = np.asarray(angles, dtype=np.float64)
    flat = given.ravel()
    out = np.empty_like(flat)
    kernels.wrap_all(flat, out)
    return out.reshape(given.shape)
