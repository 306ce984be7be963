"""Maps of a fixed size around the start, as estimators hold them and show them as beliefs."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import parameter
from amorsim.core.errors import ComponentError
from amorsim.kernels.mapping.occupancy import Evidence
from amorsim.kernels.mapping.scan_cells import Area

__all__ = ["MapArea", "area_of", "area_origins", "log_odds_evidence", "map_beliefs"]


_MOST_CELLS = 50_000_000


@attrs.frozen(kw_only=True, slots=False)  # two bases with slots cannot be joined
class MapArea:
    """The fields of an estimator that draws a map of a fixed size.

    Parameters
    ----------
    resolution
        Side of a cell [m].
    width, height
        Of the map [m].
    center_x, center_y
        The middle of the map in the world [m]; None: the start.
    """

    resolution: float = parameter(0.05, unit="m", gt=0, static=True, help="side of a cell of the map")
    width: float = parameter(40.0, unit="m", gt=0, static=True, help="of the map, along x")
    height: float = parameter(40.0, unit="m", gt=0, static=True, help="of the map, along y")
    center_x: float | None = parameter(None, unit="m", static=True, help="middle of the map; None: the start")
    center_y: float | None = parameter(None, unit="m", static=True, help="middle of the map; None: the start")


def area_of(who: str, estimator: MapArea) -> Area:
    """The area that an estimator maps.

    Raises
    ------
    ComponentError
        If it has too many cells.
    """
    side = estimator.resolution
    cols, rows = (max(1, math.ceil(length / side - 1e-9)) for length in (estimator.width, estimator.height))
    if rows * cols > _MOST_CELLS:
        raise ComponentError(
            f"{who}: a map of {estimator.width:g} x {estimator.height:g} m has {rows * cols:.3g} cells of {side:g} m; "
            f"expected {_MOST_CELLS:.0e} at most: make the map smaller, or its resolution coarser"
        )
    return Area(rows, cols, side)


def area_origins(estimator: MapArea, poses: Array, area: Area) -> Array:
    """Lower left corners `(N, 2)` [m] of the areas of robots that start at `poses` `(N, 3)`.

    They lie at whole multiples of a cell in the world. The middle is the start where `center_x` or `center_y` is None.
    """
    middle = poses[:, :2].copy()
    for axis, center in enumerate((estimator.center_x, estimator.center_y)):
        if center is not None:
            middle[:, axis] = center
    half = np.array([area.cols // 2, area.rows // 2])
    return np.asarray((np.floor(middle / area.resolution + 1e-9) - half) * area.resolution)


def log_odds_evidence(hit: float = 0.97, miss: float = 0.4, certainty: float = 0.9999) -> Evidence:
    """The log-odds that hits and misses add, from probabilities of cells."""
    bound = _log_odds(certainty)
    return Evidence(*(np.float32(value) for value in (_log_odds(hit), _log_odds(miss), -bound, bound)))


def _log_odds(probability: float) -> float:
    return math.log(probability / (1.0 - probability))


def map_beliefs(probability: Callable[[Array], None], origins: Array, area: Area) -> dict[str, Any]:
    """A map as `LazyBeliefs` take it.

    `probability` fills an array `(N, rows * cols)` with probabilities that cells are occupied, nan where nothing was
    seen; it is called when the map is looked up.
    """

    def occupancy() -> Array:
        found = np.empty((len(origins), area.rows * area.cols))
        probability(found)
        return found.reshape(-1, area.rows, area.cols)

    return {
        "occupancy": occupancy,
        "occupancy_origin": origins.copy(),
        "occupancy_resolution": np.full(len(origins), area.resolution),
    }
