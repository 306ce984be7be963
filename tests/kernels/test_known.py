"""Arrays that a kernel finds by a table of where they lie."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import amorsim as am
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.known import Known, known_at, lay_out


@part
def _sum_up(told: Any, array: Any) -> None:
    for i in range(array.shape[0]):
        told[0] += (i + 1) * float(array[i])
    told[1] = array.shape[0]


@part
def _sum_up_rows(told: Any, array: Any) -> None:
    for i in range(array.shape[0]):
        for j in range(array.shape[1]):
            told[0] += (i * array.shape[1] + j + 1) * float(array[i, j])
    told[1] = array.shape[0]
    told[2] = array.shape[1]


@kernel
def _tell(table: Any, numbers: Any, sums: Any) -> None:
    """What is found by a table: numbers as they are, and of each array its shape and a sum that its order decides."""
    known = known_at(table)
    grid = known.grid
    numbers[0] = grid.resolution
    numbers[1] = grid.rows
    numbers[2] = grid.cols
    numbers[3] = grid.super_cols
    numbers[4] = known.origin_x
    numbers[5] = known.origin_y
    numbers[6] = known.yaw
    numbers[7] = known.dt
    numbers[8] = known.encoder
    _sum_up(sums[0], grid.supers)
    _sum_up(sums[1], known.lines.first)
    _sum_up(sums[2], known.ints)
    _sum_up(sums[3], known.floats)
    _sum_up_rows(sums[4], grid.tables)
    _sum_up_rows(sums[5], grid.pages)
    _sum_up_rows(sums[6], grid.room)
    _sum_up_rows(sums[7], known.lines.boxes)
    _sum_up_rows(sums[8], known.lines.walls)
    _sum_up_rows(sums[9], known.places)
    _sum_up_rows(sums[10], known.counter)
    for k in range(known.wheels.shape[0]):
        sums[11, 0] += (k + 1) * known.wheels[k, 0, 0]
    known.counter[0, 2] = 7


def _known(**changed: Any) -> Known:
    cells = np.zeros((70, 90), dtype=np.uint8)
    cells[10:12, 20:40] = cells[50, 60:70] = 1
    place = am.Map.from_array(cells, resolution=0.05)
    draw = np.random.default_rng(1)
    known = Known(
        grid=place.grid,
        lines=place.lines,
        origin_x=1.5,
        origin_y=-2.5,
        yaw=0.25,
        dt=0.1,
        encoder=12,
        ints=draw.integers(0, 9, 11),
        floats=draw.random(5),
        places=draw.random((4, 3)),
        wheels=draw.random((13, 1, 1)),
        counter=np.arange(6, dtype=np.uint32).reshape(2, 3),
    )
    return known._replace(**changed)


def test_a_kernel_finds_what_was_laid_out() -> None:
    known = _known()
    numbers, sums = np.zeros(9), np.zeros((12, 3))
    table = lay_out(known)
    grid, lines = known.grid, known.lines
    arrays: list[np.ndarray[Any, Any]] = [grid.supers, lines.first, known.ints, known.floats]
    arrays += [grid.tables, grid.pages, grid.room, lines.boxes, lines.walls, known.places, known.counter, known.wheels]
    expected = np.zeros((12, 3))
    for at, array in enumerate(arrays):
        for i, value in enumerate(array.ravel().tolist()):
            expected[at, 0] += (i + 1) * float(value)
        if array.ndim < 3:
            expected[at, 1 : 1 + array.ndim] = array.shape
    _tell(table, numbers, sums)
    assert numbers.tolist() == [*grid[:4], 1.5, -2.5, 0.25, 0.1, 12.0]
    np.testing.assert_array_equal(sums, expected)
    assert known.counter.tolist() == [[0, 1, 7], [3, 4, 5]]  # it is the array itself


@pytest.mark.parametrize(
    "changed",
    [{"floats": np.zeros(3, dtype=np.float32)}, {"places": np.zeros(3)}, {"places": np.zeros((3, 4)).T}],
    ids=["of another kind", "of other dimensions", "in another order"],
)
def test_what_a_kernel_would_misread_is_refused(changed: Any) -> None:
    with pytest.raises(TypeError, match=r"expected . dimensions of float64"):
        lay_out(_known(**changed))
