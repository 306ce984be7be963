"""How kernels are compiled, and how what only kernels call: to LLVM's code alone, with nothing that the processor runs.

numba compiles each function that a compiled one calls as if Python called it too: it makes two wrappers, optimises all,
makes machine code, and then hands LLVM's code on to the caller, where it is optimised once more and becomes machine
code again. Of some 130 functions of a first step 20 are called by Python. What only kernels call gets no wrapper, no
machine code, and but the first round of optimisation, the one that has callees inlined; the kernel that Python
calls is optimised whole, as ever. So are numba's own functions that kernels call.

Of the steps before, those are left out that look for what no kernel has: closures, blocks with a context, expressions
of whole arrays. LLVM's code is the same without them.
"""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING, Any

from llvmlite import binding
from numba.core import codegen, compiler, compiler_machinery, typed_passes, untyped_passes
from numba.core.compiler_lock import global_compiler_lock
from numba.core.runtime import rtsys

from amorsim.kernels.answers import kept_answers

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

__all__ = ["KIND", "KernelCompiler", "PartCompiler", "rebuild_library"]

KIND = "part"
_HAS_BUILDERS = hasattr(codegen.CPUCodegen, "_pass_builder")  # since version 0.61
_PASSES = (
    (untyped_passes.TranslateByteCode, "analyzing bytecode"),
    (untyped_passes.FixupArgs, "fix up args"),
    (untyped_passes.IRProcessing, "processing IR"),
    (untyped_passes.RewriteSemanticConstants, "rewrite semantic constants"),
    (untyped_passes.DeadBranchPrune, "dead branch pruning"),
    (untyped_passes.GenericRewrites, "nopython rewrites"),
    (untyped_passes.ReconstructSSA, "ssa"),
    (typed_passes.NopythonTypeInference, "nopython frontend"),
    (typed_passes.PreLowerStripPhis, "remove phis nodes"),
    (typed_passes.InlineOverloads, "inline overloaded functions"),
    (typed_passes.NoPythonSupportedFeatureValidation, "ensure features that are in use are in a valid form"),
    (typed_passes.IRLegalization, "ensure IR is legal prior to lowering"),
    (typed_passes.AnnotateTypes, "annotate types"),
    (typed_passes.NativeLowering, "native lowering"),
    (typed_passes.NoPythonBackend, "nopython mode backend"),
)


class _Library(codegen.JITCodeLibrary):  # type: ignore[misc, unused-ignore]
    """Code of one kernel and its callees."""

    def _optimize_functions(self, ll_module: Any) -> None:
        if not _HAS_BUILDERS:
            super()._optimize_functions(ll_module)
            return
        ll_module.data_layout = self._codegen._data_layout
        # One for all functions, and none for those that are only declared.
        passes, builder = self._codegen._function_pass_manager()
        for function in ll_module.functions:
            if not function.is_declaration:
                passes.run(function, builder)


class _Nothing:
    """What numba takes for the maker of machine code where there is none that could be told constants."""

    def set_env(self, name: str, environment: Any) -> None:
        """Tell nobody."""


class _PartLibrary(_Library):
    """LLVM's code of a function and its callees, for linking alone."""

    codegen = _Nothing()
    _bitcode: bytes | None = None

    def _optimize_final_module(self) -> None:
        made = self._codegen._module_pass_manager(loop_vectorize=False, slp_vectorize=False, opt=0, cost="cheap")
        passes, *builder = made if isinstance(made, tuple) else (made,)  # older versions of numba give no builder
        passes.run(self._final_module, *builder)

    def _finalize_final_module(self) -> None:
        # That nothing is missing is checked where this has been linked.
        self._finalize_dynamic_globals()
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


class _Compiler(compiler.Compiler):  # type: ignore[misc, unused-ignore]
    """numba's, without the steps that find nothing in kernels."""

    _library: type[_Library]

    def define_pipelines(self) -> list[Any]:
        """The steps from Python's byte code to LLVM's."""
        steps = compiler_machinery.PassManager("kernel")
        for step, what in _PASSES:
            steps.add_pass(step, what)
        steps.finalize()
        return [steps]

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """Compile `func` for the types that this compiler was made for."""
        made_by = self.state.targetctx.codegen()
        self.state.library = self._library(made_by, func.__qualname__)
        self.state.library.enable_object_caching()
        rtsys.initialize(self.state.targetctx)  # which makes machine code, once
        with global_compiler_lock, _parts_only(made_by), kept_answers(self.state.targetctx):
            return super().compile_extra(func)


class KernelCompiler(_Compiler):
    """Makes what Python calls."""

    _library = _Library


class PartCompiler(_Compiler):
    """Leaves LLVM's code in a library for linking."""

    _library = _PartLibrary


@contextlib.contextmanager
def _parts_only(made_by: Any) -> Iterator[None]:
    """Make parts of numba's own functions that are compiled meanwhile, by one thread alone."""
    before = made_by._library_class
    made_by._library_class = _PartLibrary
    try:
        yield
    finally:
        made_by._library_class = before
