"""How well an estimated map fits the true one: cells, intersection over union, AUC, and distances between them."""

from __future__ import annotations

import math
from collections.abc import Sized

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array, Bools
from amorsim.core.arguments import numbers, real
from amorsim.core.parameters import ParameterError

__all__ = ["MapScores", "area_under_curve", "distances_to_walls", "map_scores"]


@attrs.frozen(kw_only=True)
class MapScores:
    """Scores of an estimated map, over the cells whose truth is known.

    A cell of the estimate is occupied above 0.5 + margin, free below 0.5 - margin, unknown between them.

    Attributes
    ----------
    occupied, free, unknown
        How many cells the estimate calls so.
    hits, misses, false_alarms, correct_free
        Truly occupied cells called occupied, or free; truly free ones called occupied, or free.
    iou
        Hits over all cells that are occupied in either, unknown ones included; 1 for a perfect map.
    f1, mcc
        F1 of occupied cells, and Matthews' correlation, over the cells that are called one or the other.
    auc
        Probability that an occupied cell has a higher value than a free one: needs no threshold.
    accuracy, accuracy_95
        Mean, and 95 % quantile, of the distance [m] of cells called occupied to the nearest truly occupied one.
    completeness, completeness_95
        The same the other way round: of truly occupied cells to the nearest that is called so.
    """

    occupied: int
    free: int
    unknown: int
    hits: int
    misses: int
    false_alarms: int
    correct_free: int
    iou: float
    f1: float
    mcc: float
    auc: float
    accuracy: float
    accuracy_95: float
    completeness: float
    completeness_95: float


def map_scores(
    probability: Array, truth: npt.NDArray[np.integer], resolution: float, *, margin: float = 0.1
) -> MapScores:
    """Compare an estimated map with the truth, cell by cell; both are to lie in the same frame.

    Parameters
    ----------
    probability
        Of each cell to be occupied, `(rows, columns)`; nan is unknown.
    truth
        As `probability`: 1 where a cell is truly occupied, 0 where it is free, anything else where that is not known.
    resolution
        Side of a cell [m].
    margin
        How far from 0.5 a probability must be to count.

    Raises
    ------
    ValueError
        If the shapes differ, a probability is not between 0 and 1, the resolution is not above 0, or the margin is not
        below 0.5.
    """
    probability = numbers(probability, "probability", ("rows", "columns"))
    true = numbers(truth, "truth", probability.shape)
    side = "the side of a cell, a number > 0 [m]"
    resolution = real(resolution, "resolution", side)
    if resolution <= 0.0:
        raise ParameterError("resolution", f"expected {side}, got {resolution:g}")
    between = "a number >= 0 and < 0.5"
    margin = real(margin, "margin", between)
    if not 0.0 <= margin < 0.5:
        raise ParameterError("margin", f"expected {between}, got {margin:g}")
    values = probability[~np.isnan(probability)]
    if ((values < 0.0) | (values > 1.0)).any():
        raise ParameterError("probability", "expected numbers between 0 and 1")
    known = (true == 0) | (true == 1)
    is_wall = true == 1
    with np.errstate(invalid="ignore"):
        says_wall, says_free = (probability > 0.5 + margin) & known, (probability < 0.5 - margin) & known
    hits = int(np.count_nonzero(says_wall & is_wall))
    misses = int(np.count_nonzero(says_free & is_wall))
    alarms = int(np.count_nonzero(says_wall & ~is_wall))
    right = int(np.count_nonzero(says_free & ~is_wall & known))
    either = int(np.count_nonzero(says_wall | (is_wall & known)))
    unknown = int(np.count_nonzero(known)) - hits - misses - alarms - right
    judged = ~np.isnan(probability) & known
    to_truth = _distances(says_wall, is_wall & known, resolution)
    to_estimate = _distances(is_wall & known, says_wall, resolution)
    return MapScores(
        occupied=hits + alarms,
        free=misses + right,
        unknown=unknown,
        hits=hits,
        misses=misses,
        false_alarms=alarms,
        correct_free=right,
        iou=_ratio(hits, either),
        f1=_ratio(2 * hits, 2 * hits + misses + alarms),
        mcc=_matthews(hits, misses, alarms, right),
        auc=area_under_curve(probability[judged], is_wall[judged]),
        accuracy=_mean(to_truth),
        accuracy_95=_quantile(to_truth),
        completeness=_mean(to_estimate),
        completeness_95=_quantile(to_estimate),
    )


def area_under_curve(scores: Array, positive: Bools) -> float:
    """The area under the receiver's curve (AUC): equal scores count half; nan if all cells are of one kind."""
    positives = int(np.count_nonzero(positive))
    negatives = len(scores) - positives
    if not positives or not negatives:
        return math.nan
    _, place, counts = np.unique(scores, return_inverse=True, return_counts=True)
    last = np.cumsum(counts)
    ranks = (last - 0.5 * (counts - 1))[place]
    return float((ranks[positive].sum() - 0.5 * positives * (positives + 1)) / (positives * negatives))


def distances_to_walls(points: Array, walls: Array) -> Array:
    """Distance [m] of each point `(N, 2)` to the nearest wall `(M, 4)`, x0, y0, x1, y1 [m]; inf without walls.

    For points of an estimated map, such as the middles of cells that it calls occupied, and `Map.segments`.
    """
    points = numbers(points, "points", ("N", 2))
    has_none = isinstance(walls, Sized) and not len(walls)
    walls = np.empty((0, 4)) if has_none else numbers(walls, "walls", ("M", 4))
    nearest = np.full(len(points), np.inf)
    for x0, y0, x1, y1 in walls.tolist():  # one after another: all at once would take much memory
        dx, dy = x1 - x0, y1 - y0
        square = dx * dx + dy * dy
        along = ((points[:, 0] - x0) * dx + (points[:, 1] - y0) * dy) / square if square else np.zeros(len(points))
        along = np.clip(along, 0.0, 1.0)
        apart = (points[:, 0] - x0 - along * dx) ** 2 + (points[:, 1] - y0 - along * dy) ** 2
        nearest = np.minimum(nearest, np.sqrt(apart))
    return nearest


def _distances(cells: Bools, to: Bools, resolution: float) -> Array:
    """From the middle of each of some cells to the nearest middle of others [m]; inf if there are none."""
    if not to.any():
        return np.full(int(np.count_nonzero(cells)), np.inf)
    from scipy.ndimage import distance_transform_edt

    found: Array = resolution * distance_transform_edt(~to)[cells]
    return found


def _ratio(part: int, whole: int) -> float:
    return part / whole if whole else math.nan


def _matthews(hits: int, misses: int, alarms: int, right: int) -> float:
    square = float(hits + alarms) * (hits + misses) * (right + alarms) * (right + misses)
    return (hits * right - alarms * misses) / math.sqrt(square) if square else math.nan


def _mean(values: Array) -> float:
    return float(values.mean()) if len(values) else math.nan


def _quantile(values: Array) -> float:
    return float(np.quantile(values, 0.95, method="inverted_cdf")) if len(values) else math.nan
