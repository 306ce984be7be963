"""The decorators that compile kernels and their parts.

The options are set here and nowhere else: no fast mathematics (bits must not depend on how a loop is cut), no global
interpreter lock while a kernel runs (threads run kernels side by side), and numba's cache, in a folder that changes
with the sources (`amorsim.kernels.cache_folder`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

from amorsim.kernels.cache_folder import KernelLocator, cache_folder

__all__ = ["inlined", "kernel", "part"]

F = TypeVar("F", bound=Callable[..., Any])

# The second is numba's own, for kernels of plugins: it takes `CACHE_DIR`.
_LOCATORS = f"{KernelLocator.__module__}.{KernelLocator.__qualname__},UserProvidedCacheLocator"


def kernel(function: F) -> F:
    """Compile `function` when it is first called: ``nogil``, cached, IEEE arithmetic as written.

    Division by zero gives `inf` or `nan` as NumPy does. Arguments are numbers, C-contiguous arrays, and named tuples of
    these. Callers keep to one dtype and dimension for each argument, so that each kernel compiles once.
    """
    return _compiled(function)


def part(function: F) -> F:
    """Compile `function` as a part of kernels that allocates no array.

    Its callers hold the arrays, so numba need not count references to them; in a small function that counting takes
    longer than the work.
    """
    return _compiled(function, _nrt=False)


def inlined(function: F) -> F:
    """Compile `function` as a `part` that LLVM inlines wherever it is called.

    For a call in a loop that LLVM is to vectorise: it vectorises no loop with a call in it.
    """
    return _compiled(function, _nrt=False, forceinline=True)


def _compiled(function: F, **options: Any) -> F:
    folder = cache_folder()
    before = numba.config.CACHE_DIR, numba.config.CACHE_LOCATOR_CLASSES
    numba.config.CACHE_DIR, numba.config.CACHE_LOCATOR_CLASSES = str(folder or ""), _LOCATORS
    try:
        made = numba.njit(cache=folder is not None, nogil=True, error_model="numpy", **options)(function)
    finally:
        numba.config.CACHE_DIR, numba.config.CACHE_LOCATOR_CLASSES = before
    return cast(F, made)
