"""What numba works out again and again while it compiles, worked out once.

Compiling what the demo needs, numba asks 18,000 times which of its functions takes such arguments and what that gives,
for 1,000 different questions: mostly what comes of two numbers. Each time it goes through all of the function's name,
those for whole arrays first. Its answers do not change, but it may find some where it had none: only those that it
has are kept.
"""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Iterator
from typing import Any

from numba.core import base
from numba.core import types as numba_types

__all__ = ["kept_answers"]

_Function: Any = numba_types.Function
_get_call_type = _Function.get_call_type
_call_types: dict[tuple[Any, tuple[Any, ...]], Any] = {}
_sizes: dict[str, int] = {}


@contextlib.contextmanager
def kept_answers(target: Any) -> Iterator[None]:
    """Keep numba's answers to what is asked meanwhile, by one thread alone; `target` is its context for lowering."""
    before = _Function.get_call_type, base._has_loc
    get_abi_sizeof, is_outermost = target.get_abi_sizeof, "get_abi_sizeof" not in vars(target)

    def size_of(type_: Any) -> int:
        """The size of a type of LLVM's [bytes], for which a module is made each time."""
        name = str(type_)
        if name not in _sizes:
            _sizes[name] = get_abi_sizeof(type_)
        return _sizes[name]

    _Function.get_call_type, base._has_loc = _call_type, _has_loc
    if is_outermost:
        target.get_abi_sizeof = size_of
    try:
        yield
    finally:
        _Function.get_call_type, base._has_loc = before
        if is_outermost:  # else whoever compiles what calls this goes on
            del target.get_abi_sizeof


def _call_type(function: Any, context: Any, args: tuple[Any, ...], kws: dict[str, Any]) -> Any:
    if kws:
        return _get_call_type(function, context, args, kws)
    key = function, args
    if key not in _call_types:
        _call_types[key] = _get_call_type(function, context, args, kws)
    return _call_types[key]


# Which implementations want to know the line; numba looks at the signature of each whenever one is used.
_has_loc = functools.cache(base._has_loc)
