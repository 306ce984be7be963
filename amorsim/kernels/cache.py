"""The cache of compiled kernels: how it is read and written (`amorsim.kernels.folder` says where it lies).

numba's own cache looks only at the file of the function it compiles, so a change in a callee of another file would
leave old machine code in use. Here a kernel goes stale with its source and that of every kernel file that it imports.
"""

from __future__ import annotations

import contextlib
import gc
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from numba.core import caching, compiler
from numba.core.registry import cpu_target
from numba.core.runtime import rtsys

from amorsim.kernels.claims import PAUSE, Claims
from amorsim.kernels.folder import cache_folder, source_stamp
from amorsim.kernels.parts import KIND, rebuild_library

__all__ = ["KernelCache", "PartCache", "no_garbage_collected", "take_turns"]


class _KernelLocator(caching._CacheLocator):  # type: ignore[misc, unused-ignore]
    """Tells numba where compiled kernels lie and what they depend on."""

    def __init__(self, py_func: Callable[..., Any], py_file: str) -> None:
        self._line = py_func.__code__.co_firstlineno
        self._file = Path(py_file)

    def get_cache_path(self) -> str:
        return str(cache_folder())

    def get_source_stamp(self) -> str:
        return source_stamp(self._file)

    def get_disambiguator(self) -> str:
        return str(self._line)

    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> _KernelLocator | None:
        return None if cache_folder() is None else cls(py_func, py_file)


class _KernelCacheImpl(caching.CompileResultCacheImpl):  # type: ignore[misc, unused-ignore]
    """Keeps machine code alone: no kernel is linked into another one, its part is."""

    _locator_classes = [_KernelLocator]  # noqa: RUF012 - as numba declares it

    def reduce(self, compiled: Any) -> tuple[Any, ...]:
        described = compiled.fndesc
        described.typemap = described.calltypes = None  # may not be picklable, and nobody asks
        # One without constants is never read, and would have its function's module imported: that of numba's own code.
        environments = tuple(one for one in compiled._find_referenced_environments() if one.consts)
        return (
            self._code_of(compiled),
            described,
            compiled.environment,
            compiled.signature,
            compiled.reload_init,
            environments,
        )

    def rebuild(self, context: Any, kept: tuple[Any, ...]) -> Any:
        code, described, environment, signature, reload_init, environments = kept
        for function in reload_init:
            function()
        library, entry = self._load(context, code, described, environment)
        for one in environments:
            library.codegen.set_env(one.env_name, one)
        return compiler.compile_result(
            target_context=context,
            typing_context=context.typing_context,
            library=library,
            environment=environment,
            entry_point=entry,
            fndesc=described,
            signature=signature,
            objectmode=False,
            lifted=(),
            reload_init=reload_init,
            referenced_envs=environments,
        )

    def _code_of(self, compiled: Any) -> tuple[Any, ...]:
        return compiled.library.name, compiled.library._get_compiled_object()

    def _load(self, context: Any, code: tuple[Any, ...], described: Any, environment: Any) -> tuple[Any, Any]:
        name, machine_code = code
        library = context.codegen().create_library(name)
        library.enable_object_caching()
        library._set_compiled_object(machine_code)
        library._finalize_final_module()
        library.codegen._engine._defined_symbols.add(described.llvm_cpython_wrapper_name)
        return library, context.get_executable(library, described, environment)


class _PartCacheImpl(_KernelCacheImpl):
    """Keeps LLVM's code."""

    def get_filename_base(self, fullname: str, abiflags: str) -> str:
        return f"{super().get_filename_base(fullname, abiflags)}.{KIND}"

    def _code_of(self, compiled: Any) -> tuple[Any, ...]:
        return compiled.library.name, compiled.library.bitcode()

    def _load(self, context: Any, code: tuple[Any, ...], described: Any, environment: Any) -> tuple[Any, Any]:
        library = rebuild_library(context.codegen(), *code)
        return library, context.get_executable(library, described, environment)


class KernelCache(caching.FunctionCache):  # type: ignore[misc, unused-ignore]
    """The machine code of what Python calls."""

    _impl_class = _KernelCacheImpl
    claims: Claims | None = None  # of this process, once it takes turns with others

    def load_overload(self, signature: Any, context: Any) -> Any:
        """The compiled function, if the cache has it, or will have, for another process is just compiling it."""
        found = self._look(signature, context)
        if self.claims is None:
            return found
        path = self._claim(signature)
        while found is None:
            is_claimed = self.claims.try_for(path)
            if not is_claimed:
                time.sleep(PAUSE)
                if path.exists():
                    continue
            # Whoever had the claim has saved the kernel, unless compiling it failed.
            found = self._look(signature, context)
            if is_claimed:
                break
        if found is not None:
            self.claims.give_up(path)
        return found

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Keep a compiled function, for later processes and for those that wait."""
        try:
            super().save_overload(signature, compiled)
        finally:
            self.let_go(signature)

    def holds(self, signature: Any) -> bool:
        """Whether the function is there, compiled for these types."""
        return self._index_key(signature, cpu_target.target_context.codegen()) in self._cache_file._load_index()

    def is_taken(self, signature: Any) -> bool:
        """Whether another process is just compiling it."""
        return self.claims is not None and self.claims.is_taken(self._claim(signature))

    def let_go(self, signature: Any) -> None:
        """Compiling it failed: let others try."""
        if self.claims is not None:
            self.claims.give_up(self._claim(signature))

    def _look(self, signature: Any, context: Any) -> Any:
        # numba would first make itself ready to compile, which takes longer than loading all kernels of a run.
        rtsys.initialize(context)
        with self._guard_against_spurious_io_errors():
            return self._load_overload(signature, context)

    def _claim(self, signature: Any) -> Path:
        assert self.claims is not None
        return self.claims.path(self._impl.filename_base, str(signature))


class PartCache(KernelCache):
    """LLVM's code of what kernels call."""

    _impl_class = _PartCacheImpl


@contextlib.contextmanager
def no_garbage_collected() -> Iterator[None]:
    """While something is compiled: most of what is made stays, and to look through it takes a good part of the time."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


def take_turns() -> None:
    """From now on, let this process and others that do the same compile each kernel once between them."""
    folder = cache_folder()
    if folder is not None and KernelCache.claims is None:
        KernelCache.claims = Claims(folder)
