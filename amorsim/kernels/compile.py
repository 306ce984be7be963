"""The decorators that compile kernels and their parts.

Options are set here and nowhere else: no fast mathematics (bits must not depend on how a loop is cut), no
global interpreter lock while a kernel runs (threads of Python run kernels side by side), and a cache that goes
stale with the source of a kernel and of every kernel file it imports (`amorsim.kernels.cache`). A function is compiled
in one way for Python and in another, shorter one for kernels that call it (`amorsim.kernels.parts`).
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba.core import config
from numba.core import types as numba_types
from numba.core.registry import CPUDispatcher

from amorsim.kernels.cache import KernelCache, PartCache, no_garbage_collected
from amorsim.kernels.folder import cache_folder
from amorsim.kernels.parts import KernelCompiler, PartCompiler

__all__ = ["inlined", "kernel", "part"]

types: Any = numba_types  # its names are made when it is imported, so that type checkers know none of them
F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Compile `function` when first called, as all kernels are: ``nogil``, cached, IEEE arithmetic as written.

    Division by zero gives `inf` or `nan` as NumPy does. Arguments are numbers and C-contiguous arrays; callers keep
    to one dtype and dimension per argument, so that each kernel compiles once.
    """
    return _compiled(function)


def part(function: F) -> F:
    """Compile `function` as a part of kernels, that makes no array of its own.

    Whoever calls it holds the arrays, so references to them are not counted. Counting them takes longer than the work
    of a small function: cones were told in half the time without.
    """
    return _compiled(function, _nrt=False)


def inlined(function: F) -> F:
    """Compile `function` as a `part` that is put into each place where it is called, however long it is.

    For what is called once in a loop that is to go several wide: a loop with a call in it does not.
    """
    return _compiled(function, _nrt=False, forceinline=True)


def _compiled(function: F, **options: Any) -> F:
    if config.DISABLE_JIT:
        return function
    options = {"nopython": True, "nogil": True, "error_model": "numpy", "fastmath": False, **options}
    dispatcher = _Kernel(function, targetoptions={**options, "no_cfunc_wrapper": True}, pipeline_class=KernelCompiler)
    if cache_folder() is not None:
        dispatcher._cache = KernelCache(function)
    return cast(F, dispatcher)


class _Dispatcher(CPUDispatcher):  # type: ignore[misc, unused-ignore]
    """numba's, that lets no garbage be collected while it compiles, and compiles nothing anew for a constant."""

    def compile(self, signature: Any) -> Any:
        """Load or compile the function for these types."""
        with no_garbage_collected():
            return super().compile(signature)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """What it gives where a kernel calls it, constants taken for numbers like any other."""
        # LLVM sees the constant wherever the function is put into its caller.
        return super().get_call_template(
            tuple(types.unliteral(each) for each in args), {name: types.unliteral(each) for name, each in kws.items()}
        )


class _Kernel(_Dispatcher):
    """What Python calls; kernels that name it call its part."""

    @functools.cached_property
    def _part(self) -> _Dispatcher:
        options = {**self.targetoptions, "no_cpython_wrapper": True}
        made = _Dispatcher(self.py_func, targetoptions=options, pipeline_class=PartCompiler)
        if cache_folder() is not None:
            made._cache = PartCache(self.py_func)
        return made

    @property
    def _numba_type_(self) -> Any:
        return self._part._type

    def add_overload(self, compiled: Any) -> None:
        super().add_overload(compiled)
        # Its parts have no machine code that could have been told.
        for environment in compiled._find_referenced_environments():
            compiled.codegen.set_env(environment.env_name, environment)
