"""Rows shared among threads: whoever has nothing to do takes some of what is left, until nothing is.

A kernel that can be shared is called by each thread with the same arguments but for `share`, an address, and asks
`take_rows` again and again for rows to work on. The thread that calls the work takes them from the first on, the others
from the last on, so each finds in its cache what it worked on before; and nobody waits for one that has not begun. All
words of an address are written one at a time (`amorsim.core.workers` lays them out), so there is nothing to lock.

No thread needs Python's global lock for that: work is begun once the caller has given it up, the end is awaited
without it, and so is the next work, for a while.
"""

from __future__ import annotations

import os
import platform
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba.core import cgutils
from numba.core import types as numba_types
from numba.extending import intrinsic

from amorsim.kernels.compile import kernel, part

__all__ = [
    "ALONE",
    "BASE",
    "BUSY",
    "GRAIN",
    "LINE",
    "NUMBER",
    "PATIENCE",
    "RAISED",
    "RECORDS",
    "ROW_BITS",
    "THREADS",
    "TICKET",
    "TURN",
    "UNIT",
    "is_done",
    "linger",
    "take_rows",
]

types: Any = numba_types  # its names are made when it is imported, so that type checkers know none of them

ALONE = 0
"""The share of a thread that has all rows to itself."""

LINE = 128
"""Bytes from one block of words to the next: two lines of a cache, which processors fetch together."""

# Of the work: the ticket, which holds the number of its turn and the first and last of the rows that nobody has taken;
# the turn that the caller has begun; and how rows are parted.
TICKET, RAISED, GRAIN = 0, LINE, 2 * LINE
THREADS = GRAIN + 8
UNIT = GRAIN + 16  # rows that a ticket counts as one
# From here on a record for each thread, the caller's first; a share is the address of one.
RECORDS = 3 * LINE
BUSY = 0  # whether it has taken rows that are not done yet
BASE = 8  # where the words of the work begin
NUMBER = 16
TURN = 24  # at which it works
PATIENCE = 32  # how often it looks before it gives up waiting

ROW_BITS = 22
_ROWS = (1 << ROW_BITS) - 1
_WORD = ir.IntType(64)
_LOOKS = 64  # after which others get the processor, if they wait for it
# By machine: LLVM's name of the instruction, and its arguments.
_PAUSES: dict[str, Any] = {
    "x86_64": ("llvm.x86.sse2.pause",),
    "amd64": ("llvm.x86.sse2.pause",),
    "arm64": ("llvm.aarch64.hint", 1),
    "aarch64": ("llvm.aarch64.hint", 1),
}


def _loading(_typing: Any, _address: Any) -> Any:
    def code(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        place = builder.inttoptr(arguments[0], _WORD.as_pointer())
        return builder.load_atomic(place, "seq_cst", 8)

    return types.int64(types.int64), code


def _storing(_typing: Any, _address: Any, _word: Any) -> Any:
    def code(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        place = builder.inttoptr(arguments[0], _WORD.as_pointer())
        builder.store_atomic(arguments[1], place, "seq_cst", 8)
        return context.get_dummy_value()

    return types.none(types.int64, types.int64), code


def _exchanging(_typing: Any, _address: Any, _old: Any, _new: Any) -> Any:
    def code(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        place = builder.inttoptr(arguments[0], _WORD.as_pointer())
        told = builder.cmpxchg(place, arguments[1], arguments[2], "seq_cst", "seq_cst")
        return builder.zext(builder.extract_value(told, 1), _WORD)

    return types.int64(types.int64, types.int64, types.int64), code


def _pausing(_typing: Any) -> Any:
    name, *numbers = _PAUSES.get(platform.machine().lower(), ("",))

    def code(context: Any, builder: Any, _signature: Any, _arguments: Any) -> Any:
        if name:
            words = [ir.Constant(ir.IntType(32), number) for number in numbers]
            told = ir.FunctionType(ir.VoidType(), [word.type for word in words])
            builder.call(builder.module.declare_intrinsic(name, (), told), words)
        return context.get_dummy_value()

    return types.none(), code


def _giving_way(_typing: Any) -> Any:
    def code(context: Any, builder: Any, _signature: Any, _arguments: Any) -> Any:
        if os.name == "posix":
            told = ir.FunctionType(ir.IntType(32), [])
            builder.call(cgutils.get_or_insert_function(builder.module, told, "sched_yield"), [])
        return context.get_dummy_value()

    return types.none(), code


# The word at an address; to write one; to write one if it is the old one still, and whether it was; to tell the
# processor that somebody waits here; and to let others have it, where that can be told.
_load: Callable[[int], int] = intrinsic(_loading)
_store: Callable[[int, int], None] = intrinsic(_storing)
_exchange: Callable[[int, int, int], int] = intrinsic(_exchanging)
_pause: Callable[[], None] = intrinsic(_pausing)
_give_way: Callable[[], None] = intrinsic(_giving_way)


@part
def _wait(looked: int) -> int:
    """Wait a moment between two looks; how often one has looked then.

    Now and then whoever else waits for the processor gets it: it may be who is waited for.
    """
    looked += 1
    if looked % _LOOKS == 0:
        _give_way()
    else:
        _pause()
    return looked


@part
def _finish(share: int, base: int) -> None:
    """There are no rows left: as the caller wait until all are done, as another until there is other work, for a while.

    Before that, as another, say that one's own are done.
    """
    patience = _load(share + PATIENCE)
    looked = 0
    if _load(share + NUMBER) == 0:
        for other in range(1, _load(base + THREADS)):
            while looked < patience and _load(base + RECORDS + other * LINE + BUSY) != 0:
                looked = _wait(looked)
        return
    _store(share + BUSY, 0)
    turn = _load(share + TURN)
    while looked < patience and -1 <= _load(base + RAISED) - turn <= 0:
        looked = _wait(looked)


@part
def take_rows(share: int, rows: int, end: int) -> tuple[int, int]:
    """The next rows to work on, the first and one past the last; none are left if these are equal.

    Parameters
    ----------
    share
        `ALONE`, or what `amorsim.core.workers.Workers.share` gave.
    rows
        How many there are in all.
    end
        The end that was told last; 0 to begin with.
    """
    if share == ALONE:
        return end, rows
    base = _load(share + BASE)
    number = _load(share + NUMBER)
    turn = _load(share + TURN)
    if end == 0:
        _store(base + RAISED if number == 0 else share + BUSY, turn)
    while True:
        ticket = _load(base + TICKET)
        low = (ticket >> ROW_BITS) & _ROWS
        high = ticket & _ROWS
        if ticket >> (2 * ROW_BITS) != turn or low == high:
            break
        taken = max(_load(base + GRAIN), 3 * (high - low) // (4 * _load(base + THREADS)))
        taken = min(taken, high - low)
        first = low if number == 0 else high - taken
        left = ticket + (taken << ROW_BITS) if number == 0 else ticket - taken
        if _exchange(base + TICKET, ticket, left) != 0:
            unit = _load(base + UNIT)
            return first * unit, min((first + taken) * unit, rows)
    _finish(share, base)
    return rows, rows


@kernel
def is_done(base: int) -> bool:
    """Whether nobody but the caller has rows that are not done yet."""
    busy = 0
    for other in range(1, _load(base + THREADS)):
        busy |= _load(base + RECORDS + other * LINE + BUSY)
    return busy == 0


@kernel
def linger(base: int, times: int) -> None:
    """Look so many times at a word, as those do who wait: to find how long that takes."""
    looked = 0
    while looked < times and _load(base + RAISED) >= 0:
        looked = _wait(looked)
