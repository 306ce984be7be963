"""Which walls are boxes of occupied cells, against the cells themselves."""

from __future__ import annotations

import numpy as np

from amorsim.core.maps.map import Map
from amorsim.kernels.grid.segment_boxes import index_segments, no_segments
from tests.kernels.test_outlines import random_cells
from tests.kernels.test_scans import random_walls


def boxes_of(map_: Map) -> np.ndarray:
    """Grid lines (M, 4) of the walls that are said to be such boxes, the map's border not among them."""
    boxes = map_.segment_index.walls[6:].T
    rows, cols = map_.shape
    solid = (boxes[:, 0] < boxes[:, 2]) & (boxes[:, 1] < boxes[:, 3])
    inside = (boxes[:, :2] >= 0).all(axis=1) & (boxes[:, 2] <= cols) & (boxes[:, 3] <= rows)
    return boxes[solid & inside].astype(int)


def assert_full(map_: Map) -> int:
    cells = map_.to_array()
    boxes = boxes_of(map_)
    for col0, row0, col1, row1 in boxes:
        assert cells[row0:row1, col0:col1].all()
    return len(boxes)


def test_a_box_has_no_free_cell() -> None:
    rng = np.random.default_rng(6)
    found = 0
    for _ in range(60):
        cells = random_cells(rng)
        found += assert_full(Map.from_array(cells, resolution=0.05))
        walls = random_walls(rng, 60, 5.0, 0.01)
        found += assert_full(Map.from_segments(walls, resolution=0.01))
    assert found > 3000


def test_walls_along_the_axes_are_boxes_of_just_their_cells() -> None:
    room = Map.from_segments(
        [[0.5, 0.015, 2.505, 0.015], [1.0, 1.005, 1.0, 1.505], [2.0, 1.0, 2.5, 2.0]],
        resolution=0.01,
        extent=(0.0, 0.0, 3.0, 3.0),
    )
    # Who ends at a grid line touches the cells on both its sides.
    assert sorted(boxes_of(room).tolist()) == [[49, 1, 251, 2], [99, 100, 101, 151]]
    cells = np.zeros((40, 40), dtype=np.uint8)
    cells[20, 5:35] = 1
    cells[30:36, 10:14] = 1
    bitmap = Map.from_array(cells, resolution=0.05)
    # A thin wall is one; each side of what is thick is one cell deep.
    assert sorted(boxes_of(bitmap).tolist()) == [
        [5, 20, 35, 21],
        [10, 30, 11, 36],
        [10, 30, 14, 31],
        [10, 35, 14, 36],
        [13, 30, 14, 36],
    ]


def test_a_wall_with_a_gap_is_no_box() -> None:
    cells = np.zeros((40, 40), dtype=np.uint8)
    cells[20, 5:35] = 1
    whole = Map.from_array(cells, resolution=0.05)
    cells[20, 17] = 0
    gap = Map.from_array(cells, resolution=0.05)
    walls = np.array([[0.275, 1.025, 1.725, 1.025]])
    margins = np.array([0.025 + 1e-8])
    for map_, solid in ((whole, 1), (gap, 0)):
        lines = index_segments(walls, 40, 40, 0.05, margins, map_.grid)
        assert (lines.walls[6] < lines.walls[8]).sum() == 4 + solid
    # Nothing is known without the cells.
    assert (index_segments(walls, 40, 40, 0.05, margins).walls[6] > 0).all()
    assert no_segments().walls.shape == lines.walls[:, :0].shape
