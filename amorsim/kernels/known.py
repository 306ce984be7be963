"""What a kernel is told again and again, handed over in one: a table of where arrays lie, and of their shapes.

To take an array from Python takes a kernel some 0.05 us, and there are a score that stay where they are from step to
step: the map, the plan of devices, the numbers of wheels. `lay_out` writes down once where they are, and `known_at`
finds them there. Whoever holds such a table must hold the arrays too: it does not keep them alive.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numba.core import cgutils, config
from numba.core import types as numba_types
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array
from numpy.typing import DTypeLike, NDArray

from amorsim.kernels.compile import part
from amorsim.kernels.grid import Grid
from amorsim.kernels.lines import Lines

__all__ = ["Known", "known_at", "lay_out"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

types: Any = numba_types  # its names are made when it is imported, so that type checkers know none of them


class Known(NamedTuple):
    """What lasts while a group's parameters do."""

    grid: Grid
    lines: Lines
    origin_x: float
    """Where the grid lies in the world, as `origin_y` [m] and `yaw` [rad]."""
    origin_y: float
    yaw: float
    dt: float
    """[s]"""
    encoder: int
    """Where in what is measured the counts begin that the robot reckons by."""
    ints: Ints
    """A plan of devices, with `floats` and `places`, as `sensing.sense` takes it."""
    floats: Floats
    places: Floats
    wheels: Floats
    """(ROLLING + RECKONING, N, 1), first as `rolling.roll_free` and then as `concluding.conclude` takes them."""
    counter: NDArray[np.uint32]
    """(N, 3): replica, episode and tick that draws count by; the tick is written."""


def _viewing(dtype: DTypeLike, dimensions: int) -> Callable[[int, tuple[int, ...]], Any]:
    """What makes of an address, and a shape, an array of that kind; nobody counts references to it."""
    if config.DISABLE_JIT:

        def found(address: int, shape: tuple[int, ...]) -> Any:
            pointer = ctypes.POINTER(np.ctypeslib.as_ctypes_type(dtype))
            return np.ctypeslib.as_array(ctypes.cast(int(address), pointer), shape)

        return found
    array = types.Array(getattr(types, np.dtype(dtype).name), dimensions, "C")
    size = np.dtype(dtype).itemsize

    def viewing(_typing: Any, _address: Any, _shape: Any) -> Any:
        def code(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            made = context.make_array(array)(context, builder)
            shape = cgutils.unpack_tuple(builder, arguments[1])
            strides = [context.get_constant(types.intp, size)]
            for length in shape[:0:-1]:
                strides.insert(0, builder.mul(strides[0], length))
            populate_array(
                made,
                data=builder.inttoptr(arguments[0], made.data.type),
                shape=shape,
                strides=strides,
                itemsize=strides[-1],
                meminfo=None,
            )
            return made._getvalue()

        return array(types.int64, types.UniTuple(types.int64, dimensions)), code

    told: Callable[[int, tuple[int, ...]], Any] = intrinsic(viewing)
    return told


# Whole numbers and [m, rad, s] in the table, and then of each array its place in memory and three sizes.
_ROWS, _COLS, _SUPER_COLS, _ENCODER = range(4)
_NUMBERS = 4
_RESOLUTION, _ORIGIN_X, _ORIGIN_Y, _YAW, _DT = range(_NUMBERS, _NUMBERS + 5)
_ARRAYS = _NUMBERS + 5
_EACH = 4
_SUPERS, _TABLES, _PAGES, _ROOM, _BOXES, _FIRST, _WALLS, _PLAN_INTS, _PLAN_FLOATS, _PLACES, _WHEELS, _COUNTER = range(
    _ARRAYS, _ARRAYS + 12 * _EACH, _EACH
)
_END = _ARRAYS + 12 * _EACH
_KINDS: tuple[tuple[int, DTypeLike, int], ...] = (
    (_SUPERS, np.int32, 1),
    (_TABLES, np.int32, 2),
    (_PAGES, np.uint64, 2),
    (_ROOM, np.uint16, 2),
    (_BOXES, np.float64, 2),
    (_FIRST, np.int64, 1),
    (_WALLS, np.float64, 2),
    (_PLAN_INTS, np.int64, 1),
    (_PLAN_FLOATS, np.float64, 1),
    (_PLACES, np.float64, 2),
    (_WHEELS, np.float64, 3),
    (_COUNTER, np.uint32, 2),
)
_view_supers = _viewing(np.int32, 1)
_view_tables = _viewing(np.int32, 2)
_view_pages = _viewing(np.uint64, 2)
_view_room = _viewing(np.uint16, 2)
_view_counts = _viewing(np.uint32, 2)
_view_ints = _viewing(np.int64, 1)
_view_floats = _viewing(np.float64, 1)
_view_rows = _viewing(np.float64, 2)
_view_blocks = _viewing(np.float64, 3)


def lay_out(known: Known) -> Ints:
    """The table for `known_at`; `TypeError` for an array of another kind than kernels would take it for."""
    grid, lines = known.grid, known.lines
    table = np.zeros(_END, dtype=np.int64)
    table[:_NUMBERS] = grid.rows, grid.cols, grid.super_cols, known.encoder
    table[_NUMBERS:_ARRAYS].view(np.float64)[:] = (
        grid.resolution,
        known.origin_x,
        known.origin_y,
        known.yaw,
        known.dt,
    )
    arrays: tuple[NDArray[Any], ...] = (
        grid.supers,
        grid.tables,
        grid.pages,
        grid.room,
        lines.boxes,
        lines.first,
        lines.walls,
    )
    arrays += (known.ints, known.floats, known.places, known.wheels, known.counter)
    for (at, dtype, dimensions), array in zip(_KINDS, arrays, strict=True):
        if array.dtype != dtype or array.ndim != dimensions or not array.flags.c_contiguous:
            raise TypeError(f"expected {dimensions} dimensions of {np.dtype(dtype)}, got {array.shape} {array.dtype}")
        table[at] = array.ctypes.data
        table[at + 1 : at + 1 + dimensions] = array.shape
    return table


@part
def known_at(table: Ints) -> Known:
    """What `lay_out` laid out."""
    t = table
    numbers = t.view(np.float64)
    grid = Grid(
        numbers[_RESOLUTION],
        t[_ROWS],
        t[_COLS],
        t[_SUPER_COLS],
        _view_supers(t[_SUPERS], (t[_SUPERS + 1],)),
        _view_tables(t[_TABLES], (t[_TABLES + 1], t[_TABLES + 2])),
        _view_pages(t[_PAGES], (t[_PAGES + 1], t[_PAGES + 2])),
        _view_room(t[_ROOM], (t[_ROOM + 1], t[_ROOM + 2])),
    )
    lines = Lines(
        _view_rows(t[_BOXES], (t[_BOXES + 1], t[_BOXES + 2])),
        _view_ints(t[_FIRST], (t[_FIRST + 1],)),
        _view_rows(t[_WALLS], (t[_WALLS + 1], t[_WALLS + 2])),
    )
    return Known(
        grid,
        lines,
        numbers[_ORIGIN_X],
        numbers[_ORIGIN_Y],
        numbers[_YAW],
        numbers[_DT],
        t[_ENCODER],
        _view_ints(t[_PLAN_INTS], (t[_PLAN_INTS + 1],)),
        _view_floats(t[_PLAN_FLOATS], (t[_PLAN_FLOATS + 1],)),
        _view_rows(t[_PLACES], (t[_PLACES + 1], t[_PLACES + 2])),
        _view_blocks(t[_WHEELS], (t[_WHEELS + 1], t[_WHEELS + 2], t[_WHEELS + 3])),
        _view_counts(t[_COUNTER], (t[_COUNTER + 1], t[_COUNTER + 2])),
    )
