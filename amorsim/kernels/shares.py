"""Rows shared among threads: whoever has nothing to do takes some of what is left, until nothing is.

A kernel that can be shared is called once, by the thread whose work it is, with a `share`, an address. What all
threads are to do it writes as a function of a share and of whatever else it needs; `offer` says where that function and
that are, and `spread` has the others call it too. Each asks `take_rows` again and again for rows to work on. The thread
whose work it is takes them from the first on, the others from the last on, so each finds in its cache what it worked on
before; and nobody waits for one that has not begun. All words of an address are written one at a time
(`amorsim.core.workers` lays them out), so there is nothing to lock.

No thread needs Python, nor its global lock, for that: the others are in a kernel too (`serve`), where they look for
work for a while. Work that is Python's own, which calls kernels slice by slice, takes its rows here as well.
"""

from __future__ import annotations

import os
import platform
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba.core import cgutils, config
from numba.core import types as numba_types
from numba.extending import intrinsic

from amorsim.kernels.compile import kernel, part

__all__ = [
    "ALONE",
    "BASE",
    "BUSY",
    "GRAIN",
    "LINE",
    "LOOKED",
    "NUMBER",
    "PATIENCE",
    "RAISED",
    "RECORDS",
    "ROW_BITS",
    "SPREADS",
    "THREADS",
    "TICKET",
    "TURN",
    "UNIT",
    "WORK",
    "is_done",
    "linger",
    "offer",
    "serve",
    "spread",
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
WORK = GRAIN + 24  # where the function is that is the work, 0 for Python's; what it is given; whether it failed
GIVEN = GRAIN + 32
FAILED = GRAIN + 40
# From here on a record for each thread, the caller's first; a share is the address of one.
RECORDS = 3 * LINE
BUSY = 0  # whether it has taken rows that are not done yet
BASE = 8  # where the words of the work begin
NUMBER = 16
TURN = 24  # at which it works
PATIENCE = 32  # how often it looks before it gives up waiting
LOOKED = 40  # how often it has since it worked last
SPREADS = 48  # whether it does what was spread, and not Python's

ROW_BITS = 22
_ROWS = (1 << ROW_BITS) - 1
_TURNS = 1 << 18
_WORDS = (types.int64, types.int64)
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


def _calling(_typing: Any, _work: Any, _share: Any, _given: Any) -> Any:
    def code(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        convention = context.call_conv
        told = convention.get_function_type(types.none, _WORDS)
        work = builder.inttoptr(arguments[0], told.as_pointer())
        status, _ = convention.call_function(builder, work, types.none, _WORDS, arguments[1:])
        return builder.zext(status.is_error, _WORD)

    return types.int64(types.int64, types.int64, types.int64), code


def _uncounted(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    """The same value, of whose arrays nobody counts references."""
    if isinstance(kind, types.Array):
        array = context.make_array(kind)(context, builder, value)
        array.meminfo = cgutils.get_null_value(array.meminfo.type)
        return array._getvalue()
    if isinstance(kind, types.BaseTuple):
        for place, member in enumerate(kind):
            made = _uncounted(context, builder, member, builder.extract_value(value, place))
            value = builder.insert_value(value, made, place)
    return value


def _offering(typing: Any, work: Any, given: Any) -> Any:
    if not isinstance(work, types.Dispatcher) or not isinstance(given, types.BaseTuple):
        return None
    kind = typing.resolve_function_type(work, (types.int64, *map(types.unliteral, given)), {})

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        # A function of two addresses, that all works are called as: it finds at the second what the work is given.
        convention = context.call_conv
        told = convention.get_function_type(types.none, _WORDS)
        function = ir.Function(builder.module, told, builder.module.get_unique_name("work"))
        function.linkage = "internal"
        convention.decorate_function(function, ("share", "given"), _WORDS)
        inner = ir.IRBuilder(function.append_basic_block())
        share, place = convention.get_arguments(function)
        values = cgutils.unpack_tuple(inner, inner.load(inner.inttoptr(place, arguments[1].type.as_pointer())))
        call = context.get_function(work, kind)
        call(inner, (share, *(_uncounted(context, inner, *each) for each in zip(given, values, strict=True))))
        convention.return_value(inner, context.get_dummy_value())
        kept = cgutils.alloca_once_value(builder, arguments[1])
        both = [builder.ptrtoint(each, _WORD) for each in (function, kept)]
        return context.make_tuple(builder, signature.return_type, both)

    return types.UniTuple(types.int64, 2)(work, given), code


# The word at an address; to write one; to write one if it is the old one still, and whether it was; to tell the
# processor that somebody waits here; to let others have it, where that can be told; to call a work with a share and
# what it is given, and whether that failed.
_load: Callable[[int], int] = intrinsic(_loading)
_store: Callable[[int, int], None] = intrinsic(_storing)
_exchange: Callable[[int, int, int], int] = intrinsic(_exchanging)
_pause: Callable[[], None] = intrinsic(_pausing)
_give_way: Callable[[], None] = intrinsic(_giving_way)
_call: Callable[[int, int, int], int] = intrinsic(_calling)
offer: Callable[[Callable[..., None], tuple[Any, ...]], tuple[int, int]] = intrinsic(_offering)
"""Work for `spread`: a kernel, that takes a share first, and what it is given beside it, in a tuple.

It may be spread until the function returns that has offered it, which has to hold the arrays: nobody who works counts
references to them. Threads that count the same ones wait for each other.
"""
if config.DISABLE_JIT:

    def _call(work: Any, share: int, given: Any) -> int:
        work(share, *given)
        return 0

    def offer(work: Any, given: Any) -> Any:  # noqa: D103 - as above
        return work, given


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
    """There are no rows left of Python's work: wait, as the caller until all are done, as another for other work.

    The latter for a while, and when one has said that one's own rows are done.
    """
    if _load(share + SPREADS) != 0:  # whoever called it sees to that
        return
    patience = _load(share + PATIENCE)
    looked = 0
    if _load(share + NUMBER) == 0:
        while looked < patience and _are_busy(base):
            looked = _wait(looked)
        return
    _store(share + BUSY, 0)
    turn = _load(share + TURN)
    while looked < patience and -1 <= _load(base + RAISED) - turn <= 0:
        looked = _wait(looked)
    _store(share + LOOKED, looked)


@part
def _are_busy(base: int) -> bool:
    """Whether anybody but the caller has rows that are not done yet."""
    busy = 0
    for other in range(1, _load(base + THREADS)):
        busy |= _load(base + RECORDS + other * LINE + BUSY)
    return busy != 0


@part
def _is_open(base: int, turn: int) -> bool:
    """Whether there are rows left of the work of a turn."""
    ticket = _load(base + TICKET)
    return ticket >> (2 * ROW_BITS) == turn and (ticket >> ROW_BITS) & _ROWS != ticket & _ROWS


@part
def spread(share: int, rows: int, offered: tuple[int, int]) -> None:
    """Have all threads do what was offered (`offer`), and return when it is done; nobody begins before.

    Parameters
    ----------
    share
        What `amorsim.core.workers.Workers.share` gave; where that is `ALONE`, nobody else does anything.
    rows
        How many there are in all.
    """
    if share == ALONE:
        if _call(offered[0], ALONE, offered[1]) != 0:
            raise MemoryError  # nothing else goes wrong in kernels than that there is no room for an array
        return
    base = _load(share + BASE)
    turn = _load(share + TURN) % _TURNS + 1
    unit = _load(base + UNIT)
    _store(base + WORK, offered[0])
    _store(base + GIVEN, offered[1])
    _store(base + FAILED, 0)
    _store(share + TURN, turn)
    _store(base + TICKET, turn << (2 * ROW_BITS) | (rows + unit - 1) // unit)
    _store(base + RAISED, turn)
    _store(share + SPREADS, 1)
    failed = _call(offered[0], share, offered[1])
    _store(share + SPREADS, 0)
    were_left = _is_open(base, turn)
    _store(base + TICKET, turn << (2 * ROW_BITS))  # whatever was not taken will not be
    looked = 0
    while _are_busy(base):
        looked = _wait(looked)
    if failed != 0 or _load(base + FAILED) != 0:
        raise MemoryError
    if were_left:
        raise RuntimeError("expected work that takes rows until none are left (shares.take_rows)")


@kernel
def serve(share: int) -> int:
    """Do whatever is spread, as another thread than the caller's, until there is Python's work: the turn of that.

    Or 0, if for a while there was nothing to do.
    """
    base = _load(share + BASE)
    patience = _load(share + PATIENCE)
    looked = _load(share + LOOKED)
    while looked < patience:
        turn = _load(base + RAISED)
        if turn < 0:
            return 0
        if turn == _load(share + TURN):
            looked = _wait(looked)
            continue
        looked = 0
        _store(share + TURN, turn)
        # The caller looks whether anybody is busy when no rows are left; so if some are left after this has been said,
        # what it has offered stays.
        _store(share + BUSY, turn)
        if _is_open(base, turn):
            work = _load(base + WORK)
            if work == 0:
                _store(share + BUSY, 0)
                _store(share + LOOKED, 0)
                return turn
            _store(share + SPREADS, 1)
            if _call(work, share, _load(base + GIVEN)) != 0:
                _store(base + FAILED, 1)
            _store(share + SPREADS, 0)
        _store(share + BUSY, 0)
    _store(share + LOOKED, 0)
    return 0


@part
def take_rows(share: int, rows: int, end: int) -> tuple[int, int]:
    """The next rows to work on, the first and one past the last; none are left if these are equal.

    Parameters
    ----------
    share
        `ALONE`, or that of the thread.
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
        # To begin is not for nothing: at first nearly all that will be one's own, then less and less.
        share_of_all = (rows // _load(base + UNIT) if end == 0 else high - low) // _load(base + THREADS)
        taken = max(_load(base + GRAIN), share_of_all * 7 // 8 if end == 0 else share_of_all * 3 // 4)
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
    return not _are_busy(base)


@kernel
def linger(base: int, times: int) -> None:
    """Look so many times at a word, as those do who wait: to find how long that takes."""
    looked = 0
    while looked < times and _load(base + RAISED) >= 0:
        looked = _wait(looked)
