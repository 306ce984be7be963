"""A graph of poses: estimated poses, and measurements between pairs of them."""

from __future__ import annotations

from typing import Any, Self

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array, Ints
from amorsim.core.arguments import is_numeric
from amorsim.core.error_text import in_words
from amorsim.core.errors import GraphError

__all__ = ["PoseGraph"]


_SKEW = 1e-9  # of an information matrix, relative to its largest number


@attrs.frozen(kw_only=True, eq=False)
class PoseGraph:
    """Poses, and displacements measured between pairs of them, each with its information matrix.

    Make one with `of`, which checks the numbers. Poses are (x [m], y [m], heading [rad]) in the world; a measurement
    is the pose of the edge's second pose in the frame of its first.
    """

    poses: Array
    """(n, 3)"""
    edges: Ints
    """(m, 2) places of two poses in `poses`."""
    measurements: Array
    """(m, 3)"""
    information: Array
    """(m, 3, 3) inverse covariances of the measurements, in the frame of the measured pose."""
    ids: Ints
    """(n,) the poses' names in files."""

    @classmethod
    def of(
        cls,
        poses: npt.ArrayLike,
        edges: npt.ArrayLike,
        measurements: npt.ArrayLike,
        information: npt.ArrayLike,
        ids: npt.ArrayLike | None = None,
    ) -> Self:
        """A graph of these arrays; `ids` are 0, 1, ... if not given.

        Raises
        ------
        GraphError
            If shapes do not fit, a number is not finite, an edge leads nowhere or to its own pose, a matrix is not
            symmetric or has a negative eigenvalue, or two poses have one id.
        """
        places = _numbers(poses, "poses", (-1, 3))
        measured = _numbers(measurements, "measurements", (-1, 3))
        matrices = _numbers(information, "information", (len(measured), 3, 3))
        pairs = np.array(edges, dtype=np.int64).reshape(-1, 2)
        names = np.arange(len(places)) if ids is None else np.array(ids, dtype=np.int64).reshape(-1)
        if not len(places):
            raise GraphError("a pose graph needs at least one pose, got none")
        if len(pairs) != len(measured):
            raise GraphError(f"expected a measurement for each of {len(pairs)} edges, got {len(measured)}")
        if len(names) != len(places):
            raise GraphError(f"expected an id for each of {len(places)} poses, got {len(names)}")
        values, counts = np.unique(names, return_counts=True)
        if (counts > 1).any():
            raise GraphError(f"two poses have the id {values[counts > 1][0]}; give each its own")
        wrong = np.flatnonzero(((pairs < 0) | (pairs >= len(places))).any(axis=1) | (pairs[:, 0] == pairs[:, 1]))
        if len(wrong):
            i, j = pairs[wrong[0]].tolist()
            raise GraphError(f"edge {wrong[0]} leads from pose {i} to {j}; expected two of the {len(places)} poses")
        size = np.abs(matrices).max(axis=(1, 2), initial=0.0)
        skew = np.abs(matrices - matrices.swapaxes(1, 2)).max(axis=(1, 2), initial=0.0)
        least = np.linalg.eigvalsh(matrices)[:, 0] if len(matrices) else size
        wrong = np.flatnonzero((skew > _SKEW * size) | (least < -_SKEW * size))
        if len(wrong):
            raise GraphError(
                f"the information of edge {wrong[0]} is {matrices[wrong[0]].tolist()}; expected a symmetric matrix "
                "without negative eigenvalues"
            )
        return cls(poses=places, edges=pairs, measurements=measured, information=matrices, ids=names)


def _numbers(given: npt.ArrayLike, what: str, shape: tuple[int, ...]) -> Array:
    """Finite numbers of a shape, copied."""
    try:
        found: Any = np.array(given, dtype=np.float64).reshape(shape)
    except (TypeError, ValueError, OverflowError):
        got = np.shape(given) if is_numeric(given) else in_words(given)
        raise GraphError(f"{what}: expected numbers of shape {shape}, got {got}") from None
    if not np.isfinite(found).all():
        place = int(np.flatnonzero(~np.isfinite(found.reshape(len(found), -1)).all(axis=1))[0])
        raise GraphError(f"{what}: number {place} is {found[place].tolist()}; expected finite numbers")
    return np.asarray(found)
