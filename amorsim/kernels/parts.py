"""How a kernel is compiled for those that call it: to LLVM's code only, with nothing that Python or the processor runs.

numba compiles each function that a compiled one calls as if Python called it too: it makes two wrappers, optimises all,
makes machine code, and then hands LLVM's code on to the caller, where it is optimised once more and becomes machine
code again. Of some 130 functions of a first step 20 are called by Python. What only kernels call gets no wrapper, no
machine code, and but the first round of optimisation, the one that has callees inlined; the kernel that Python
calls is optimised whole, as ever.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from llvmlite import binding
from numba import _dynfunc
from numba.core import codegen, compiler

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["KIND", "PartCompiler", "rebuild_library", "stand_in"]

KIND = "part"


class _PartLibrary(codegen.JITCodeLibrary):  # type: ignore[misc, unused-ignore]
    """LLVM's code of a function and its callees, for linking alone."""

    _bitcode: bytes | None = None

    def _optimize_final_module(self) -> None:
        made = self._codegen._module_pass_manager(loop_vectorize=False, slp_vectorize=False, opt=0, cost="cheap")
        passes, *builder = made if isinstance(made, tuple) else (made,)  # older versions of numba give no builder
        passes.run(self._final_module, *builder)

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def _get_module_for_linking(self) -> Any:
        if self._bitcode is not None:
            self._final_module = self._shared_module = binding.parse_bitcode(self._bitcode)
            self._bitcode = None
        return super()._get_module_for_linking()

    def get_pointer_to_function(self, name: str) -> int:
        return 0

    def bitcode(self) -> bytes:
        """What `rebuild_library` takes."""
        code: bytes = self._get_module_for_linking().as_bitcode()
        return code


def rebuild_library(made_by: Any, name: str, bitcode: bytes) -> _PartLibrary:
    """The library with such code; the code is read when somebody links it."""
    library = _PartLibrary(made_by, name)
    library._bitcode = bitcode
    library._finalized = True
    return library


def stand_in(library: Any, fndesc: Any, env: Any) -> Any:
    """What stands for the machine code that there is not; nobody calls it, but callers are known to numba by it."""
    name = fndesc.qualname.split(".")[-1]
    return _dynfunc.make_function(fndesc.lookup_module(), name, f"part {fndesc.qualname!r}", 0, env, (library,))


class PartCompiler(compiler.Compiler):  # type: ignore[misc, unused-ignore]
    """numba's compiler, that leaves LLVM's code in a library for linking."""

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """Compile `func` for the types that this compiler was made for."""
        self.state.library = _PartLibrary(self.state.targetctx.codegen(), func.__qualname__)
        self.state.library.enable_object_caching()
        # The context is this compilation's own copy.
        self.state.targetctx.get_executable = stand_in
        return super().compile_extra(func)
