"""Scores of estimated maps."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from amorsim.algorithms.map_scores import area_under_curve, distances_to_walls, map_scores


def truth() -> np.ndarray:
    cells = np.zeros((20, 30), np.int64)
    cells[:, 10] = 1
    return cells


def test_the_true_map_is_perfect() -> None:
    found = map_scores(truth().astype(float), truth(), 0.1)
    assert (found.iou, found.f1, found.mcc, found.auc) == (1.0, 1.0, 1.0, 1.0)
    assert (found.accuracy, found.completeness, found.unknown) == (0.0, 0.0, 0)


def test_a_wall_in_the_wrong_place_is_as_far_off_as_it_is() -> None:
    found = map_scores(np.roll(truth(), 3, axis=1).astype(float), truth(), 0.1)
    assert found.iou == 0.0
    assert found.accuracy == pytest.approx(0.3)
    assert found.completeness_95 == pytest.approx(0.3)
    assert (found.hits, found.misses, found.false_alarms, found.correct_free) == (0, 20, 20, 560)


def test_what_is_unknown_is_no_error() -> None:
    probability = truth().astype(float)
    probability[:10] = 0.5
    probability[0] = np.nan
    found = map_scores(probability, truth(), 0.1)
    assert found.unknown == 300
    assert (found.f1, found.mcc) == (1.0, 1.0)
    assert found.iou == 0.5
    half = truth()
    half[:10] = -1
    assert map_scores(truth().astype(float), half, 0.1).occupied == 10


def test_an_empty_map_has_no_accuracy() -> None:
    found = map_scores(np.zeros((20, 30)), truth(), 0.1)
    assert math.isnan(found.accuracy)
    assert found.completeness == math.inf
    assert found.iou == 0.0


@given(st.lists(st.tuples(st.integers(0, 5), st.booleans()), min_size=1, max_size=30))
def test_auc_is_the_share_of_pairs_in_order(cells: list[tuple[int, bool]]) -> None:
    scores = np.array([score for score, _ in cells], float)
    positive = np.array([is_positive for _, is_positive in cells])
    pairs = [(a > b) + 0.5 * (a == b) for a in scores[positive] for b in scores[~positive]]
    found = area_under_curve(scores, positive)
    assert math.isnan(found) if not pairs else found == pytest.approx(np.mean(pairs))


def test_what_cannot_be_compared_is_refused() -> None:
    with pytest.raises(ValueError, match="truth: expected numbers of the shape"):
        map_scores(np.zeros((2, 2)), np.zeros((2, 3), np.int64), 0.1)
    with pytest.raises(ValueError, match="between 0 and 1"):
        map_scores(np.full((2, 2), 1.5), np.zeros((2, 2), np.int64), 0.1)


@pytest.mark.parametrize("margin", [-0.1, 0.5, "0.1", None])
def test_a_margin_is_less_than_a_half(margin: Any) -> None:
    with pytest.raises(ValueError, match=r"margin: expected a number >= 0 and < 0\.5, got"):
        map_scores(np.zeros((2, 2)), np.zeros((2, 2), np.int64), 0.1, margin=margin)


@pytest.mark.parametrize("resolution", [0.0, -0.1, "0.1", None, math.inf])
def test_a_cell_has_a_side(resolution: Any) -> None:
    with pytest.raises(ValueError, match=r"resolution: expected the side of a cell, a number > 0 \[m\], got"):
        map_scores(np.zeros((2, 2)), np.zeros((2, 2), np.int64), resolution)


@pytest.mark.parametrize("walls", [None, 3, [[1, 2], [3]], np.zeros((2, 3))])
def test_what_are_no_walls_is_refused(walls: Any) -> None:
    with pytest.raises(ValueError, match=r"walls: expected numbers of the shape \(M, 4\)"):
        distances_to_walls(np.zeros((1, 2)), walls)
    assert distances_to_walls(np.zeros((1, 2)), []).tolist() == [math.inf]  # type: ignore[arg-type]


def test_distances_to_walls_are_those_of_shapely() -> None:
    import shapely

    random = np.random.default_rng(2)
    points, walls = random.uniform(-3.0, 3.0, (50, 2)), random.uniform(-3.0, 3.0, (7, 4))
    walls[3, 2:] = walls[3, :2]  # a wall of one point
    lines = shapely.multilinestrings([shapely.linestrings(wall.reshape(2, 2)) for wall in np.delete(walls, 3, axis=0)])
    whole = shapely.union(lines, shapely.points(walls[3, :2]))
    assert distances_to_walls(points, walls) == pytest.approx(shapely.distance(shapely.points(points), whole))
    assert np.isinf(distances_to_walls(points, np.empty((0, 4)))).all()
