"""Users' programs as scenarios name them: checked by their text, and loaded where they are to run."""

from __future__ import annotations

import ast
import inspect
import warnings
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import attrs

from amorsim.core.errors import ControllerError, Fault
from amorsim.plugins.registry import KINDS
from amorsim.scenario.programs.controller_files import (
    check_arguments,
    load_controller,
    load_program,
    no_such_name,
    read_program,
)

__all__ = ["Program", "check_program"]

_Definition = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef


@attrs.frozen
class Program:
    """A function or class in a user's file; nothing of the file has run. A simulation loads it.

    Parameters
    ----------
    path, name
        The file, and the name in it.
    kind
        Of which component it is: ``"controller"``, ``"estimator"`` ...
    place
        Where a scenario names it, for faults.
    folder
        Where relative paths among its options start.
    """

    path: Path
    name: str
    kind: str = attrs.field(default="controller", repr=False)
    place: Fault | None = attrs.field(default=None, eq=False, repr=False)
    folder: Path = attrs.field(factory=Path, eq=False, repr=False)

    def load(self, options: Mapping[str, Any]) -> Any:
        """The function or class itself, by running the file. A component's options are not checked yet.

        Raises
        ------
        ControllerError
            As `load_controller` does.
        """
        found = load_program(self.path, self.name)
        if isinstance(found, type) and issubclass(found, KINDS[self.kind]):
            return found
        return load_controller(self.path, self.name, options, self.kind)

    def fault(self, message: str) -> Fault:
        """A fault of it with this message, at the place that names it."""
        place = self.place or Fault(file="", path="", message="")
        return attrs.evolve(place, message=message)

    def __call__(self, *_: Any, **__: Any) -> Any:
        """Refuse to be called."""
        raise ControllerError(
            f"{self.path}:{self.name} has not been loaded; am.Simulation loads the programs of its scenario"
        )


def check_program(path: Path, name: str, options: Mapping[str, Any], kind: str = "controller") -> Program:
    """The function or class called `name` in a Python file, which must take `options`; nothing runs.

    Raises
    ------
    ControllerError
        If the file is not there, is not Python, or has no such name or does not take the options. What
        only shows when it runs is not found.
    """
    data = read_program(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of odd escapes in texts: Python reports them when the file runs
            tree = ast.parse(data, str(path))
    except SyntaxError as error:
        line = f", line {error.lineno}" if error.lineno else ""
        raise ControllerError(f"{path}{line}: {type(error).__name__}: {error.msg}") from error
    except (ValueError, RecursionError, MemoryError) as error:
        raise ControllerError(f"{path}: {type(error).__name__}: {error}") from error
    found: dict[str, _Definition | None] = {}
    is_open = False
    for key, definition in _names(tree.body):
        is_open |= key == "*"
        found[key] = None if key in found else definition  # of several, it is not known which
    if name not in found and not is_open:
        raise no_such_name(path, name, [key for key, definition in found.items() if definition is not None])
    definition = found.get(name)
    signature = None if definition is None else _signature(definition)
    if definition is not None and signature is not None:
        check_arguments(path, name, signature, isinstance(definition, ast.ClassDef), options, kind)
    return Program(path, name, kind)


def _names(body: Iterable[ast.stmt]) -> Iterator[tuple[str, _Definition | None]]:
    """The names that statements may give to things at the top of a module; "*" where any may be."""
    for node in body:
        if isinstance(node, _Definition):
            yield node.name, node
            continue
        if isinstance(node, ast.Import | ast.ImportFrom):
            yield from ((alias.asname or alias.name.partition(".")[0], None) for alias in node.names)
        if isinstance(node, ast.Expr | ast.Assign | ast.AnnAssign | ast.AugAssign):
            for inner in ast.walk(node):
                if isinstance(inner, ast.Name) and isinstance(inner.ctx, ast.Store):
                    yield inner.id, None
                if isinstance(inner, ast.Name) and inner.id in ("globals", "vars", "exec", "setattr"):
                    yield "*", None
            continue
        for _, value in ast.iter_fields(node):  # within if, try, with, for
            if isinstance(value, list):
                inside = [item for item in value if isinstance(item, ast.stmt)]
                inside += [part for item in value if isinstance(item, ast.ExceptHandler) for part in item.body]
                yield from ((key, None) for key, _ in _names(inside))
            elif isinstance(value, ast.expr):
                yield from ((part.id, None) for part in ast.walk(value) if isinstance(part, ast.Name))


@attrs.frozen
class _Said:
    """A default or an annotation as its author wrote it."""

    text: str

    def __repr__(self) -> str:
        return self.text


def _signature(definition: _Definition) -> inspect.Signature | None:
    """The signature of a function, or of what makes an object of a class; None where its text does not show it."""
    if definition.decorator_list:
        return None
    if not isinstance(definition, ast.ClassDef):
        return inspect.Signature(_parameters(definition.args), return_annotation=_said(definition.returns))
    if definition.bases or definition.keywords:
        return None
    own = {part.name: part for part in definition.body if isinstance(part, _Definition)}
    if "__new__" in own:
        return None
    init = own.get("__init__")
    if init is None:
        return inspect.Signature()
    if isinstance(init, ast.ClassDef) or init.decorator_list:
        return None
    return inspect.Signature(_parameters(init.args)[1:])


def _parameters(args: ast.arguments) -> list[inspect.Parameter]:
    positional = [*args.posonlyargs, *args.args]
    defaults: list[ast.expr | None] = [None] * (len(positional) - len(args.defaults)) + [*args.defaults]
    kinds = inspect.Parameter
    found = [
        _parameter(arg, kinds.POSITIONAL_ONLY if i < len(args.posonlyargs) else kinds.POSITIONAL_OR_KEYWORD, default)
        for i, (arg, default) in enumerate(zip(positional, defaults, strict=True))
    ]
    if args.vararg:
        found.append(_parameter(args.vararg, kinds.VAR_POSITIONAL))
    for arg, default in zip(args.kwonlyargs, args.kw_defaults, strict=True):
        found.append(_parameter(arg, kinds.KEYWORD_ONLY, default))
    if args.kwarg:
        found.append(_parameter(args.kwarg, kinds.VAR_KEYWORD))
    return found


def _parameter(arg: ast.arg, kind: Any, default: ast.expr | None = None) -> inspect.Parameter:
    return inspect.Parameter(arg.arg, kind, default=_said(default), annotation=_said(arg.annotation))


def _said(expression: ast.expr | None) -> Any:
    return inspect.Parameter.empty if expression is None else _Said(ast.unparse(expression))
